// Numbers on the screen: one snapshot in, text and bars out.

/** @import {SnapshotFrame, Trouble} from "./frames" */

import { div, element, restyle, write } from "./dom.js";
import { legName, legTitle, marginTone } from "./machine_style.js";

const MARGIN_FULL = 0.25; // m, margin that fills the bar
const MARGIN_BELOW = -0.2; // share of the bar a negative margin fills at most
const SPEED_FULL = 0.15; // m/s, speed that fills the bar at least
/** @type {Record<string, string>} */
const MODES = {
  stand: "Standing", support: "Moving on all feet", shift: "Shifting the body",
  up: "Lifting", return: "Swinging", down: "Setting down", settle: "Setting down",
  blocked: "Blocked", emergent: "Feeling for ground", tipping: "Tipping over", fallen: "Fallen",
  sit_down: "Sitting down", sit: "Sitting", stand_up: "Standing up", regroup: "Regrouping",
};
/** @type {Record<string, string>} */
const TONES = {
  blocked: "warn", emergent: "warn", tipping: "bad", fallen: "bad", stand: "", sit: "",
};
const TOUCHING_DOWN = ["down", "settle", "sit_down", "sit", "stand_up"]; // feet may be on their way
const LONG_WAY = /by any leg, shift, step back, course within 30 degrees or stretched leg/;
const STILL = ["stand", "shift"]; // modes without a leg in the air

/** @param {number} radians */
export const degrees = (radians) => (radians * 180) / Math.PI;

/** @param {number | null} metres */
export const millimetres = (metres) => (metres === null ? "–" : (metres * 1000).toFixed(0));

export function drawTicks() {
  const ticks = [];
  for (let angle = 0; angle < 360; angle += 15) {
    const tick = document.createElementNS("http://www.w3.org/2000/svg", "path");
    tick.setAttribute("d", `M0-52V-${tickEnd(angle)}`);
    tick.setAttribute("transform", `rotate(${angle})`);
    ticks.push(tick);
  }
  element("dial-ticks", SVGGElement).replaceChildren(...ticks);
}

/** @param {number} angle */
function tickEnd(angle) {
  if (angle % 90 === 0) return 45;
  return angle % 45 === 0 ? 47 : 49;
}

let still = 0; // s of simulated time until it first moved

/** @param {SnapshotFrame} s */
function timeOnTheWay({ time_s, step, distance_m, mode }) {
  const unmoved = step === 0 && distance_m === 0 && mode === "stand";
  if (unmoved) still = time_s;
  else if (time_s < still) still = 0;
  return time_s - still;
}

/** @param {SnapshotFrame} s */
export function showReadouts(s) {
  const arrived = s.blocked_by === "arrived";
  write("mode", arrived ? "Arrived" : (MODES[s.mode] ?? s.mode));
  div("state").dataset.tone = arrived ? "walk" : (TONES[s.mode] ?? "walk");
  write("planner", s.follows_trace ? s.planner : `${s.planner} ·`);
  write("step", String(s.step));
  write("swing", s.swing.length && !STILL.includes(s.mode) ? s.swing.map(legTitle).join(", ") : "–");
  write("distance", s.distance_m.toFixed(2));
  write("time", clock(timeOnTheWay(s)));
  write("flags", s.flags.map((set, k) => (set ? `F${k + 1}` : "·")).join(" "));
  write("late", (s.late_s * 1000).toFixed(s.late_s < 0.01 ? 1 : 0));
  showCourse(s);
  showDirection(s);
  showSpeed(s);
  showMargin("margin", s.margin_m);
  showMargin("polygon", s.polygon_margin_m);
  showCarried(s);
  write("energy", millimetres(s.energy_margin_m));
}

/**
 * How far the body is from a trace it was given, and why its step is not that of the paper's rules.
 * @param {SnapshotFrame} s
 */
function showCourse({ departure, off_trace_m }) {
  write("departure", departure && `· ${departure}`);
  div("off-trace-row").hidden = off_trace_m === null;
  write("off-trace", millimetres(off_trace_m));
}

