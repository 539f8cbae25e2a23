// The menu of what is drawn, and the panels of the page.

/** @import {TimeSeries} from "./time_series.js" */
/** @import {ViserFrame} from "./viser_frame.js" */

import { button, buttons, div, input, mark } from "./dom.js";
import { onPress } from "./press.js";
import { keep, saved } from "./settings.js";

const ROOMY = "(min-width: 700px) and (min-height: 521px)"; // where the strips are shown at first

const FIRST = "follow";

export class ViewMenu {
  /**
   * @param {ViserFrame} scene
   * @param {TimeSeries} series
   */
  constructor(scene, series) {
    this.scene = scene;
    this.series = series;
    this.menu = div("view-menu");
    this.opener = button("view-button");
    onPress(this.opener, () => this.toggle());
    document.addEventListener("pointerdown", (event) => this.#closeOutside(event));
    onPress(button("home"), () => scene.home());
    for (const box of document.querySelectorAll("[data-layer]")) {
      if (box instanceof HTMLInputElement) this.#wireLayer(box);
    }
    this.cameras = buttons("#cameras button");
    for (const one of this.cameras) onPress(one, () => this.#takeCamera(one.dataset.camera ?? FIRST));
    this.#takeCamera(saved.camera ?? FIRST);
    this.#wireStrips();
    this.#wireTheme();
  }

  /** @param {string} camera */
  #takeCamera(camera) {
    this.camera = camera;
    keep({ camera });
    mark(this.cameras, "camera", camera, "aria-checked");
    for (const { dataset } of this.cameras) {
      this.scene.set(`Camera ${dataset.camera}`, dataset.camera === camera);
    }
  }

  nextCamera() {
    const at = this.cameras.findIndex((one) => one.dataset.camera === this.camera);
    this.#takeCamera(this.cameras[(at + 1) % this.cameras.length].dataset.camera ?? FIRST);
  }

  get isOpen() {
    return !this.menu.hidden;
  }

  toggle(open = !this.isOpen) {
    this.menu.hidden = !open;
    this.opener.setAttribute("aria-expanded", String(open));
  }

  /** @param {PointerEvent} event */
  #closeOutside(event) {
    const inside = event.target instanceof Element && event.target.closest("#view-menu, #view-button");
    if (this.isOpen && !inside) this.toggle(false);
  }

  /** @param {HTMLInputElement} box */
  #wireLayer(box) {
    const label = box.dataset.layer ?? "";
    const kept = saved.layers?.[label];
    if (kept !== undefined) {
      box.checked = kept;
      this.scene.set(label, kept);
    }
    box.addEventListener("change", () => {
      this.scene.set(label, box.checked);
      keep({ layers: { ...saved.layers, [label]: box.checked } });
    });
  }

  #wireTheme() {
    const light = input("light-theme");
    light.checked = saved.light ?? false;
    const show = () => {
      document.documentElement.dataset.theme = light.checked ? "light" : "dark";
      this.scene.set("Light", light.checked);
      window.dispatchEvent(new Event("restyled"));
    };
    light.addEventListener("change", () => {
      show();
      keep({ light: light.checked });
    });
    show();
  }

  #wireStrips() {
    const strips = input("show-strips");
    strips.checked = saved.strips ?? matchMedia(ROOMY).matches;
    const show = () => {
      document.body.classList.toggle("no-strips", !strips.checked);
      this.series.visible = strips.checked;
    };
    strips.addEventListener("change", () => {
      show();
      keep({ strips: strips.checked });
    });
    show();
  }
}
