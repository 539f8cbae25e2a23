// Grounds and robots of one's own: dropped on the page or chosen, sent, read by the server, and
// walked on; and what was walked, saved as a page.

import { ask, order } from "./api.js";
import { button, div, element, input, make } from "./dom.js";
import { onPress } from "./press.js";
import { say } from "./status.js";

const SAVED_SECONDS = 30;
const CRAB_LEGS = 4;
const CELL = 0.05; // m, of pictures, which say none
const PICTURE_HEIGHT = 0.3; // m for white

/** @typedef {{name: string, kind?: string, note?: string, needs?: string, legs?: number}} Understood */

export class OwnFiles {
  /** @param {() => void} letGo called before another world is loaded */
  constructor(letGo) {
    this.letGo = letGo;
    this.dialog = element("own-files", HTMLDialogElement);
    this.list = div("own-list");
    onPress(button("own-button"), () => this.dialog.showModal());
    onPress(button("save-walk"), () => this.saveWalk());
    const chosen = input("own-input");
    chosen.addEventListener("change", () => this.bring(chosen.files));
    document.addEventListener("dragover", (event) => event.preventDefault());
    document.addEventListener("drop", (event) => {
      event.preventDefault();
      this.bring(event.dataTransfer?.files ?? null);
    });
  }

  /** @param {FileList | null} files */
  async bring(files) {
    if (!files?.length) return;
    if (!this.dialog.open) this.dialog.showModal();
    for (const file of files) await this.#send(file);
  }

  /** @param {File} file */
  async #send(file) {
    const row = make("li", "", "own");
    row.append(make("b", file.name), make("p", "reading …"));
    this.list.prepend(row);
    try {
      const form = new FormData();
      form.append("file", file);
      const answer = await fetch("api/v1/uploads", { method: "POST", body: form });
      const data = await answer.json();
      row.lastElementChild?.remove();
      if (answer.ok) this.#show(row, file, data[0]);
      else row.append(...faultsOf(data).map((fault) => make("p", fault, "bad")));
    } catch (error) {
      row.lastElementChild?.remove();
      row.append(make("p", error instanceof Error ? error.message : String(error), "bad"));
    }
  }

  /**
   * @param {Element} row
   * @param {File} file
   * @param {Understood} understood
   */
  #show(row, file, understood) {
    if (/\.(png|jpe?g|bmp)$/i.test(file.name)) {
      const picture = document.createElement("img");
      picture.src = URL.createObjectURL(file);
      picture.alt = `The heights of ${file.name}, white is high`;
      picture.addEventListener("load", () => URL.revokeObjectURL(picture.src));
      row.append(picture);
    }
    row.append(make("p", understood.note || understood.needs || ""));
    if (understood.needs) row.append(make("p", "Scenarios name it with that key.", "dim"));
    else if (understood.kind !== "hand") row.append(this.#walkButton(understood));
  }

  /** @param {Understood} understood */
  #walkButton(understood) {
    const go = make("button", understood.kind === "robot" ? "Walk with it" : "Walk on it", "small");
    go.addEventListener("click", () => this.#walk(understood));
    return go;
  }

  /** @param {Understood} understood */
  async #walk(understood) {
    this.letGo();
    const scenario = understood.kind === "robot" ? withRobot(understood) : onGround(understood);
    if (await order(say, "PUT", "console/scenario", { scenario })) this.dialog.close();
  }

  /** The last half minute as a page that needs no server. */
  async saveWalk() {
    say("Drawing the last half minute …");
    const answer = await fetch(`api/v1/console/recording/replay.html?seconds=${SAVED_SECONDS}`);
    if (!answer.ok) {
      const { detail } = await answer.json().catch(() => ({}));
      say(detail ?? `${answer.status} ${answer.statusText}`);
      return;
    }
    const link = document.createElement("a");
    link.href = URL.createObjectURL(await answer.blob());
    link.download = "walk.html";
    link.click();
    setTimeout(() => URL.revokeObjectURL(link.href), 10_000);
    say("Saved as walk.html");
  }

  /** What was brought before. */
  async fill() {
    try {
      const { uploads } = await ask("GET", "uploads");
      if (uploads.length) this.list.append(make("li", `Kept: ${uploads.join(", ")}`, "dim"));
    } catch {
      // the list is a courtesy: the page works without
    }
  }
}

/** @param {{detail?: string, errors?: {message: string}[]}} problem */
function faultsOf({ detail, errors }) {
  const faults = (errors ?? []).map((error) => error.message);
  return faults.length ? faults : [detail ?? "it could not be read"];
}

/** @param {Understood} understood */
const withRobot = ({ name, legs }) => ({
  title: name,
  robot: name,
  planner: legs === CRAB_LEGS ? "crab" : "trace",
  terrain: { kind: "flat" },
});

/** @param {Understood} understood */
function onGround({ name, note = "" }) {
  const picture = /picture/.test(note) ? { cell: CELL, scale: PICTURE_HEIGHT } : {};
  return { title: name, terrain: { kind: "file", file: name, ...picture } };
}
