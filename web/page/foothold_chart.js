// The chart of existence segments (Kugushev & Jaroshevskij): per leg, over which s along the trace each foothold serves.

import { legNames } from "./readouts.js";

const BEHIND = 0.35;   // m of s shown behind the machine
const AHEAD = 2.2;     // m of s shown ahead at least
const LEFT = 34, AXIS = 14, STATES = 13; // px: names, numbers, the row of states
const LEG_COLOURS = ["#f0525f", "#ffb03b", "#3ecf8e", "#5b9dff", "#b07bff", "#ff79b8", "#3cd6df", "#d8cf3c"]; // as the rings in the scene
const NICE = [0.1, 0.2, 0.5, 1, 2, 5];

const css = (name) => getComputedStyle(document.documentElement).getPropertyValue(name).trim();

export class Segments {
  constructor(canvas) {
    this.canvas = canvas;
    this.ahead = null;
    this.past = []; // bars that were used: {leg, s1, s2, placed, lifted}
    this.course = 0;
  }

  foresee(frame) {
    const old = this.ahead;
    this.ahead = frame.segments_m ? frame : null;
    if (!this.ahead || !old || old.segments_m.length !== this.ahead.segments_m.length) { this.past = []; return; }
    old.segments_m.forEach((bars, leg) => bars.forEach(([s1, s2, placed, lifted]) => {
      const stays = this.ahead.segments_m[leg].some((bar) => Math.abs(bar[1] - s2) < 0.02 && Math.abs(bar[0] - s1) < 0.5);
      if (!stays && placed < this.course) this.past.push({ leg, bar: [s1, Math.min(s2, lifted), placed, Math.min(lifted, this.course)] });
    }));
    this.past = this.past.filter(({ bar }) => bar[1] > this.course - BEHIND && bar[2] <= this.course + 0.05).slice(-40);
  }

  draw(course) {
    if (course < this.course) this.past = [];
    this.course = course;
    const pen = this.#pen();
    if (!pen) return;
    const { width, height } = this;
    const ahead = this.ahead;
    if (!ahead?.states_m.length) return this.#nothing(pen);
    const legs = ahead.segments_m.length;
    const [from, to] = [course - BEHIND, Math.max(ahead.goal_m, course + AHEAD)];
    const at = (s) => LEFT + ((s - from) / (to - from)) * (width - LEFT);
    const bottom = height - AXIS;
    const row = (bottom - STATES) / legs;
    const span = (s1, s2, y, tall) => {
      const x = Math.max(at(s1), LEFT);
      if (at(s2) > x) pen.fillRect(x, y, Math.max(Math.min(at(s2), width) - x, 0.8), tall);
    };
    this.#scale(pen, from, to, at, bottom);
    const bars = [...this.past];
    ahead.segments_m.forEach((list, leg) => list.forEach((bar) => bars.push({ leg, bar })));
    const turn = new Array(legs).fill(0);
    const thick = Math.min(row * 0.72, 11);
    for (const { leg, bar: [s1, s2, placed, lifted] } of bars) {
      const middle = row * (leg + 0.5);
      const half = turn[leg]++ % 2 ? 0 : -thick / 2; // one foothold above, the next below: their overlap is seen
      pen.fillStyle = LEG_COLOURS[leg % LEG_COLOURS.length];
      pen.globalAlpha = 0.3;
      span(s1, s2, middle + half, thick / 2);
      pen.globalAlpha = 0.95;
      span(placed, lifted, middle + half, thick / 2);
    }
    this.#states(pen, ahead, span, bottom);
    this.#deadEnd(pen, ahead, at, to, bottom);
    pen.globalAlpha = 1;
    pen.fillStyle = css("--text");
    pen.fillRect(at(course) - 0.75, 0, 1.5, bottom);
    pen.fillStyle = css("--muted");
    pen.textAlign = "start";
    legNames(legs).forEach((name, leg) => pen.fillText(name, 0, row * (leg + 0.5)));
    pen.fillText("state", 0, bottom - STATES / 2 + 1);
  }

