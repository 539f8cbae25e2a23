// A course in figures: crab angle and speed from two boxes, walked while a button is held.

/** @import {Joystick} from "./joystick.js" */
/** @import {StickValue} from "./frames" */

import { button, input } from "./dom.js";

const REST = { x: 0, y: 0, turn: 0 };

export class ExactCourse {
  /** @param {Joystick} stick */
  constructor(stick) {
    this.stick = stick;
    this.angle = input("course-angle");
    this.speed = input("course-speed");
    this.button = button("course-go");
    /** @type {number | string | null} */
    this.holder = null; // a pointer or a key
    stick.others.push(this);
    this.#listen();
  }

  get isHeld() {
    return this.holder !== null;
  }

  /** @returns {StickValue} */
  get value() {
    if (!this.isHeld) return REST;
    const angle = (this.angle.valueAsNumber * Math.PI) / 180;
    return { x: Math.cos(angle), y: Math.sin(angle), turn: 0, speed: this.speed.valueAsNumber };
  }

  letGo() {
    this.holder = null;
    this.button.setAttribute("aria-pressed", "false");
  }

  #listen() {
    this.button.addEventListener("pointerdown", (event) => {
      if (event.button !== 0) return;
      this.button.setPointerCapture(event.pointerId);
      this.#hold(event.pointerId);
    });
    for (const end of /** @type {const} */ (["pointerup", "pointercancel", "lostpointercapture"])) {
      this.button.addEventListener(end, ({ pointerId }) => this.#lift(pointerId));
    }
    this.button.addEventListener("keydown", ({ key, repeat }) => {
      if (key === "Enter" && !repeat) this.#hold(key);
    });
    this.button.addEventListener("keyup", ({ key }) => this.#lift(key));
    this.button.addEventListener("blur", () => this.#lift(this.holder));
    this.button.addEventListener("contextmenu", (event) => event.preventDefault());
  }

  /** @param {number | string} holder */
  #hold(holder) {
    const boxes = [this.angle, this.speed];
    if (this.isHeld || !boxes.every((box) => box.reportValidity())) return;
    this.holder = holder;
    this.button.setAttribute("aria-pressed", "true");
    this.stick.pressed();
    this.stick.show();
  }

  /** @param {number | string | null} holder */
  #lift(holder) {
    if (holder === null || holder !== this.holder) return;
    this.letGo();
    this.stick.show();
  }
}
