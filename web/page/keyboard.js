// Keys: held ones drive, the others are shortcuts, and Space stops. The scene's frame hands its own
// on to this page. Buttons and switches are worked with Enter, since Space is taken.

/** @import {Joystick} from "./joystick.js" */

import { isDrivingKey } from "./joystick.js";

const FIELDS = "select, textarea, input:not([type=checkbox]):not([type=range])";
const OPENS_MENUS = /^(Alt|Control|Meta|ContextMenu|F\d)/; // key-ups may go elsewhere from here on
const SLIDES = /^(Arrow|Home|End|Page)/;
const RATE_KEY = /^Digit([1248])$/; // those that have a button

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
 * Whether a focused slider is moved by the key.
 * @param {KeyboardEvent} event
 */
const isSliding = ({ target, key }) =>
  target instanceof HTMLInputElement && target.type === "range" && SLIDES.test(key);

/**
 * @param {Joystick} stick
 * @param {Keys} keys
 */
export function listenToKeys(stick, keys) {
  // before any other rule, and before anything else hears of it: lists, dialogs, buttons
  window.addEventListener("keydown", (event) => stopKey(keys, event), true);
  document.addEventListener("keydown", (event) => {
    if (OPENS_MENUS.test(event.code)) stick.liftKeys();
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    if (document.querySelector("dialog[open]") || isField(event.target) || isSliding(event)) return;
    if (switched(event) || press(stick, keys, event)) event.preventDefault();
  });
  document.addEventListener("keyup", (event) => {
    // a focused button must not be pressed by the stop key
    if (event.code === "Space") event.preventDefault();
    stick.lift(event.code, event.shiftKey);
  });
}

/**
 * Space stops wherever the focus is.
 * @param {Keys} keys
 * @param {KeyboardEvent} event
 */
function stopKey(keys, event) {
  if (event.code !== "Space") return;
  event.preventDefault();
  event.stopImmediatePropagation();
  if (!event.repeat) keys.stop();
}

/**
 * Enter works a switch; whether it did.
 * @param {KeyboardEvent} event
 */
function switched({ code, target, repeat }) {
  const isSwitch = target instanceof HTMLInputElement && target.type === "checkbox";
  if (code !== "Enter" || !isSwitch) return false;
  if (!repeat) target.click();
  return true;
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
    if (repeat) stick.repeat(code);
    else stick.press(code, shiftKey);
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
  if (code === "Escape") return keys.stop;
  if (key === "?") return keys.help;
  const rate = RATE_KEY.exec(code)?.[1];
  return rate ? () => keys.rate(Number(rate)) : keys.shortcuts[code];
}
