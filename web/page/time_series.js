// The last seconds as pictures: the gait diagram, and beside it the margins over time or, on a
// given trace, the footholds along it.

/** @import {SnapshotFrame} from "./frames" */

import { div, element } from "./dom.js";
import { FootholdChart } from "./foothold_chart.js";
import { drawGait } from "./gait_diagram.js";
import { MarginChart } from "./margin_chart.js";

const WINDOW = 20; // s shown
const DRAW = 110; // ms between drawings
const MARGIN_MAX = 400; // mm, margins above this are drawn at the edge

/**
 * @typedef {object} Sample
 * @property {number} t s
 * @property {boolean[]} support
 * @property {boolean[]} contact
 * @property {number | null} margin mm
 * @property {number | null} polygon mm
 */

export class TimeSeries {
  constructor() {
    this.gait = element("gait", HTMLCanvasElement);
    this.margins = new MarginChart(div("chart"));
    this.footholds = new FootholdChart(element("footholds", HTMLCanvasElement));
    this.tab = "margin";
    this.visible = true;
    /** @type {Sample[]} */
    this.samples = [];
    this.path = 0; // m, s of the body on its trace
    this.drawn = 0;
    new ResizeObserver(() => this.#resize()).observe(this.margins.box);
  }

  /** @param {SnapshotFrame} s */
  add(s) {
    this.path = s.course_m;
    const last = this.samples.at(-1);
    const another = last && (s.time_s < last.t || s.feet.length !== last.support.length);
    if (another) this.samples = [];
    if (!last || another || s.time_s > last.t) this.samples.push(sampleOf(s));
    this.#forgetBefore(s.time_s - WINDOW);
    const now = performance.now();
    if (!this.visible || now - this.drawn <= DRAW) return;
    this.drawn = now;
    this.draw();
  }

  /** @param {number} time s */
  #forgetBefore(time) {
    let stale = 0;
    while (stale < this.samples.length - 2 && this.samples[stale + 1].t < time) stale++;
    this.samples.splice(0, stale);
  }

  draw() {
    const last = this.samples.at(-1);
    if (!last) return;
    drawGait(this.gait, this.samples, WINDOW);
    if (this.tab === "footholds") this.footholds.draw(this.path);
    else this.margins.draw(this.samples, last.t - WINDOW, last.t);
  }

  #resize() {
    this.margins.resize();
    this.draw();
  }
}

/**
 * @param {SnapshotFrame} s
 * @returns {Sample}
 */
function sampleOf(s) {
  const { support, contact } = s;
  const margin = shownMargin(s.margin_m);
  return { t: s.time_s, support, contact, margin, polygon: shownMargin(s.polygon_margin_m) };
}

/** @param {number | null} metres */
const shownMargin = (metres) => (metres === null ? null : Math.min(metres * 1000, MARGIN_MAX));
