// The page: wires stick, keys and buttons to the worker and the REST routes, and snapshots to the readings.

import { drawTicks, show, trouble, degrees } from "./readouts.js";
import { Stick, isDrivingKey } from "./joystick.js";
import { Strips } from "./time_series.js";
import { View } from "./viser_frame.js";
import { Why } from "./decision_panel.js";

const ALIVE = 100;          // ms between signs of life to the worker
const TURN_FULL = 0.15;     // rad/s at full turn
const TOAST = 3500;         // ms
const ADVANCE_TICKS = 25;   // half a second
const STORE = "walking-console";

const $ = (id) => document.getElementById(id);
const worker = new Worker("/drive-worker.js", { type: "module" });
const saved = JSON.parse(localStorage.getItem(STORE) ?? "{}");
const view = new View($("view"));
const strips = new Strips($("gait"), $("chart"), $("segments"));
const why = new Why($("why"));

let newest = null;
let lease = { held: false, holder: null, stopped: false };
let ours = "";
let linked = false;
let loading = false;

const keep = (more) => localStorage.setItem(STORE, JSON.stringify(Object.assign(saved, more)));

// driving

const stick = new Stick($("stick"), $("knob"), $("turn-slider"), command);

const turns = () => newest !== null && newest.planner_mode !== "naive"; // that one walks straight courses only

function asked({ x, y, turn }) {
  const full = Number($("top-speed-slider").value);
  return {
    crab_angle_rad: x || y ? Math.atan2(y, x) : 0,
    speed_m_s: Math.min(Math.hypot(x, y), 1) * full,
    turn_rate_rad_s: turns() ? turn * TURN_FULL : 0,
  };
}

function command(value) {
  const next = asked(value);
  $("turn-asked").textContent = `${Math.round(degrees(next.turn_rate_rad_s))}°/s`;
  if ((next.speed_m_s || next.turn_rate_rad_s) && lease.stopped) say("Stopped. Release the stop to drive.");
  worker.postMessage({ type: "command", command: next });
}

function letGo() {
  stick.letGo();
  worker.postMessage({ type: "release" });
}

function stop() {
  stick.letGo();
  worker.postMessage({ type: "stop" });
  if (!linked) post("stop");
}

function toggleStop() {
  if (lease.stopped) worker.postMessage({ type: "rearm" });
  else stop();
}

const sits = () => newest?.posture === "sit" && newest.mode !== "stand";

function pose(posture) {
  stick.letGo();
  if (lease.stopped) return say("Stopped. Release the stop first.");
  worker.postMessage({ type: "posture", posture });
}

for (const button of $("postures").children) button.addEventListener("click", () => pose(button.dataset.posture));
setInterval(() => worker.postMessage({ type: "alive", command: asked(stick.value) }), ALIVE);
// Clicking into the canvas takes the focus from this document but not from the console: keys are let go, the pointer stays.
window.addEventListener("blur", () => {
  stick.liftKeys();
  setTimeout(() => document.hasFocus() || letGo(), 0);
});
document.addEventListener("visibilitychange", () => document.hidden && letGo());
window.addEventListener("pagehide", letGo);
$("stop").addEventListener("click", toggleStop);
$("take").addEventListener("click", () => worker.postMessage({ type: "take" }));

const speed = $("top-speed-slider");
speed.value = saved.speed ?? 0.12;
const showSpeed = () => { $("top-speed-value").textContent = `${Number(speed.value).toFixed(2)} m/s`; };
speed.addEventListener("input", () => { showSpeed(); keep({ speed: speed.value }); command(stick.value); });
showSpeed();

// keys: the canvas frame hands its own on to this document

const typing = (target) => target instanceof Element && target.matches("select, textarea, input:not([type=checkbox]):not([type=range])");
const SHORTCUTS = {
  KeyP: () => pauseOrGo(), Period: () => newest?.paused && post("advance", { ticks: ADVANCE_TICKS }), Backspace: () => post("reset"),
  KeyR: () => lease.stopped && toggleStop(), KeyC: () => view.home(), KeyV: () => openMenu($("view-menu").hidden),
  KeyB: () => openBrushes($("brushes").hidden),
  KeyG: () => newest && leans(newest) && takeAttitude(newest.attitude === "level" ? "ground" : "level"),
  KeyX: () => pose(sits() ? "stand" : "sit"), KeyN: () => pose("standard"),
};

document.addEventListener("keydown", (event) => {
  if (event.ctrlKey || event.metaKey || event.altKey || $("help").open || typing(event.target)) return;
  const { code, repeat } = event;
  if (code === "Space" || code === "Escape") {
    if (code === "Escape" && !$("view-menu").hidden) return openMenu(false);
    if (code === "Escape" && !$("brushes").hidden) return openBrushes(false);
    event.preventDefault();
    if (!repeat) stop();
  } else if (isDrivingKey(code)) {
    event.preventDefault();
    if (!repeat) stick.press(code, event.shiftKey);
  } else if (event.key === "?") help();
  else if (/^Digit[1-8]$/.test(code) && !repeat) setRate(Number(code.at(-1)));
  else if (code in SHORTCUTS && !repeat) { event.preventDefault(); SHORTCUTS[code](); }
});
document.addEventListener("keyup", (event) => {
  if (event.code === "Space") event.preventDefault(); // a focused button must not be pressed by the stop key
  stick.lift(event.code, event.shiftKey);
});

