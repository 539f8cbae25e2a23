// The chart of existence segments (Kugushev & Jaroshevskij): per leg, over which s along the trace
// each foothold serves.

/** @import {AheadFrame, NothingAheadFrame, Segment} from "./frames" */
/** @import {Pen} from "./canvas_pen.js" */

import { SMALL_TYPE, penFor } from "./canvas_pen.js";
import { css } from "./dom.js";
import { legColour, legNames } from "./machine_style.js";

const BEHIND = 0.35; // m of s shown behind the machine
const AHEAD = 2.2; // m of s shown ahead at least
const LEFT = 34; // px, names
const AXIS = 14; // px, numbers
const STATES = 13; // px, the row of states
const BAR_MAX = 11; // px
const USED_MAX = 40; // used footholds that are remembered
const SAME_END = 0.02; // m; segments whose ends are nearer to each other are of one foothold
const SAME_START = 0.5; // m
const STEPS = [0.1, 0.2, 0.5, 1, 2, 5]; // m between lines of the scale
const NONE = "nothing foreseen yet: it plans when it is told to walk";
const DEAD_END = "no way found";

/**
 * @typedef {object} Bar
 * @property {number} leg from 0
 * @property {Segment} segment
 */

/** What is drawn: pen, px of an s in m, and the height of the rows. */
class Frame {
  /**
   * @param {Pen} pen
   * @param {number} from m
   * @param {number} to m
   * @param {number} legs
   */
  constructor(pen, from, to, legs) {
    this.ink = pen.ink;
    this.width = pen.width;
    this.from = from;
    this.to = to;
    this.bottom = pen.height - AXIS;
    this.row = (this.bottom - STATES) / legs;
  }

  /** @param {number} s m */
  at(s) {
    return LEFT + ((s - this.from) / (this.to - this.from)) * (this.width - LEFT);
  }

  /**
   * A bar over a stretch of s, cut off at the edges.
   * @param {number} s1
   * @param {number} s2
   * @param {number} y px
   * @param {number} tall px
   */
  span(s1, s2, y, tall) {
    const x = Math.max(this.at(s1), LEFT);
    const end = Math.min(this.at(s2), this.width);
    if (this.at(s2) > x) this.ink.fillRect(x, y, Math.max(end - x, 0.8), tall);
  }
}

export class FootholdChart {
  /** @param {HTMLCanvasElement} canvas */
  constructor(canvas) {
    this.canvas = canvas;
    /** @type {AheadFrame | null} */
    this.preview = null;
    /** @type {Bar[]} */
    this.used = [];
    this.path = 0; // m, s of the body
  }

  /** @param {AheadFrame | NothingAheadFrame} frame */
  foresee(frame) {
    const old = this.preview;
    const next = frame.segments_m ? frame : null;
    this.preview = next;
    if (!old || !next || old.segments_m.length !== next.segments_m.length) this.used = [];
    else this.#remember(old, next);
  }

  /**
   * Keep the footholds that are no longer planned because they were used.
   * @param {AheadFrame} old
   * @param {AheadFrame} next
   */
  #remember(old, next) {
    for (const { leg, segment } of barsOf(old)) {
      const [s1, s2, placed, lifted] = segment;
      const stays = next.segments_m[leg].some((other) => sameFoothold(other, segment));
      if (stays || placed >= this.path) continue;
      const left = Math.min(lifted, this.path);
      this.used.push({ leg, segment: [s1, Math.min(s2, lifted), placed, left] });
    }
    this.used = this.used.filter(({ segment }) => this.#isNear(segment)).slice(-USED_MAX);
  }

  /** @param {Segment} segment */
  #isNear([, s2, placed]) {
    return s2 > this.path - BEHIND && placed <= this.path + 0.05;
  }

  /** @param {number} path m, s of the body */
  draw(path) {
    if (path < this.path) this.used = [];
    this.path = path;
    const pen = penFor(this.canvas);
    if (!pen) return;
    const { preview } = this;
    if (!preview?.states_m.length) return drawNothing(pen);
    const goal = preview.goal_m ?? 0;
    const legs = preview.segments_m.length;
    const frame = new Frame(pen, path - BEHIND, Math.max(goal, path + AHEAD), legs);
    drawScale(frame);
    drawBars(frame, [...this.used, ...barsOf(preview)], legs);
    drawStates(frame, preview.states_m);
    if (!preview.complete) drawDeadEnd(frame, preview);
    drawHere(frame, path, legs);
  }
}

/**
 * @param {AheadFrame} preview
 * @returns {Bar[]}
 */
const barsOf = (preview) =>
  preview.segments_m.flatMap((segments, leg) => segments.map((segment) => ({ leg, segment })));

/**
 * @param {Segment} a
 * @param {Segment} b
 */
const sameFoothold = (a, b) =>
  Math.abs(a[1] - b[1]) < SAME_END && Math.abs(a[0] - b[0]) < SAME_START;

/**
 * Pale where a foothold would serve, bright where it is stood on.
 * @param {Frame} frame
 * @param {Bar[]} bars
 * @param {number} legs
 */
