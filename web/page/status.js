// What the page says of itself: the link's pill, the overlay without one, the banner, the toast.

/** @import {Health, LinkState, SnapshotFrame} from "./frames" */

import { div, make, write } from "./dom.js";
import { trouble } from "./readouts.js";

const TOAST = 3500; // ms
const LOST_AFTER = 1200; // ms without a link before the overlay
const LINK_WORDS = { open: "connected", connecting: "connecting", closed: "no connection" };

let toastEnd = 0;
let lostTimer = 0;

/**
 * A sentence for a few seconds.
 * @param {string} text
 */
export function say(text) {
  const toast = div("toast");
  toast.textContent = text;
  toast.hidden = false;
  clearTimeout(toastEnd);
  toastEnd = setTimeout(() => {
    toast.hidden = true;
  }, TOAST);
}

/** @param {LinkState} state */
export function showLink(state) {
  div("link").dataset.state = state;
  write("link-text", LINK_WORDS[state]);
  clearTimeout(lostTimer);
  const lost = div("lost");
  if (state === "open") lost.hidden = true;
  else {
    lostTimer = setTimeout(() => {
      lost.hidden = false;
    }, LOST_AFTER);
  }
}

const SPOKEN_EVERY = 3000; // ms between sentences for screen readers
let spokenAt = -Infinity;

/**
 * A sentence of how it goes, for screen readers, now and then.
 * @param {SnapshotFrame} s
 */
export function speakOf(s) {
  if (performance.now() - spokenAt < SPOKEN_EVERY) return;
  spokenAt = performance.now();
  const moves = s.walked_m_s > 0;
  const walks = moves ? `Walking, ${s.distance_m.toFixed(1)} m so far.` : "Not moving.";
  write("spoken", s.stopped ? "Stopped." : walks);
}

/** @param {Health} health */
export function showHealth({ age, round_trip, late }) {
  const open = div("link").dataset.state === "open";
  document.body.classList.toggle("late", late && open);
  div("link").dataset.late = String(late && open);
  if (!open) return;
  if (late) write("link-text", `no picture for ${(age / 1000).toFixed(1)} s`);
  else if (round_trip === null) write("link-text", LINK_WORDS.open);
  else write("link-text", `${round_trip.toFixed(0)} ms`);
}

/**
 * Why nothing moves, over the scene.
 * @param {SnapshotFrame} s
 */
export function showBanner(s) {
  const wrong = trouble(s);
  const title = wrong?.title ?? (s.paused ? "Paused" : "");
  const detail = wrong?.detail ?? "";
  const banner = div("banner");
  const text = `${title}|${detail}`;
  if (banner.dataset.text === text) return;
  banner.dataset.text = text;
  banner.dataset.tone = wrong?.tone ?? "quiet";
  banner.hidden = !title;
  banner.replaceChildren(make("strong", title), make("span", detail));
}
