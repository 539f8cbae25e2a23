// Both margins over the last seconds, in millimetres.

import { SMALL_TYPE } from "./canvas_pen.js";
import { css } from "./dom.js";

/** @import {Sample} from "./time_series.js" */

const LEAST_TOP = 60; // mm the axis reaches up to at least

export class MarginChart {
  /** @param {HTMLElement} box */
  constructor(box) {
    this.box = box;
    /** @type {uPlot | null} */
    this.plot = null;
    window.addEventListener("restyled", () => this.#makeAnew());
  }

  /** In the colours of another theme, with what comes next. */
  #makeAnew() {
    this.plot?.destroy();
    this.plot = null;
  }

  /**
   * @param {Sample[]} samples
   * @param {number} from s
   * @param {number} to s
   */
  draw(samples, from, to) {
    const data = [
      samples.map((sample) => sample.t),
      samples.map((sample) => sample.margin),
      samples.map((sample) => sample.polygon),
    ];
    this.plot ??= this.#made(data);
    this.plot?.setData(data, false);
    this.plot?.setScale("x", { min: from, max: to });
  }

  resize() {
    const { clientWidth: width, clientHeight: height } = this.box;
    if (width && height) this.plot?.setSize({ width, height });
  }

  /** @param {(number | null)[][]} data */
  #made(data) {
    const { clientWidth: width, clientHeight: height } = this.box;
    if (typeof uPlot === "undefined" || !width) return null;
    const layout = { width, height, padding: [6, 4, 0, 0] };
    return new uPlot({ ...layout, ...appearance() }, data, this.box);
  }
}

function appearance() {
  const axis = { stroke: css("--muted"), grid: { stroke: css("--edge"), width: 1 }, ticks: { show: false }, font: SMALL_TYPE };
  const line = { width: 1.6, points: { show: false } };
  return {
    cursor: { show: false },
    legend: { show: false },
    scales: { x: { time: false }, y: { range: heightRange } },
    axes: [
      { ...axis, size: 16, gap: 2, values: secondLabels, incrs: [5, 10] },
      { ...axis, size: 34, gap: 3, space: 22 },
    ],
    series: [{}, { ...line, stroke: css("--cyan") }, { ...line, stroke: css("--amber") }],
    hooks: { drawAxes: [drawZeroLine] },
  };
}

/**
 * @param {uPlot} _
 * @param {number[]} ticks s
 */
const secondLabels = (_, ticks) => ticks.map((t) => (t < 0 ? "" : `${t} s`));

/**
 * @param {uPlot} _
 * @param {number | null} low
 * @param {number | null} high
 */
const heightRange = (_, low, high) => [
  Math.min(low ?? 0, 0) - 8,
  Math.max(high ?? 0, LEAST_TOP) + 12,
];

/** @param {uPlot} plot */
function drawZeroLine(plot) {
  const { ctx, bbox } = plot;
  const y = Math.round(plot.valToPos(0, "y", true));
  ctx.save();
  ctx.strokeStyle = css("--bad");
  ctx.globalAlpha = 0.75;
  ctx.beginPath();
  ctx.moveTo(bbox.left, y);
  ctx.lineTo(bbox.left + bbox.width, y);
  ctx.stroke();
  ctx.restore();
}
