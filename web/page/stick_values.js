// What all hands share: rest, and how much of a throw counts.

/** @import {StickValue} from "./frames" */

/** @type {StickValue} */
export const REST = { x: 0, y: 0, turn: 0 };

/**
 * A throw beyond its dead zone, 0 to 1.
 * @param {number} length share of the full throw
 * @param {number} dead share of it that still counts as rest
 */
export const beyondDead = (length, dead) =>
  Math.min(Math.max((length - dead) / (1 - dead), 0), 1);
