// The last seconds as pictures: the gait diagram (who carried when) and both margins over time.

import { legNames } from "./readouts.js";
import { Segments } from "./foothold_chart.js";

const WINDOW = 20;    // s shown
const DRAW = 110;     // ms between drawings
const MAX_MM = 400;   // mm, margins above this are drawn at the edge

const css = (name) => getComputedStyle(document.documentElement).getPropertyValue(name).trim();

export class Strips {
  constructor(canvas, chart, segments) {
    this.segments = new Segments(segments);
    this.course = 0;
    this.canvas = canvas;
    this.box = chart;
    this.samples = []; // {t, support, contact, margin, polygon}
    this.drawn = 0;
    this.plot = null;
    this.visible = true;
    new ResizeObserver(() => this.#resize()).observe(chart);
  }

  add(s) {
    this.course = s.course_m;
    const last = this.samples.at(-1);
    if (last && (s.time_s < last.t || s.feet.length !== last.support.length)) this.samples = [];
    if (!last || s.time_s > last.t || !this.samples.length) {
      const mm = (value) => (value === null ? null : Math.min(value * 1000, MAX_MM));
      this.samples.push({ t: s.time_s, support: s.support, contact: s.contact, margin: mm(s.margin_m), polygon: mm(s.polygon_margin_m) });
    }
    let stale = 0;
    while (stale < this.samples.length - 2 && this.samples[stale + 1].t < s.time_s - WINDOW) stale++;
    if (stale) this.samples.splice(0, stale);
    const now = performance.now();
    if (this.visible && now - this.drawn > DRAW) { this.drawn = now; this.draw(); }
  }

  draw() {
    if (!this.samples.length) return;
    const end = this.samples.at(-1).t;
    this.#gait(end);
    if (this.canvas.ownerDocument.body.dataset.tab === "segments") this.segments.draw(this.course);
    else this.#margins(end);
  }

  #gait(end) {
    const { canvas, samples } = this;
    const ratio = Math.min(window.devicePixelRatio || 1, 2);
    const [width, height] = [canvas.clientWidth, canvas.clientHeight];
    if (!width || !height) return;
    if (canvas.width !== Math.round(width * ratio)) canvas.width = Math.round(width * ratio);
    if (canvas.height !== Math.round(height * ratio)) canvas.height = Math.round(height * ratio);
    const pen = canvas.getContext("2d");
    pen.setTransform(ratio, 0, 0, ratio, 0, 0);
    pen.clearRect(0, 0, width, height);
    const legs = samples[0].support.length;
    const [left, axis] = [26, 14];
    const row = (height - axis) / legs;
    const at = (t) => left + ((t - end + WINDOW) / WINDOW) * (width - left);
    pen.font = "500 10px system-ui, sans-serif";
    pen.textBaseline = "middle";
    const [bar, air, slack, muted] = [css("--text"), css("--amber"), css("--bad"), css("--muted")];
    pen.fillStyle = muted;
    legNames(legs).forEach((name, leg) => pen.fillText(name, 0, row * (leg + 0.5)));
    pen.textAlign = "center";
    for (let t = Math.ceil((end - WINDOW) / 5) * 5; t <= end; t += 5) {
      if (t < 0) continue;
      pen.globalAlpha = 0.14;
      pen.fillRect(at(t), 0, 1, height - axis);
      pen.globalAlpha = 0.8;
      if (at(t) > left + 10 && at(t) < width - 10) pen.fillText(`${t} s`, at(t), height - axis / 2 + 1);
    }
    pen.textAlign = "start";
    for (let leg = 0; leg < legs; leg++) {
      const middle = row * (leg + 0.5);
      const thick = Math.min(row * 0.62, 11);
      for (let i = 0; i < samples.length; ) {
        const kind = kindOf(samples[i], leg);
        let j = i + 1;
        while (j < samples.length && kindOf(samples[j], leg) === kind) j++;
        const from = Math.max(at(samples[i].t), left);
        const to = at(samples[Math.min(j, samples.length - 1)].t);
        pen.globalAlpha = kind === "air" ? 0.9 : 0.88;
        pen.fillStyle = kind === "carry" ? bar : kind === "slack" ? slack : air;
        if (kind === "air") pen.fillRect(from, middle - 0.75, to - from, 1.5);
        else pen.fillRect(from, middle - thick / 2, Math.max(to - from, 0.5), thick);
        i = j;
      }
    }
    pen.globalAlpha = 1;
  }

  #margins(end) {
    const data = [this.samples.map((s) => s.t), this.samples.map((s) => s.margin), this.samples.map((s) => s.polygon)];
    if (!this.plot) this.#make(data);
    if (!this.plot) return;
    this.plot.setData(data, false);
    this.plot.setScale("x", { min: end - WINDOW, max: end });
  }

  #make(data) {
    if (typeof uPlot === "undefined" || !this.box.clientWidth) return;
    const grid = { stroke: "rgba(255,255,255,0.07)", width: 1 };
    const axis = { stroke: css("--muted"), grid, ticks: { show: false }, font: "500 10px system-ui, sans-serif" };
    this.plot = new uPlot({
      width: this.box.clientWidth, height: this.box.clientHeight, padding: [6, 4, 0, 0],
      cursor: { show: false }, legend: { show: false },
      scales: { x: { time: false }, y: { range: (_, low, high) => [Math.min(low ?? 0, 0) - 8, Math.max(high ?? 0, 60) + 12] } },
      axes: [
        { ...axis, size: 16, gap: 2, values: (_, ticks) => ticks.map((t) => (t < 0 ? "" : `${t} s`)), incrs: [5, 10] },
        { ...axis, size: 34, gap: 3, space: 22 },
      ],
      series: [{}, { stroke: css("--cyan"), width: 1.6, points: { show: false } }, { stroke: css("--amber"), width: 1.6, points: { show: false } }],
      hooks: { drawAxes: [zeroLine] },
    }, data, this.box);
  }

  #resize() {
    if (!this.box.clientWidth || !this.box.clientHeight) return;
    if (this.plot) this.plot.setSize({ width: this.box.clientWidth, height: this.box.clientHeight });
    this.draw();
  }
}

const kindOf = (sample, leg) => (!sample.support[leg] ? "air" : sample.contact[leg] ? "carry" : "slack");

function zeroLine(plot) {
  const y = Math.round(plot.valToPos(0, "y", true));
  plot.ctx.save();
  plot.ctx.strokeStyle = css("--bad");
  plot.ctx.globalAlpha = 0.75;
  plot.ctx.beginPath();
  plot.ctx.moveTo(plot.bbox.left, y);
  plot.ctx.lineTo(plot.bbox.left + plot.bbox.width, y);
  plot.ctx.stroke();
  plot.ctx.restore();
}
