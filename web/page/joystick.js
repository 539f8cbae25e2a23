// The drive stick: pointer, touch and held keys become one direction (x forward, y left, length 0
// to 1) and one turn (-1 to 1).

/** @import {StickValue} from "./frames" */

import { div, element, input } from "./dom.js";

const DEAD = 0.1; // share of the throw that still counts as rest
const SLOW = 1 / 3; // with Shift
const ARC = 88; // radius of the crab angle's arc in the stick's drawing
const SHAFT = 70; // length of the line to the knob in it
const OVERLAP = 8; // px the knob may stand over the rim

/** @type {Record<string, [number, number]>} */
const DIRECTIONS = {
  KeyW: [1, 0], ArrowUp: [1, 0],
  KeyS: [-1, 0], ArrowDown: [-1, 0],
  KeyA: [0, 1], ArrowLeft: [0, 1],
  KeyD: [0, -1], ArrowRight: [0, -1],
};
/** @type {Record<string, number>} */
const TURNS = { KeyQ: 1, KeyE: -1 };

/** @param {string} code */
export const isDrivingKey = (code) => code in DIRECTIONS || code in TURNS;

export class Joystick {
  /** @param {(value: StickValue) => void} changed */
  constructor(changed) {
    this.changed = changed;
    this.pad = div("stick");
    this.knob = div("knob");
    this.slider = input("turn-slider");
    this.wedge = element("stick-wedge", SVGPathElement);
    this.line = element("stick-line", SVGLineElement);
    /** @type {number | null} */
    this.pointer = null;
    this.drag = { x: 0, y: 0 };
    /** @type {Set<string>} */
    this.keys = new Set();
    this.slow = false;
    this.slide = 0;
    this.#listen();
  }

  /**
   * What is asked for now.
   * @returns {StickValue}
   */
  get value() {
    const { x, y } = this.pointer === null ? this.#keyed() : this.drag;
    const size = this.slow ? SLOW : 1;
    let turn = this.slide;
    for (const code of this.keys) turn += (TURNS[code] ?? 0) * size;
    return { x, y, turn: Math.max(-1, Math.min(1, turn)) };
  }

  #keyed() {
    let [x, y] = [0, 0];
    for (const code of this.keys) {
      const [dx, dy] = DIRECTIONS[code] ?? [0, 0];
      x += dx;
      y += dy;
    }
    const size = (this.slow ? SLOW : 1) / (Math.hypot(x, y) || 1);
    return { x: x * size, y: y * size };
  }

  /**
   * @param {string} code
   * @param {boolean} slow
   */
  press(code, slow) {
    this.slow = slow;
    if (this.keys.has(code)) return;
    this.keys.add(code);
    this.#show();
  }

  /**
   * @param {string} code
   * @param {boolean} slow
   */
  lift(code, slow) {
    this.slow = slow;
    if (this.keys.delete(code)) this.#show();
  }

  liftKeys() {
    if (!this.keys.size) return;
    this.keys.clear();
    this.#show();
  }

  /** Everything at rest, also a stick that is still held: it moves nothing before it is grabbed anew. */
  letGo() {
    this.keys.clear();
    this.#straighten();
    this.#release();
  }

  #listen() {
    const { pad, slider } = this;
    pad.addEventListener("pointerdown", (event) => this.#grab(event));
    pad.addEventListener("pointermove", (event) => this.#mine(event) && this.#move(event));
    for (const end of /** @type {const} */ (["pointerup", "pointercancel", "lostpointercapture"])) {
      pad.addEventListener(end, (event) => this.#mine(event) && this.#release());
    }
    pad.addEventListener("contextmenu", (event) => event.preventDefault());
    slider.addEventListener("input", () => {
      this.slide = -Number(slider.value);
      this.#show();
    });
    for (const end of ["pointerup", "pointercancel", "lostpointercapture", "blur", "keyup"]) {
      slider.addEventListener(end, () => {
        this.#straighten();
        this.#show();
      });
    }
  }

  /** @param {PointerEvent} event */
  #mine(event) {
    return event.pointerId === this.pointer;
  }

  /** @param {PointerEvent} event */
  #grab(event) {
    if (this.pointer !== null || (event.pointerType === "mouse" && event.button !== 0)) return;
    event.preventDefault();
    this.pad.focus({ preventScroll: true });
    this.pointer = event.pointerId;
    this.pad.setPointerCapture(event.pointerId);
    this.#move(event);
  }

  /** @param {PointerEvent} event */
  #move(event) {
    const box = this.pad.getBoundingClientRect();
    const x = -(event.clientY - box.top - box.height / 2) / this.#throw();
    const y = -(event.clientX - box.left - box.width / 2) / this.#throw();
    const length = Math.hypot(x, y);
    const size = Math.min(Math.max((length - DEAD) / (1 - DEAD), 0), 1);
    // + 0 makes a plain zero of -0: straight back is then π, not -π
    this.drag = size ? { x: (x / length) * size + 0, y: (y / length) * size + 0 } : { x: 0, y: 0 };
    this.#show();
  }

  /** px from the middle to a full throw. */
  #throw() {
    return this.pad.clientWidth / 2 - this.knob.offsetWidth / 2 + OVERLAP;
  }

  #release() {
    this.pointer = null;
    this.drag = { x: 0, y: 0 };
    this.#show();
  }

  #straighten() {
    this.slide = 0;
    this.slider.value = "0";
  }

  #show() {
    const { x, y } = this.value;
    const active = x !== 0 || y !== 0;
    const reach = this.#throw();
    this.knob.style.transform = `translate(${-y * reach}px, ${-x * reach}px)`;
    this.pad.classList.toggle("held", active || this.pointer !== null);
    this.line.setAttribute("x2", String(-y * SHAFT));
    this.line.setAttribute("y2", String(-x * SHAFT));
    this.wedge.setAttribute("d", active ? arc(Math.atan2(y, x)) : "");
    this.changed(this.value);
  }
}

/**
 * From straight ahead to the crab angle, just inside the rim.
 * @param {number} angle rad, to the left
 */
function arc(angle) {
  const x = (-Math.sin(angle) * ARC).toFixed(1);
  const y = (-Math.cos(angle) * ARC).toFixed(1);
  return `M0 -${ARC}A${ARC} ${ARC} 0 0 ${angle > 0 ? 0 : 1} ${x} ${y}`;
}
