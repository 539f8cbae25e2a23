// The second hand: turns to the left and right while it is held, and springs back. A slider for mice
// and keys; where fingers drive, a stick of its own.

import { div, input } from "./dom.js";
import { beyondDead } from "./stick_values.js";

const DEAD = 0.12; // share of the throw that still counts as rest

export class TurnStick {
  /**
   * @param {() => void} pressed a hand has come
   * @param {() => void} changed
   */
  constructor(pressed, changed) {
    this.pressed = pressed;
    this.changed = changed;
    this.turn = 0; // -1, right, to 1, left
    this.slider = input("turn-slider");
    this.pad = div("turn-stick");
    this.knob = div("turn-knob");
    /** @type {number | null} */
    this.pointer = null;
    this.middle = 0; // px, where the pad was when it was grabbed
    this.#listenToSlider();
    this.#listenToPad();
  }

  /** Whether a hand holds it. */
  get isHeld() {
    return this.pointer !== null || this.turn !== 0;
  }

  /** At rest; a finger that still lies on it turns nothing before it comes anew. */
  letGo() {
    this.pad.classList.toggle("ignored", this.pointer !== null);
    this.pointer = null;
    this.#to(0);
  }

  #listenToSlider() {
    const { slider } = this;
    slider.addEventListener("pointerdown", this.pressed);
    slider.addEventListener("keydown", this.pressed);
    slider.addEventListener("input", () => this.#move(-Number(slider.value)));
    for (const end of ["pointerup", "pointercancel", "lostpointercapture", "blur", "keyup"]) {
      slider.addEventListener(end, () => this.#move(0));
    }
  }

  #listenToPad() {
    const { pad } = this;
    pad.addEventListener("pointerdown", (event) => this.#grab(event));
    pad.addEventListener("pointermove", (event) => {
      if (event.pointerId !== this.pointer) return;
      this.#move(event.buttons ? this.#turnAt(event.clientX) : 0);
    });
    for (const end of /** @type {const} */ (["pointerup", "pointercancel", "lostpointercapture"])) {
      pad.addEventListener(end, ({ pointerId }) => this.#lift(pointerId));
    }
    pad.addEventListener("contextmenu", (event) => event.preventDefault());
  }

  /** @param {PointerEvent} event */
  #grab(event) {
    if (this.pointer !== null || (event.pointerType === "mouse" && event.button !== 0)) return;
    event.preventDefault();
    this.pointer = event.pointerId;
    this.pad.classList.remove("ignored");
    this.pad.setPointerCapture(event.pointerId);
    const box = this.pad.getBoundingClientRect();
    this.middle = box.left + box.width / 2;
    this.pressed();
    this.#move(this.#turnAt(event.clientX));
  }

  /** px from the middle to a full throw. */
  #throw() {
    return (this.pad.clientWidth - this.knob.offsetWidth) / 2;
  }

  /** @param {number} x px on the page */
  #turnAt(x) {
    const share = Math.max(-1, Math.min(1, (this.middle - x) / this.#throw()));
    return Math.sign(share) * beyondDead(Math.abs(share), DEAD);
  }

  /** @param {number} pointer */
  #lift(pointer) {
    this.pad.classList.remove("ignored");
    if (pointer !== this.pointer) return;
    this.pointer = null;
    this.#move(0);
  }

  /** @param {number} turn */
  #move(turn) {
    this.#to(turn);
    this.changed();
  }

  /** @param {number} turn */
  #to(turn) {
    this.turn = turn;
    this.slider.value = String(-turn);
    this.knob.style.transform = `translateX(${-turn * this.#throw()}px)`;
    this.pad.classList.toggle("held", turn !== 0 || this.pointer !== null);
  }
}