/** @param {SnapshotFrame} s */
function showDirection(s) {
  const angle = degrees(s.crab_angle_rad);
  write("crab", `${Math.round(angle)}°`);
  element("dial", SVGElement).classList.toggle("active", s.speed_m_s > 0);
  element("dial-needle", SVGGElement).setAttribute("transform", `rotate(${(-angle).toFixed(1)})`);
  div("turn").hidden = s.turn_rate_rad_s === 0;
  write("turn", `turning ${degrees(s.turn_rate_rad_s).toFixed(0)}°/s`);
}

/** @param {SnapshotFrame} s */
function showSpeed(s) {
  const full = Math.max(SPEED_FULL, s.speed_m_s, s.speed_max_m_s);
  const limited = s.speed_max_m_s > 0;
  write("walked", s.walked_m_s.toFixed(3));
  write("asked", s.speed_m_s.toFixed(2));
  write("most", limited ? s.speed_max_m_s.toFixed(3) : "–");
  div("sway-slows").hidden = !s.sway_slows;
  restyle("speed-bar", "width", `${(100 * s.walked_m_s) / full}%`);
  restyle("speed-asked", "left", `${(100 * s.speed_m_s) / full}%`);
  restyle("speed-most", "left", `${limited ? (100 * s.speed_max_m_s) / full : -10}%`);
}

/**
 * @param {"margin" | "polygon"} id
 * @param {number | null} margin m
 */
function showMargin(id, margin) {
  write(id, millimetres(margin));
  const share = Math.max(MARGIN_BELOW, Math.min(1, (margin ?? 0) / MARGIN_FULL));
  restyle(`${id}-bar`, "width", `${Math.abs(share) * 100}%`);
  const bar = div(`${id}-bar`);
  const tone = marginTone(margin);
  if (bar.dataset.tone !== tone) bar.dataset.tone = tone;
}

/**
 * The margin of the feet that really carry, where one that should has lost the ground.
 * @param {SnapshotFrame} s
 */
function showCarried({ support, contact, contact_margin_m, mode }) {
  const lost = support.flatMap((carries, leg) => (carries && !contact[leg] ? [leg + 1] : []));
  const shown = lost.length > 0 && !TOUCHING_DOWN.includes(mode);
  div("carried").hidden = !shown;
  if (!shown) return;
  write("carried-margin", millimetres(contact_margin_m));
  write("carried-legs", lost.map(legTitle).join(", "));
}

/** @param {number} seconds */
function clock(seconds) {
  const minutes = Math.floor(seconds / 60);
  return `${minutes}:${(seconds - 60 * minutes).toFixed(1).padStart(4, "0")}`;
}

/** @type {Record<string, (reason: string) => Trouble>} */
const TROUBLES = {
  fallen: (reason) => ({
    tone: "bad",
    title: "The machine has fallen",
    detail: `${reason || "its centre of gravity left the support"}. Reset to go on.`,
  }),
  tipping: (reason) => ({ tone: "bad", title: "The machine is tipping over", detail: reason }),
  blocked: (reason) => ({
    tone: "warn",
    title: "No step possible this way",
    detail: `${sentence(reason || "the planner found none")} Try another direction.`,
  }),
  emergent: (reason) => ({ tone: "warn", title: "Feeling for ground", detail: reason }),
};

/** @type {Trouble} */
const ARRIVED = { tone: "good", title: "Arrived", detail: "The trace ends here." };

/**
 * A reason as a sentence, with the leg by its name: "FL: no ground within reach ...".
 * @param {string} reason
 */
export function sentence(reason) {
  const named = reason.replace(/\bleg (\d+)\b/g, (_, number) => legName(Number(number)));
  const plain = named.replace(LONG_WAY, "whatever leg, shift or way back was tried");
  return `${plain[0].toUpperCase()}${plain.slice(1)}.`;
}

/**
 * Why nothing moves, in plain words; null when all is well.
 * @param {SnapshotFrame} s
 * @returns {Trouble | null}
 */
export function trouble(s) {
  if (s.fault) return { tone: "bad", title: "The console has a fault", detail: s.fault };
  if (s.blocked_by === "arrived") return ARRIVED;
  return TROUBLES[s.mode]?.(s.reason) ?? null;
}