function drawBars(frame, bars, legs) {
  const thick = Math.min(frame.row * 0.72, BAR_MAX);
  const count = new Array(legs).fill(0);
  for (const { leg, segment: [s1, s2, placed, lifted] } of bars) {
    // one foothold above, the next below: their overlap is seen
    const top = frame.row * (leg + 0.5) + (count[leg]++ % 2 ? 0 : -thick / 2);
    frame.ink.fillStyle = legColour(leg);
    frame.ink.globalAlpha = 0.3;
    frame.span(s1, s2, top, thick / 2);
    frame.ink.globalAlpha = 0.95;
    frame.span(placed, lifted, top, thick / 2);
  }
}

/**
 * States with legs lifted in grey, one above the next; where two meet all legs stand: amber.
 * @param {Frame} frame
 * @param {[number, number][]} states
 */
function drawStates(frame, states) {
  const { ink } = frame;
  const top = frame.bottom - STATES + 3;
  const tall = STATES - 4;
  ink.fillStyle = css("--text");
  ink.globalAlpha = 0.32;
  states.forEach(([s1, s2], k) => {
    if (k % 2) frame.span(s1, s2, k % 4 === 1 ? top : top + tall / 2, tall / 2);
  });
  ink.fillStyle = css("--amber");
  ink.globalAlpha = 0.95;
  states.forEach(([s1, s2], k) => {
    if (k % 2 === 0) frame.span(s1, s2, top, tall);
  });
}

/**
 * What lies beyond the last sure s, hatched.
 * @param {Frame} frame
 * @param {AheadFrame} preview
 */
function drawDeadEnd(frame, { reached_m, goal_m }) {
  const { ink, bottom } = frame;
  const reached = reached_m ?? 0;
  const x = Math.max(frame.at(reached), LEFT);
  const end = frame.at(Math.max(goal_m ?? 0, reached + 0.1));
  ink.fillStyle = css("--bad");
  ink.globalAlpha = 0.16;
  ink.fillRect(x, 0, end - x, bottom);
  hatch(ink, x, end, bottom);
  ink.globalAlpha = 1;
  ink.fillRect(x - 1, 0, 2, bottom);
  if (end - x > 70) label(ink, DEAD_END, (x + end) / 2, bottom / 2);
}

/**
 * @param {CanvasRenderingContext2D} ink
 * @param {number} x
 * @param {number} end
 * @param {number} bottom
 */
function hatch(ink, x, end, bottom) {
  ink.save();
  ink.beginPath();
  ink.rect(x, 0, end - x, bottom);
  ink.clip();
  ink.globalAlpha = 0.6;
  ink.strokeStyle = css("--bad");
  ink.lineWidth = 1;
  ink.beginPath();
  for (let k = x - bottom; k < end; k += 8) {
    ink.moveTo(k, bottom);
    ink.lineTo(k + bottom, 0);
  }
  ink.stroke();
  ink.restore();
}

/**
 * A word on a plate of its own.
 * @param {CanvasRenderingContext2D} ink
 * @param {string} text
 * @param {number} x px, its middle
 * @param {number} y px
 */
function label(ink, text, x, y) {
  ink.textAlign = "center";
  ink.font = "600 11px system-ui, sans-serif";
  const wide = ink.measureText(text).width + 12;
  ink.fillStyle = css("--ground");
  ink.fillRect(x - wide / 2, y - 9, wide, 18);
  ink.fillStyle = css("--bad");
  ink.fillText(text, x, y);
  ink.font = SMALL_TYPE;
}

/** @param {Frame} frame */
function drawScale(frame) {
  const { ink, from, to, bottom } = frame;
  const step = STEPS.find((size) => (to - from) / size <= 9) ?? 10;
  ink.fillStyle = css("--muted");
  ink.textAlign = "center";
  for (let k = Math.max(Math.ceil(from / step), 0); k * step <= to; k++) {
    const x = frame.at(k * step);
    if (x < LEFT) continue;
    ink.globalAlpha = 0.14;
    ink.fillRect(x, 0, 1, bottom);
    ink.globalAlpha = 0.8;
    const text = `${(k * step).toFixed(step < 1 ? 1 : 0)} m`;
    if (x > LEFT + 8 && x < frame.width - 14) ink.fillText(text, x, bottom + AXIS / 2 + 1);
  }
}

/**
 * Where the body is, and the names of the rows.
 * @param {Frame} frame
 * @param {number} path m
 * @param {number} legs
 */
function drawHere(frame, path, legs) {
  const { ink, bottom } = frame;
  ink.globalAlpha = 1;
  ink.fillStyle = css("--text");
  ink.fillRect(frame.at(path) - 0.75, 0, 1.5, bottom);
  ink.fillStyle = css("--muted");
  ink.textAlign = "start";
  legNames(legs).forEach((name, leg) => ink.fillText(name, 0, frame.row * (leg + 0.5)));
  ink.fillText("state", 0, bottom - STATES / 2 + 1);
}

/** @param {Pen} pen */
function drawNothing({ ink, width, height }) {
  ink.fillStyle = css("--muted");
  ink.textAlign = "center";
  ink.fillText(NONE, width / 2, height / 2);
}
