// Keys: held ones drive, the others are shortcuts. The scene's frame hands its own on to this page.

/** @import {Joystick} from "./joystick.js" */

import { element } from "./dom.js";
import { isDrivingKey } from "./joystick.js";

const FIELDS = "select, textarea, input:not([type=checkbox]):not([type=range])";
const RATE_KEY = /^Digit([1-8])$/;

/**
 * @typedef {object} Keys
 * @property {() => void} stop
 * @property {() => boolean} closeMenu whether one was open
 * @property {() => void} help
 * @property {(rate: number) => void} rate
 * @property {Record<string, () => void>} shortcuts by key code
 */

/** @param {EventTarget | null} target */
const isField = (target) => target instanceof Element && target.matches(FIELDS);

/**
 * @param {Joystick} stick
 * @param {Keys} keys
 */
export function listenToKeys(stick, keys) {
  const help = element("help", HTMLDialogElement);
  document.addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    if (help.open || isField(event.target)) return;
    if (press(stick, keys, event)) event.preventDefault();
  });
  document.addEventListener("keyup", (event) => {
    // a focused button must not be pressed by the stop key
    if (event.code === "Space") event.preventDefault();
    stick.lift(event.code, event.shiftKey);
  });
}

/**
 * What a key does; whether it did anything.
 * @param {Joystick} stick
 * @param {Keys} keys
 * @param {KeyboardEvent} event
 */
function press(stick, keys, { code, key, repeat, shiftKey }) {
  if (code === "Escape" && keys.closeMenu()) return true;
  if (isDrivingKey(code)) {
    if (!repeat) stick.press(code, shiftKey);
    return true;
  }
  const act = actionOf(keys, code, key);
  if (act && !repeat) act();
  return act !== undefined;
}

/**
 * @param {Keys} keys
 * @param {string} code
 * @param {string} key
 */
function actionOf(keys, code, key) {
  if (code === "Space" || code === "Escape") return keys.stop;
  if (key === "?") return keys.help;
  const rate = RATE_KEY.exec(code)?.[1];
  return rate ? () => keys.rate(Number(rate)) : keys.shortcuts[code];
}
