// The scene in its frame: our own menu works viser's (hidden) switches, which are this viewer's
// alone.

import { element } from "./dom.js";

const TRIES = 40;
const TRY_AGAIN = 250; // ms
const LOOK_AGAIN = 700; // ms; a reconnected viewer gets new switches
const LABEL_DEPTH = 5; // elements above a switch in which its label is looked for
const STYLE = `
  .mantine-Notifications-root, .mantine-Paper-root { display: none !important; }
  canvas { outline: none; }
  .paints canvas { cursor: crosshair !important; }
`;

export class ViserFrame {
  constructor() {
    this.frame = element("view", HTMLIFrameElement);
    /** @type {Map<string, boolean>} */
    this.wanted = new Map();
    this.painting = false;
    this.frame.addEventListener("load", () => this.#dress());
    if (this.#document?.readyState === "complete") this.#dress();
    setInterval(() => this.#apply(), LOOK_AGAIN);
  }

  get #document() {
    try {
      return this.frame.contentDocument;
    } catch {
      return null;
    }
  }

  /**
   * Work one of the viewer's switches.
   * @param {string} label
   * @param {boolean} on
   */
  set(label, on) {
    this.wanted.set(label, on);
    this.#apply();
  }

  /** @param {boolean} on whether clicks paint */
  paints(on) {
    this.painting = on;
    this.#document?.documentElement.classList.toggle("paints", on);
  }

  /** Bring the camera back to its first look. */
  home() {
    for (const button of this.#document?.querySelectorAll("button") ?? []) {
      if (button.textContent?.trim() === "Home") button.click();
    }
  }

  #dress(tries = TRIES) {
    const page = this.#document;
    if (!page?.head) {
      if (tries) setTimeout(() => this.#dress(tries - 1), TRY_AGAIN);
      return;
    }
    if (page.getElementById("console-style")) return;
    const style = page.createElement("style");
    style.id = "console-style";
    style.textContent = STYLE;
    page.head.append(style);
    this.paints(this.painting);
  }

  #apply() {
    if (!this.wanted.size) return;
    const boxes = this.#document?.querySelectorAll("input[type=checkbox]") ?? [];
    for (const box of /** @type {Iterable<HTMLInputElement>} */ (boxes)) {
      const wanted = this.wanted.get(labelOf(box));
      if (wanted !== undefined && box.checked !== wanted) box.click();
    }
  }
}

/** @param {Element} box */
function labelOf(box) {
  let above = box.parentElement;
  for (let up = 0; above && up < LABEL_DEPTH; up++) {
    const text = above.textContent?.trim();
    if (text) return text;
    above = above.parentElement;
  }
  return "";
}