  // states with legs lifted in grey, one after the other; where one meets the next all legs stand: the overlap, amber
  #states(pen, ahead, span, bottom) {
    const top = bottom - STATES + 3;
    const tall = STATES - 4;
    ahead.states_m.forEach(([s1, s2], k) => {
      if (k % 2 === 0) return;
      pen.fillStyle = css("--text");
      pen.globalAlpha = 0.32;
      span(s1, s2, k % 4 === 1 ? top : top + tall / 2, tall / 2);
    });
    ahead.states_m.forEach(([s1, s2], k) => {
      if (k % 2) return;
      pen.fillStyle = css("--amber");
      pen.globalAlpha = 0.95;
      span(s1, s2, top, tall);
    });
    pen.globalAlpha = 1;
  }

  #deadEnd(pen, ahead, at, to, bottom) {
    if (ahead.complete) return;
    const [x, end] = [Math.max(at(ahead.reached_m), LEFT), at(Math.max(ahead.goal_m, ahead.reached_m + 0.1))];
    pen.save();
    pen.beginPath();
    pen.rect(x, 0, end - x, bottom);
    pen.clip();
    pen.globalAlpha = 0.16;
    pen.fillStyle = css("--bad");
    pen.fillRect(x, 0, end - x, bottom);
    pen.globalAlpha = 0.6;
    pen.strokeStyle = css("--bad");
    pen.lineWidth = 1;
    pen.beginPath();
    for (let k = x - bottom; k < end; k += 8) { pen.moveTo(k, bottom); pen.lineTo(k + bottom, 0); }
    pen.stroke();
    pen.restore();
    pen.globalAlpha = 1;
    pen.fillStyle = css("--bad");
    pen.fillRect(x - 1, 0, 2, bottom);
    pen.textAlign = "center";
    pen.font = "600 11px system-ui, sans-serif";
    if (end - x > 70) {
      const wide = pen.measureText("no way found").width + 12;
      pen.fillStyle = css("--ground");
      pen.fillRect((x + end - wide) / 2, bottom / 2 - 9, wide, 18);
      pen.fillStyle = css("--bad");
      pen.fillText("no way found", (x + end) / 2, bottom / 2);
    }
    pen.font = "500 10px system-ui, sans-serif";
  }

  #scale(pen, from, to, at, bottom) {
    const step = NICE.find((size) => (to - from) / size <= 9) ?? 10;
    pen.fillStyle = css("--muted");
    pen.textAlign = "center";
    for (let k = Math.ceil(from / step); k * step <= to; k++) {
      const x = at(k * step);
      if (k < 0 || x < LEFT) continue;
      pen.globalAlpha = 0.14;
      pen.fillRect(x, 0, 1, bottom);
      pen.globalAlpha = 0.8;
      if (x > LEFT + 8 && x < this.width - 14) pen.fillText(`${(k * step).toFixed(step < 1 ? 1 : 0)} m`, x, bottom + AXIS / 2 + 1);
    }
    pen.globalAlpha = 1;
  }

  #nothing(pen) {
    pen.fillStyle = css("--muted");
    pen.textAlign = "center";
    pen.fillText("nothing foreseen yet: it plans when it is told to walk", this.width / 2, this.height / 2);
  }

  #pen() {
    const { canvas } = this;
    const ratio = Math.min(window.devicePixelRatio || 1, 2);
    this.width = canvas.clientWidth;
    this.height = canvas.clientHeight;
    if (!this.width || !this.height) return null;
    if (canvas.width !== Math.round(this.width * ratio)) canvas.width = Math.round(this.width * ratio);
    if (canvas.height !== Math.round(this.height * ratio)) canvas.height = Math.round(this.height * ratio);
    const pen = canvas.getContext("2d");
    pen.setTransform(ratio, 0, 0, ratio, 0, 0);
    pen.clearRect(0, 0, this.width, this.height);
    pen.font = "500 10px system-ui, sans-serif";
    pen.textBaseline = "middle";
    return pen;
  }
}
