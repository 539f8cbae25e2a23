// The worker that owns the socket, as the rest of the page talks to it.

/** @import {Command, DropReason, Health, LinkState, PageMessage, Posture, ServerFrame, WorkerMessage} from "./frames" */

/**
 * @typedef {object} Listener
 * @property {(state: LinkState) => void} link
 * @property {(health: Health) => void} health
 * @property {(press: number, reason: DropReason) => void} dropped a press that moves nothing any more
 * @property {(frame: ServerFrame) => void} frame
 */

export class DriveLink {
  /** @param {Listener} listener */
  constructor(listener) {
    this.worker = new Worker("drive-worker.js", { type: "module" });
    this.worker.onmessage = (/** @type {MessageEvent<WorkerMessage>} */ { data }) => {
      if (data.type === "link") listener.link(data.state);
      else if (data.type === "health") listener.health(data.health);
      else if (data.type === "dropped") listener.dropped(data.press, data.reason);
      else listener.frame(data.frame);
    };
  }

  /** @param {PageMessage} message */
  #say(message) {
    this.worker.postMessage(message);
  }

  /**
   * @param {Command} command
   * @param {number} press the number of the press it comes from
   */
  drive(command, press) {
    this.#say({ type: "command", command, press });
  }

  /**
   * A sign of life, and what the stick says meanwhile.
   * @param {Command} command
   * @param {number} press
   */
  alive(command, press) {
    this.#say({ type: "alive", command, press });
  }

  /** @param {Posture} posture */
  pose(posture) {
    this.#say({ type: "posture", posture });
  }

  release() {
    this.#say({ type: "release" });
  }

  stop() {
    this.#say({ type: "stop" });
  }

  take() {
    this.#say({ type: "take" });
  }

  rearm() {
    this.#say({ type: "rearm" });
  }
}