// REST

async function ask(method, path, body) {
  const answer = await fetch(`/api/v1/${path}`, {
    method, headers: body ? { "content-type": "application/json" } : {}, body: body && JSON.stringify(body),
  });
  const data = await answer.json().catch(() => ({}));
  if (!answer.ok) throw new Error(data.detail ?? `${answer.status} ${answer.statusText}`);
  return data;
}

async function post(action, body) {
  try { await ask("POST", `console/${action}`, body); } catch (error) { say(error.message); }
}

const leans = (s) => s.planner === "crab" && s.planner_mode === "predictive"; // the others walk level, as they were printed

async function takeAttitude(attitude) {
  try { await ask("PUT", "console/attitude", { attitude }); } catch (error) { say(error.message); }
}

for (const button of $("attitudes").children) button.addEventListener("click", () => takeAttitude(button.dataset.attitude));

async function load(body) {
  loading = true;
  letGo();
  document.body.classList.add("loading");
  try { await ask("PUT", "console/scenario", body); } catch (error) { say(error.message); }
  document.body.classList.remove("loading");
  loading = false;
  for (const id of ["scenario", "robot", "planner-mode"]) $(id).blur();
}

const pauseOrGo = () => post(newest?.paused ? "resume" : "pause");
const setRate = (rate) => post("rate", { rate });

$("pause").addEventListener("click", pauseOrGo);
$("advance").addEventListener("click", () => post("advance", { ticks: ADVANCE_TICKS }));
$("reset").addEventListener("click", () => post("reset"));
for (const button of $("rate").children) button.addEventListener("click", () => setRate(Number(button.dataset.rate)));
$("scenario").addEventListener("change", () => load({ name: $("scenario").value }));
const loadChanged = (changed) => load({ name: $("scenario").value, robot: $("robot").value, ...changed });
$("robot").addEventListener("change", () => loadChanged());
$("planner-mode").addEventListener("change", () => loadChanged({ mode: $("planner-mode").value }));

async function fillLists() {
  try {
    const [scenarios, robots] = await Promise.all([ask("GET", "scenarios"), ask("GET", "robots")]);
    $("scenario").replaceChildren(...scenarios.map((s) => option(s.name, s.name, s.title)));
    $("robot").replaceChildren(...robots.map((r) => option(r.name, `${r.name} · ${r.legs} legs`, r.title)));
    if (newest) choose(newest);
  } catch (error) { say(error.message); }
}

function option(value, text, title) {
  const made = new Option(text, value);
  made.title = title;
  return made;
}

function choose(s) {
  if (loading) return;
  for (const [select, value] of [[$("scenario"), s.scenario], [$("robot"), s.robot], [$("planner-mode"), s.planner_mode]]) {
    if (select.value === value || document.activeElement === select) continue;
    if (select.options.length && ![...select.options].some((o) => o.value === value)) select.add(option(value, value, ""));
    select.value = value;
  }
}

// view menu and help

function openMenu(open) {
  $("view-menu").hidden = !open;
  $("view-button").setAttribute("aria-expanded", String(open));
}
$("view-button").addEventListener("click", () => openMenu($("view-menu").hidden));
document.addEventListener("pointerdown", (event) => {
  if (!$("view-menu").hidden && !event.target.closest("#view-menu, #view-button")) openMenu(false);
});
for (const box of document.querySelectorAll("[data-view]")) {
  const label = box.dataset.view;
  box.checked = saved[label] ?? box.checked;
  if (label in saved) view.set(label, box.checked);
  box.addEventListener("change", () => { view.set(label, box.checked); keep({ [label]: box.checked }); });
}
$("home").addEventListener("click", () => view.home());
const strip = $("show-strips");
strip.checked = saved.strips ?? window.innerWidth > 700;
const showStrips = () => { document.body.classList.toggle("no-strips", !strip.checked); strips.visible = strip.checked; };
strip.addEventListener("change", () => { showStrips(); keep({ strips: strip.checked }); });
showStrips();

// changing the ground

const BRUSHES = [...document.querySelectorAll("[data-brush]")];

function takeBrush(brush) {
  for (const button of BRUSHES) {
    button.setAttribute("aria-checked", String(button.dataset.brush === brush));
    view.set(`Paint ${button.dataset.brush}`, button.dataset.brush === brush);
  }
  view.paints(Boolean(brush));
}

function openBrushes(open) {
  $("brushes").hidden = !open;
  $("brush-button").setAttribute("aria-expanded", String(open));
  takeBrush(open ? saved.brush ?? "dig" : "");
}
for (const button of BRUSHES) button.addEventListener("click", () => { keep({ brush: button.dataset.brush }); takeBrush(button.dataset.brush); });
$("brush-button").addEventListener("click", () => openBrushes($("brushes").hidden));
$("wide-brush").addEventListener("change", () => view.set("Wide brush", $("wide-brush").checked));

