// What this browser keeps for its user between visits; without storage, for this visit.

/** @import {Saved} from "./frames" */

const KEY = "walking-console";

/** @type {Saved} */
export const saved = read();

/** @returns {Saved} */
function read() {
  try {
    return JSON.parse(localStorage.getItem(KEY) ?? "{}");
  } catch {
    return {}; // no storage here, or not ours
  }
}

/** @param {Saved} more */
export function keep(more) {
  Object.assign(saved, more);
  try {
    localStorage.setItem(KEY, JSON.stringify(saved));
  } catch {
    // private windows may refuse
  }
}
