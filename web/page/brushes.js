// Changing the ground: a brush in hand makes clicks on the scene paint.

/** @import {ViserFrame} from "./viser_frame.js" */

import { button, buttons, div, input, mark } from "./dom.js";
import { onPress } from "./press.js";
import { keep, saved } from "./settings.js";

const FIRST = "dig";

export class Brushes {
  /** @param {ViserFrame} scene */
  constructor(scene) {
    this.scene = scene;
    this.bar = div("brushes");
    this.opens = () => {};
    this.opener = button("brush-button");
    this.brushes = buttons("[data-brush]");
    onPress(this.opener, () => this.toggle());
    for (const one of this.brushes) {
      onPress(one, () => {
        keep({ brush: one.dataset.brush });
        this.#take(one.dataset.brush ?? FIRST);
      });
    }
    const wide = input("wide-brush");
    wide.addEventListener("change", () => scene.set("Wide brush", wide.checked));
  }

  get isOpen() {
    return !this.bar.hidden;
  }

  toggle(open = !this.isOpen) {
    if (open) this.opens();
    this.bar.hidden = !open;
    this.opener.setAttribute("aria-expanded", String(open));
    this.#take(open ? (saved.brush ?? FIRST) : "");
  }

  /** @param {string} brush "": none */
  #take(brush) {
    mark(this.brushes, "brush", brush, "aria-checked");
    for (const { dataset } of this.brushes) {
      this.scene.set(`Paint ${dataset.brush}`, dataset.brush === brush);
    }
    this.scene.paints(Boolean(brush));
  }
}
