// The gait diagram: who carried when over the last seconds.

import { penFor } from "./canvas_pen.js";
import { css } from "./dom.js";
import { legNames } from "./machine_style.js";

/** @import {Pen} from "./canvas_pen.js" */
/** @import {Sample} from "./time_series.js" */

const LEFT = 26; // px, names
const AXIS = 14; // px, numbers
const BAR_MAX = 11; // px
const EVERY = 5; // s between lines of the scale

/** @typedef {"air" | "carry" | "slack"} Contact */
/** @typedef {(time: number) => number} Scale time in s to px */

/**
 * @param {HTMLCanvasElement} canvas
 * @param {Sample[]} samples oldest first, at least one
 * @param {number} shown s
 */
export function drawGait(canvas, samples, shown) {
  const pen = penFor(canvas);
  const last = samples.at(-1);
  if (!pen || !last) return;
  const from = last.t - shown;
  const legs = last.support.length;
  const row = (pen.height - AXIS) / legs;
  /** @type {Scale} */
  const at = (t) => LEFT + ((t - from) / shown) * (pen.width - LEFT);
  pen.ink.fillStyle = css("--muted");
  legNames(legs).forEach((name, leg) => pen.ink.fillText(name, 0, row * (leg + 0.5)));
  drawScale(pen, at, from, last.t);
  const colours = { carry: css("--text"), air: css("--amber"), slack: css("--bad") };
  for (let leg = 0; leg < legs; leg++) drawLeg(pen.ink, at, samples, leg, { row, colours });
}

/**
 * @param {Pen} pen
 * @param {Scale} at
 * @param {number} from s
 * @param {number} to s
 */
function drawScale({ ink, width, height }, at, from, to) {
  ink.textAlign = "center";
  for (let t = Math.max(Math.ceil(from / EVERY) * EVERY, 0); t <= to; t += EVERY) {
    ink.globalAlpha = 0.14;
    ink.fillRect(at(t), 0, 1, height - AXIS);
    ink.globalAlpha = 0.8;
    const inside = at(t) > LEFT + 10 && at(t) < width - 10;
    if (inside) ink.fillText(`${t} s`, at(t), height - AXIS / 2 + 1);
  }
}

/**
 * One leg's row: thick where it carries, a thin line where it swings.
 * @param {CanvasRenderingContext2D} ink
 * @param {Scale} at
 * @param {Sample[]} samples
 * @param {number} leg
 * @param {{row: number, colours: Record<Contact, string>}} look
 */
function drawLeg(ink, at, samples, leg, { row, colours }) {
  const middle = row * (leg + 0.5);
  const thick = Math.min(row * 0.62, BAR_MAX);
  ink.globalAlpha = 0.9;
  for (const { kind, start, end } of stretches(samples, leg)) {
    const x = Math.max(at(start), LEFT);
    const tall = kind === "air" ? 1.5 : thick;
    ink.fillStyle = colours[kind];
    ink.fillRect(x, middle - tall / 2, Math.max(at(end) - x, 0.5), tall);
  }
}

/**
 * Stretches of time over which a leg did the same.
 * @param {Sample[]} samples
 * @param {number} leg
 */
function* stretches(samples, leg) {
  let first = 0;
  for (let i = 1; i <= samples.length; i++) {
    const kind = contactOf(samples[first], leg);
    if (i < samples.length && contactOf(samples[i], leg) === kind) continue;
    const end = samples[Math.min(i, samples.length - 1)];
    yield { kind, start: samples[first].t, end: end.t };
    first = i;
  }
}

/**
 * @param {Sample} sample
 * @param {number} leg
 * @returns {Contact}
 */
function contactOf(sample, leg) {
  if (!sample.support[leg]) return "air";
  return sample.contact[leg] ? "carry" : "slack";
}
