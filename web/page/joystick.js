// The drive stick: pointer, touch, held keys and the other hands become one direction (x forward,
// y left, length 0 to 1) and one turn (-1 to 1).
//
// What is held is believed only as long as the page can see it: a browser's menu keeps the key-up
// for itself. A keyboard that repeats held keys must go on repeating the last one.

/** @import {StickValue} from "./frames" */

import { div, element } from "./dom.js";
import { keep, saved } from "./settings.js";
import { beyondDead } from "./stick_values.js";
import { TurnStick } from "./turn_stick.js";

const FIRST_REPEAT = 1200; // ms until a held key repeats at last
const NEXT_REPEAT = 400; // ms between its repeats at last
const LOOK = 100; // ms between looks at the held key
const LOOK_LATE = 300; // ms; later than this the page was busy, and repeats may be waiting
const IGNORED_FOR = 2000; // ms after which an ignored key without a sign is taken as let go
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

/**
 * Something else that a hand holds.
 * @typedef {object} OtherHand
 * @property {boolean} isHeld
 * @property {StickValue} value
 * @property {() => void} letGo
 */

export class Joystick {
  /** @param {(value: StickValue) => void} changed */
  constructor(changed) {
    this.presses = 0; // counted: by a hand, each a sign that it is there
    /** @type {Set<string | number>} */
    this.ignored = new Set(); // keys and pointers still held that move nothing any more
    this.ignoredSeen = 0; // ms, when a key among them last showed itself
    this.repeating = ""; // the last key pressed, which repeats while it is held
    this.believedUntil = Infinity; // ms, unless it repeats
    this.looked = 0;
    this.changed = changed;
    this.pad = div("stick");
    this.knob = div("knob");
    this.turning = new TurnStick(() => this.pressed(), () => this.show());
    /** @type {OtherHand[]} */
    this.others = []; // while one of them is held, nothing else counts
    this.wedge = element("stick-wedge", SVGPathElement);
    this.line = element("stick-line", SVGLineElement);
    /** @type {number | null} */
    this.pointer = null;
    this.drag = { x: 0, y: 0 };
    this.middle = { x: 0, y: 0 }; // px, of the pad where it was grabbed: it may move under the hand
    /** @type {Set<string>} */
    this.keys = new Set();
    this.slow = false;
    this.#listen();
  }

  /**
   * What is asked for now.
   * @returns {StickValue}
   */
  get value() {
    const other = this.others.find((one) => one.isHeld);
    if (other) return other.value;
    const { x, y } = this.pointer === null ? this.#keyed() : this.drag;
    const size = this.slow ? SLOW : 1;
    let turn = this.turning.turn;
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
    this.ignored.delete(code);
    this.repeating = code;
    this.believedUntil = saved.repeats ? performance.now() + FIRST_REPEAT : Infinity;
    this.pressed();
    this.show();
  }

  /** A hand has come, here or elsewhere. */
  pressed() {
    this.presses++;
  }

  /**
   * A held key says that it still is.
   * @param {string} code
   */
  repeat(code) {
    if (this.ignored.has(code)) this.ignoredSeen = performance.now();
    if (code !== this.repeating) return;
    if (!saved.repeats) keep({ repeats: true });
    this.believedUntil = performance.now() + NEXT_REPEAT;
  }

  /**
   * @param {string} code
   * @param {boolean} slow
   */
  lift(code, slow) {
    this.slow = slow;
    this.ignored.delete(code);
    // of several keys only the last one repeats, and none when that is let go
    if (code === this.repeating) this.believedUntil = Infinity;
    this.keys.delete(code);
    this.show();
  }

  /** Keys move nothing before they are pressed anew; whether one did. */
  liftKeys() {
    if (!this.keys.size) return false;
    for (const code of this.keys) this.ignored.add(code);
    this.ignoredSeen = performance.now();
    this.keys.clear();
    this.show();
    return true;
  }

  /** Whether a hand holds anything here, as far as the page can see. */
  get isHeld() {
    const here = this.pointer !== null || this.keys.size > 0 || this.turning.isHeld;
    return here || this.others.some((one) => one.isHeld);
  }

  /** Everything at rest, also a stick that is still held: it moves nothing before it is grabbed anew. */
  letGo() {
    this.liftKeys();
    if (this.pointer !== null) this.ignored.add(this.pointer);
    this.turning.letGo();
    for (const other of this.others) other.letGo();
    this.#release();
  }

  #listen() {
    const { pad } = this;
    pad.addEventListener("pointerdown", (event) => this.#grab(event));
    pad.addEventListener("pointermove", (event) => this.#mine(event) && this.#follow(event));
    document.addEventListener("pointerup", (event) => this.#forget(event.pointerId));
    document.addEventListener("pointercancel", (event) => this.#forget(event.pointerId));
    setInterval(() => this.#look(), LOOK);
    for (const end of /** @type {const} */ (["pointerup", "pointercancel", "lostpointercapture"])) {
      pad.addEventListener(end, (event) => this.#mine(event) && this.#release());
    }
    pad.addEventListener("contextmenu", (event) => event.preventDefault());
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
    this.ignored.clear();
    this.pressed();
    this.pad.setPointerCapture(event.pointerId);
    const box = this.pad.getBoundingClientRect();
    this.middle = { x: box.left + box.width / 2, y: box.top + box.height / 2 };
    this.#move(event);
  }

  /**
   * A mouse that moves without its button was let go where the page could not see it.
   * @param {PointerEvent} event
   */
  #follow(event) {
    if (event.buttons) this.#move(event);
    else this.#release();
  }

  /** @param {number | string} held */
  #forget(held) {
    if (this.ignored.delete(held)) this.show();
  }

  #forgetKeys() {
    for (const held of this.ignored) if (typeof held === "string") this.#forget(held);
  }

  /** The key that should have said it is held and did not is let go, and all others with it. */
  #look() {
    const time = performance.now();
    const busy = time - this.looked > LOOK_LATE;
    this.looked = time;
    if (!busy && time > this.believedUntil && this.keys.size) this.liftKeys();
    if (time > this.ignoredSeen + IGNORED_FOR) this.#forgetKeys();
  }

  /** @param {PointerEvent} event */
  #move(event) {
    const x = -(event.clientY - this.middle.y) / this.#throw();
    const y = -(event.clientX - this.middle.x) / this.#throw();
    const length = Math.hypot(x, y);
    const size = beyondDead(length, DEAD);
    // + 0 makes a plain zero of -0: straight back is then π, not -π
    this.drag = size ? { x: (x / length) * size + 0, y: (y / length) * size + 0 } : { x: 0, y: 0 };
    this.show();
  }

  /** px from the middle to a full throw. */
  #throw() {
    return this.pad.clientWidth / 2 - this.knob.offsetWidth / 2 + OVERLAP;
  }

  #release() {
    this.pointer = null;
    this.drag = { x: 0, y: 0 };
    this.show();
  }

  /** As it is now, on the page and to whoever listens. */
  show() {
    const { x, y } = this.value;
    const active = x !== 0 || y !== 0;
    const reach = this.#throw();
    this.knob.style.transform = `translate(${-y * reach}px, ${-x * reach}px)`;
    this.pad.classList.toggle("held", active || this.pointer !== null);
    this.pad.classList.toggle("ignored", !this.isHeld && this.ignored.size > 0);
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
