// Who drives, whether everything is stopped, and the button that stops it.

/** @import {LeaseFrame} from "./frames" */

import { button, div, write } from "./dom.js";

const SHOWN_ELSEWHERE = ["out_of_order", "centre_first", "stopped", "stale"]; // stick and button say it

/** @type {Omit<LeaseFrame, "type">} */
export const NO_LEASE = { held: false, holder: null, holder_title: null, stopped: false };

const PROGRAM = "rest"; // who drives while a REST command lives

/**
 * @param {Omit<LeaseFrame, "type">} lease
 * @param {string} ours the name of this page's socket
 * @param {boolean} watches whether it may watch and stop, not drive
 */
export function showLease(lease, ours, watches) {
  const { held, holder, stopped } = lease;
  write("lease", watches ? `you watch · ${watched(lease)}` : words(lease));
  div("lease").dataset.state = tone(lease);
  button("take").hidden = watches || held || !holder || holder === PROGRAM || holder === ours;
  const stop = button("stop");
  stop.classList.toggle("stopped", stopped);
  stop.setAttribute("aria-pressed", String(stopped));
  write("stop-text", stopped ? "RELEASE" : "STOP");
  write("stop-key", stopped ? "R" : "Space");
  document.body.classList.toggle("is-stopped", stopped);
}

/** @param {Omit<LeaseFrame, "type">} lease */
function words({ held, holder, holder_title, stopped }) {
  if (stopped) return "stopped";
  if (held) return "you drive";
  if (!holder) return "free to drive";
  return `${holder_title ?? holder} drives`;
}

/** @param {Omit<LeaseFrame, "type">} lease */
function watched(lease) {
  return lease.stopped || lease.holder ? words(lease) : "nobody drives";
}

/** @param {Omit<LeaseFrame, "type">} lease */
function tone({ held, holder, stopped }) {
  if (stopped) return "stopped";
  if (held) return "ours";
  return holder ? "theirs" : "free";
}

/**
 * Why a frame had no effect, for people; "" where that needs no words.
 * @param {string} code
 * @param {string} reason
 */
export function refusalText(code, reason) {
  if (SHOWN_ELSEWHERE.includes(code)) return "";
  if (code === "other_drives") return "Somebody else drives. Take over first.";
  if (code === "not_shown") return "Another world has begun. Let go, then press again.";
  return `${reason[0].toUpperCase()}${reason.slice(1)}.`;
}
