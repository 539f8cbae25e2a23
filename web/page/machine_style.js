// Colours, leg names and the margin drawn green, as the server sends them for the machine that
// walks: the page has none of its own.

/** @import {Style} from "./frames" */

const PLAIN = "#9fadbd"; // until the server has spoken

/** @type {Style} */
let style = {
  palette: { legs: [PLAIN], good: PLAIN, warn: PLAIN, bad: PLAIN, path: PLAIN },
  margin_good_m: 0,
  leg_names: [],
};

/** @param {Style} next */
export function takeStyle(next) {
  style = next;
  const { good, warn, bad, path } = next.palette;
  const colours = { good, warn, bad, path };
  for (const [name, colour] of Object.entries(colours)) {
    document.documentElement.style.setProperty(`--${name}`, colour);
  }
}

/** @param {number} leg from 0 */
export const legColour = (leg) => style.palette.legs[leg % style.palette.legs.length] ?? PLAIN;

/**
 * Short names of all legs, in machine order.
 * @param {number} count
 */
export const legNames = (count) =>
  Array.from({ length: count }, (_, leg) => style.leg_names[leg] ?? String(leg + 1));

/**
 * A leg's number with its name.
 * @param {number} number from 1
 */
export function legTitle(number) {
  const name = style.leg_names[number - 1];
  return name ? `${number} ${name}` : String(number);
}

/**
 * A leg's name, or its number where it has none.
 * @param {number} number from 1
 */
export const legName = (number) => style.leg_names[number - 1] ?? `leg ${number}`;

/** @param {number | null} margin m */
export function marginTone(margin) {
  if (margin === null || margin < -0.001) return "bad";
  return margin < style.margin_good_m ? "warn" : "good";
}
