// The worker that owns the socket, as the rest of the page talks to it.

/** @import {Command, LinkState, PageMessage, Posture, ServerFrame, WorkerMessage} from "./frames" */

/**
 * @typedef {object} Listener
 * @property {(state: LinkState) => void} link
 * @property {(frame: ServerFrame) => void} frame
 */

export class DriveLink {
  /** @param {Listener} listener */
  constructor(listener) {
    this.worker = new Worker("drive-worker.js", { type: "module" });
    this.worker.onmessage = (/** @type {MessageEvent<WorkerMessage>} */ { data }) => {
      if (data.type === "link") listener.link(data.state);
      else listener.frame(data.frame);
    };
  }

  /** @param {PageMessage} message */
  #say(message) {
    this.worker.postMessage(message);
  }

  /** @param {Command} command */
  drive(command) {
    this.#say({ type: "command", command });
  }

  /**
   * A sign of life, and what the stick says meanwhile.
   * @param {Command} command
   */
  alive(command) {
    this.#say({ type: "alive", command });
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
