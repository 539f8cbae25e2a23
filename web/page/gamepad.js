// A gamepad of the standard mapping: the left stick goes, the right one turns, and buttons act as
// they are pressed. Browsers say nothing of a pad by themselves, so it is looked at.
//
// It drives only after it was seen at rest: a stick that is held, or stuck, while the pad is plugged
// in or after the page let go moves nothing. A pad that vanishes stops the machine.

/** @import {Joystick} from "./joystick.js" */
/** @import {StickValue} from "./frames" */

import { REST, beyondDead } from "./stick_values.js";

const LOOK = 40; // ms
const DEAD = 0.15; // share of the throw that still counts as rest; smaller: worn sticks creep
const SLOW = 1 / 3; // with the left shoulder
const SLOW_BUTTON = 4;
const AXES = 4;

/**
 * @typedef {object} PadActs
 * @property {(name: string) => void} came
 * @property {() => void} vanished while it drove, or not
 * @property {Record<number, () => void>} buttons by their number in the standard mapping
 */

export class GamepadHand {
  /**
   * @param {Joystick} stick
   * @param {PadActs} acts
   */
  constructor(stick, acts) {
    this.stick = stick;
    this.acts = acts;
    /** @type {StickValue} */
    this.value = REST;
    /** @type {number | null} */
    this.index = null; // of the pad that was here when it was looked at last
    this.armed = false; // seen at rest since it came, or since it was let go of
    /** @type {boolean[]} */
    this.pressed = [];
    stick.others.push(this);
    setInterval(() => this.#look(), LOOK);
  }

  get isHeld() {
    return this.value !== REST;
  }

  letGo() {
    this.armed = false;
    this.value = REST;
  }

  #look() {
    const here = (navigator.getGamepads?.() ?? []).filter(isUsable);
    const known = here.find((pad) => pad.index === this.index);
    if (this.index !== null && !known) this.#lose();
    const pad = known ?? here[0];
    if (!pad) return;
    if (this.index === null) this.#meet(pad);
    this.#push(pad);
    this.#steer(pad);
  }

  #lose() {
    this.index = null;
    this.letGo();
    this.acts.vanished();
  }

  /** @param {Gamepad} pad */
  #meet(pad) {
    this.index = pad.index;
    this.armed = false;
    this.pressed = pad.buttons.map((button) => button.pressed);
    this.acts.came(pad.id);
  }

  /** @param {Gamepad} pad */
  #push(pad) {
    const before = this.pressed;
    this.pressed = pad.buttons.map((button) => button.pressed);
    this.pressed.forEach((down, number) => {
      if (down && !before[number]) this.acts.buttons[number]?.();
    });
  }

  /** @param {Gamepad} pad */
  #steer(pad) {
    const asked = valueOf(pad);
    const rests = asked === REST;
    if (rests) this.armed = true;
    if (!this.armed) return;
    const began = !this.isHeld && !rests;
    const ended = this.isHeld && rests;
    this.value = asked;
    if (began) this.stick.pressed();
    if (!rests || ended) this.stick.show();
  }
}

/**
 * @param {Gamepad | null} pad
 * @returns {pad is Gamepad}
 */
const isUsable = (pad) =>
  pad !== null && pad.connected && pad.mapping === "standard" && pad.axes.length >= AXES;

/**
 * What its sticks ask for; REST itself while they do for nothing.
 * @param {Gamepad} pad
 * @returns {StickValue}
 */
function valueOf({ axes, buttons }) {
  const [right, down, turnRight] = axes.map((axis) => (Number.isFinite(axis) ? axis : 0));
  const length = Math.hypot(right, down);
  const slow = buttons[SLOW_BUTTON]?.pressed ? SLOW : 1;
  const size = length ? (slow * beyondDead(length, DEAD)) / length : 0;
  const turn = -Math.sign(turnRight) * beyondDead(Math.abs(turnRight), DEAD) * slow;
  // + 0 makes a plain zero of -0: straight back is then π, not -π
  return size || turn ? { x: -down * size + 0, y: -right * size + 0, turn: turn + 0 } : REST;
}
