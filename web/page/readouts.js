// Numbers on the screen: one snapshot in, text and bars out. Nothing is written that has not changed.

const MARGIN_FULL = 0.25;   // m, margin that fills the bar
const MARGIN_GOOD = 0.03;   // m, green from here
const MODES = {
  stand: "Standing", support: "Moving on all feet", up: "Lifting", return: "Swinging", down: "Setting down", shift: "Shifting the body",
  settle: "Setting down", blocked: "Blocked", emergent: "Feeling for ground", tipping: "Tipping over", fallen: "Fallen",
  sit_down: "Sitting down", sit: "Sitting", stand_up: "Standing up", regroup: "Regrouping",
};
const ALARMS = { blocked: "warn", emergent: "warn", tipping: "bad", fallen: "bad" };
const QUADRUPED = ["FL", "RL", "RR", "FR"];
const HEXAPOD = ["FL", "ML", "RL", "RR", "MR", "FR"];

export const legNames = (count) =>
  count === 4 ? QUADRUPED : count === 6 ? HEXAPOD : Array.from({ length: count }, (_, i) => String(i + 1));

const $ = (id) => document.getElementById(id);
const written = new Map();

function write(id, text) {
  if (written.get(id) === text) return;
  written.set(id, text);
  $(id).textContent = text;
}

function style(id, property, value) {
  const key = `${id}.${property}`;
  if (written.get(key) === value) return;
  written.set(key, value);
  $(id).style.setProperty(property, value);
}

export const degrees = (radians) => (radians * 180) / Math.PI;
export const marginClass = (margin) => (margin === null || margin < -0.001 ? "bad" : margin < MARGIN_GOOD ? "warn" : "good");

export function drawTicks() {
  const ticks = [];
  for (let angle = 0; angle < 360; angle += 15) {
    const tick = document.createElementNS("http://www.w3.org/2000/svg", "path");
    tick.setAttribute("d", angle % 90 ? (angle % 45 ? "M0-52V-49" : "M0-52V-47") : "M0-52V-45");
    tick.setAttribute("transform", `rotate(${angle})`);
    ticks.push(tick);
  }
  $("dial-ticks").replaceChildren(...ticks);
}

export function show(s) {
  const names = legNames(s.feet.length);
  write("mode", MODES[s.mode] ?? s.mode);
  $("state").dataset.tone = ALARMS[s.mode] ?? (s.mode === "stand" || s.mode === "sit" ? "" : "walk");
  write("planner", s.planner === "crab" ? "crab ·" : "trace");
  write("step", String(s.step));
  const swings = s.swing.length && s.mode !== "stand" && s.mode !== "shift";
  write("swing", swings ? s.swing.map((leg) => `${leg} ${names[leg - 1] === String(leg) ? "" : names[leg - 1]}`).join(", ") : "–");
  write("distance", s.distance_m.toFixed(2));
  write("time", clock(s.time_s));
  write("late", (s.late_s * 1000).toFixed(s.late_s < 0.01 ? 1 : 0));
  const moving = s.speed_m_s > 0;
  write("crab", `${Math.round(degrees(s.crab_angle_rad))}°`);
  $("dial").classList.toggle("active", moving);
  $("dial-needle").setAttribute("transform", `rotate(${(-degrees(s.crab_angle_rad)).toFixed(1)})`);
  $("turn").hidden = s.turn_rate_rad_s === 0;
  write("turn", `turning ${degrees(s.turn_rate_rad_s).toFixed(0)}°/s`);
  showSpeed(s);
  showMargin("margin", s.margin_m);
  showMargin("polygon", s.polygon_margin_m);
  write("energy", s.energy_margin_m === null ? "–" : (s.energy_margin_m * 1000).toFixed(0));
}

function showSpeed(s) {
  const full = Math.max(0.15, s.speed_m_s, s.speed_max_m_s);
  write("walked", s.walked_m_s.toFixed(3));
  write("asked", s.speed_m_s.toFixed(2));
  write("most", s.speed_max_m_s > 0 ? s.speed_max_m_s.toFixed(3) : "–");
  style("speed-bar", "width", `${(100 * s.walked_m_s) / full}%`);
  style("speed-asked", "left", `${(100 * s.speed_m_s) / full}%`);
  style("speed-most", "left", `${s.speed_max_m_s > 0 ? (100 * s.speed_max_m_s) / full : -10}%`);
}

function showMargin(id, margin) {
  write(id, margin === null ? "–" : (margin * 1000).toFixed(0));
  const share = margin === null ? 0 : Math.max(-0.2, Math.min(1, margin / MARGIN_FULL));
  style(`${id}-bar`, "width", `${Math.abs(share) * 100}%`);
  const tone = marginClass(margin);
  if ($(`${id}-bar`).dataset.tone !== tone) $(`${id}-bar`).dataset.tone = tone;
}

function clock(seconds) {
  const minutes = Math.floor(seconds / 60);
  return `${minutes}:${(seconds - 60 * minutes).toFixed(1).padStart(4, "0")}`;
}

// why nothing moves, in plain words; "" when all is well
export function trouble(s) {
  if (s.fault) return ["bad", "The console has a fault", s.fault];
  if (s.mode === "fallen") return ["bad", "The machine has fallen", `${s.reason || "its centre of gravity left the support"}. Reset to go on.`];
  if (s.mode === "tipping") return ["bad", "The machine is tipping over", s.reason];
  if (s.mode === "blocked") return ["warn", "No step possible this way", `${s.reason || "the planner found none"}. Try another direction.`];
  if (s.mode === "emergent") return ["warn", "Feeling for ground", s.reason];
  return null;
}
