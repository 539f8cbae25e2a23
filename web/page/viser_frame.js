// The scene in its frame: our own menu works viser's (hidden) switches, which are this viewer's
// alone.

import { element } from "./dom.js";

const TRIES = 40;
const TRY_AGAIN = 250; // ms
const LOOK_AGAIN = 700; // ms; a reconnected viewer gets new switches
const SOFTWARE = /swiftshader|llvmpipe|software|basic render/i;
const SOFTWARE_PIXELS = 450_000; // what a processor draws several times a second
const COARSEST = 0.5; // px drawn for one of the screen
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
    this.frame.src = sceneAddress();
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

  /** Where the last click on the ground pointed, as "x y" in m; "" before any. */
  get pointed() {
    const boxes = this.#document?.querySelectorAll("input:not([type])") ?? [];
    for (const box of /** @type {Iterable<HTMLInputElement>} */ (boxes)) {
      if (labelOf(box) === "Pointed") return box.value;
    }
    return "";
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

/** Fewer pixels where no graphics card draws them: the page's thread waits for each. */
function sceneAddress() {
  const sharp = new URLSearchParams(location.search).has("sharp");
  if (sharp || !isDrawnBySoftware()) return "view/";
  const pixels = window.innerWidth * window.innerHeight;
  const share = Math.max(Math.sqrt(SOFTWARE_PIXELS / pixels), COARSEST);
  return `view/?fixedDpr=${Math.min(share, window.devicePixelRatio).toFixed(2)}`;
}

function isDrawnBySoftware() {
  const gl = document.createElement("canvas").getContext("webgl");
  const names = gl?.getExtension("WEBGL_debug_renderer_info");
  const name = gl && names ? String(gl.getParameter(names.UNMASKED_RENDERER_WEBGL)) : "";
  gl?.getExtension("WEBGL_lose_context")?.loseContext();
  return SOFTWARE.test(name);
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