// the second strip: margins, or for the trace walker its footholds along s

function showTab() {
  const tab = newest?.planner === "trace" ? saved.tab ?? "segments" : "margin";
  document.body.dataset.planner = newest?.planner ?? "";
  if (document.body.dataset.tab === tab) return;
  document.body.dataset.tab = tab;
  for (const button of document.querySelectorAll("[data-tab].tab")) button.setAttribute("aria-pressed", String(button.dataset.tab === tab));
  strips.draw();
}
for (const button of document.querySelectorAll(".tab")) button.addEventListener("click", () => { keep({ tab: button.dataset.tab }); showTab(); });

const help = () => { stick.letGo(); $("help").showModal(); };
$("help-button").addEventListener("click", help);
$("help").addEventListener("click", (event) => event.target === $("help") && $("help").close());

// what comes in

const hear = {
  link({ state }) {
    linked = state === "open";
    const words = { open: "connected", connecting: "connecting", closed: "no connection" };
    $("link").dataset.state = state;
    $("link").lastElementChild.textContent = words[state];
    if (state === "closed") stick.letGo();
    clearTimeout(hear.timer);
    if (linked) { $("lost").hidden = true; fillLists(); } else hear.timer = setTimeout(() => { $("lost").hidden = linked; }, 1200);
  },
  hello({ frame }) { ours = frame.lease_id; },
  lease({ frame }) { lease = frame; showLease(); },
  refused({ frame }) { if (!frame.reason.startsWith("out of order")) say(plain(frame.reason)); },
  decision({ frame }) { why.tell(frame, newest?.feet.length ?? 4); },
  ahead({ frame }) { strips.segments.foresee(frame); },
  snapshot({ frame }) {
    const first = newest === null;
    if (!first && frame.tick < newest.tick) why.forget(); // another world, or its beginning
    newest = frame;
    if (first) document.body.classList.add("live");
    show(frame);
    strips.add(frame);
    showState(frame);
  },
};
worker.onmessage = ({ data }) => hear[data.type]?.(data);

function showLease() {
  const { held, holder, stopped } = lease;
  $("lease").textContent = stopped ? "stopped" : held ? "you drive" : holder === "rest" ? "a program drives" : holder ? `${holder} drives` : "free to drive";
  $("lease").dataset.state = held ? "ours" : holder ? "theirs" : "free";
  $("take").hidden = held || !holder || holder === "rest" || holder === ours;
  $("stop").classList.toggle("stopped", stopped);
  $("stop").setAttribute("aria-pressed", String(stopped));
  $("stop").firstElementChild.textContent = stopped ? "RELEASE" : "STOP";
  $("stop").querySelector("kbd").textContent = stopped ? "R" : "Space";
  document.body.classList.toggle("is-stopped", stopped);
}

const POSED = { sit_down: "sit", sit: "sit", stand_up: "stand", regroup: "standard" };
const posed = (s) => POSED[s.mode] ?? (s.mode === "stand" ? s.posture : "");

function showState(s) {
  choose(s);
  if (s.stopped !== lease.stopped) { lease = { ...lease, stopped: s.stopped }; showLease(); }
  $("pause").setAttribute("aria-pressed", String(s.paused));
  $("advance").disabled = !s.paused;
  for (const button of $("rate").children) button.setAttribute("aria-checked", String(Number(button.dataset.rate) === s.rate));
  for (const button of $("postures").children) button.setAttribute("aria-pressed", String(button.dataset.posture === posed(s)));
  $("attitudes").hidden = !leans(s);
  for (const button of $("attitudes").children) button.setAttribute("aria-checked", String(button.dataset.attitude === s.attitude));
  $("turn-control").hidden = !turns();
  $("planner-mode").hidden = s.planner !== "crab";
  showTab();
  const wrong = trouble(s);
  const banner = $("banner");
  const text = wrong ? wrong.join("|") : s.paused ? "paused" : "";
  if (banner.dataset.text === text) return;
  banner.dataset.text = text;
  banner.hidden = !text;
  banner.dataset.tone = wrong ? wrong[0] : "quiet";
  const [title, detail] = [document.createElement("strong"), document.createElement("span")];
  title.textContent = wrong ? wrong[1] : "Paused";
  detail.textContent = wrong ? wrong[2] : "";
  banner.replaceChildren(title, detail);
}

const plain = (reason) => (reason === "let go of the stick first" ? "Let the stick go once, then drive." : `${reason[0].toUpperCase()}${reason.slice(1)}.`);

let toastEnd = 0;
function say(text) {
  $("toast").textContent = text;
  $("toast").hidden = false;
  clearTimeout(toastEnd);
  toastEnd = setTimeout(() => { $("toast").hidden = true; }, TOAST);
}

drawTicks();
showLease();
