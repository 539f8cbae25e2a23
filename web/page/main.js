// The page: wires stick, keys and buttons to the link and the REST routes, and frames to what shows
// them.

/**
 * @import {Command, DropReason, HelloFrame, LinkState, Posture, RefusedFrame, ServerFrame, SnapshotFrame,
 *   StickValue} from "./frames"
 */

import "./canvas_by_processor.js";
import { goBy, order } from "./api.js";
import { Brushes } from "./brushes.js";
import { DecisionPanel } from "./decision_panel.js";
import { button, buttons, div, element, input, mark, write } from "./dom.js";
import { DriveLink } from "./drive_link.js";
import { ExactCourse } from "./exact_course.js";
import { GamepadHand } from "./gamepad.js";
import { Joystick } from "./joystick.js";
import { explainWords } from "./glossary.js";
import { listenToKeys } from "./keyboard.js";
import { NO_LEASE, refusalText, showLease } from "./lease_view.js";
import { takeStyle } from "./machine_style.js";
import { OwnFiles } from "./own_files.js";
import { PostureControls } from "./posture_controls.js";
import { letEveryFingerClick, onPress } from "./press.js";
import { degrees, drawTicks, showReadouts } from "./readouts.js";
import { keep, saved } from "./settings.js";
import { say, showBanner, showHealth, showLink, speakOf } from "./status.js";
import { TimeSeries } from "./time_series.js";
import { ViewMenu } from "./view_menu.js";
import { ViserFrame } from "./viser_frame.js";
import { WorldControls } from "./world_controls.js";

const ALIVE = 100; // ms between signs of life to the worker
const TURN_FULL = 0.15; // rad/s at full turn
const STOP_HOLDS = 800; // ms after a stop in which nothing here releases it
const SPEED_FIRST = "0.12"; // m/s at full stick, until somebody chooses

const DROPPED = {
  late: "The picture was too old to drive by. Let go, then press again.",
  hung: "This page stood still for a moment. Let go, then press again.",
  refused: "The machine stopped waiting for this press. Let go, then press again.",
};

/** @type {SnapshotFrame | null} */
let newest = null;
let lease = { ...NO_LEASE };
let ours = ""; // this page's name in the lease
let greeted = ""; // the server's start, as it last said
let seen = false; // a first picture has come
let linked = false;
let watches = false; // this page's link may watch and stop, not drive
let stoppedAt = -Infinity; // ms, by this page

const link = new DriveLink({ link: linkChanged, health: showHealth, dropped, frame: hear });
const scene = new ViserFrame();
const series = new TimeSeries();
const decisions = new DecisionPanel();
const stick = new Joystick(drive);
const course = new ExactCourse(stick, scene);
const world = new WorldControls(letGo);
const postures = new PostureControls(pose);
const viewMenu = new ViewMenu(scene, series);
const brushes = new Brushes(scene);
// one click on the ground, one meaning
course.points = () => brushes.toggle(false);
brushes.opens = () => course.point(false);

// driving

/**
 * @param {StickValue} value
 * @returns {Command}
 */
function commandOf({ x, y, turn, speed }) {
  const full = speed ?? Number(input("top-speed-slider").value);
  return {
    crab_angle_rad: x || y ? Math.atan2(y, x) : 0,
    speed_m_s: Math.min(Math.hypot(x, y), 1) * full,
    turn_rate_rad_s: newest?.may_turn ? turn * TURN_FULL : 0,
  };
}

/** @param {StickValue} value */
function drive(value) {
  const command = commandOf(value);
  write("turn-asked", `${Math.round(degrees(command.turn_rate_rad_s))}°/s`);
  const moves = command.speed_m_s || command.turn_rate_rad_s;
  if (moves && lease.stopped) say("Stopped. Release the stop to drive.");
  link.drive(command, stick.presses);
}

/**
 * The worker has let go by itself.
 * @param {number} press
 * @param {DropReason} reason
 */
function dropped(press, reason) {
  if (press < stick.presses) return;
  if (stick.isHeld) say(DROPPED[reason]);
  stick.letGo();
}

function letGo() {
  stick.letGo();
  link.release();
}

function stop() {
  stoppedAt = performance.now();
  stick.letGo();
  link.stop();
  if (!linked) order(say, "POST", "console/stop");
}

/** The second tap of a hand in fright does not release what its first has stopped. */
function stopOrRelease() {
  if (!lease.stopped) stop();
  else if (performance.now() - stoppedAt > STOP_HOLDS) release();
}

function release() {
  if (stick.isHeld) say("Let go of the stick first, then release the stop.");
  else link.rearm();
}

/** @param {Posture} posture */
function pose(posture) {
  stick.letGo();
  if (lease.stopped) say("Stopped. Release the stop first.");
  else link.pose(posture);
}

function letGoWhenLeft() {
  setInterval(() => link.alive(commandOf(stick.value), stick.presses), ALIVE);
  // Clicking into the scene takes the focus from this document but not from the console: keys are
  // let go, the pointer stays.
  window.addEventListener("blur", () => {
    stick.liftKeys();
    setTimeout(() => document.hasFocus() || letGo(), 0);
  });
  letGoWhereItCannotBeSeen();
  document.addEventListener("visibilitychange", () => document.hidden && letGo());
  window.addEventListener("pagehide", letGo);
}

/** Menus and lists keep the end of a press for themselves, and so does what is outside the page. */
function letGoWhereItCannotBeSeen() {
  window.addEventListener("contextmenu", (event) => event.defaultPrevented || letGo());
  window.addEventListener("handsoff", letGo); // from the scene's frame
  for (const list of document.querySelectorAll("select")) letGoBeforeList(list);
  document.documentElement.addEventListener("mouseleave", ({ clientX: x, clientY: y }) => {
    const inside = x > 0 && y > 0 && x < window.innerWidth && y < window.innerHeight;
    if (!inside) stick.liftKeys();
  });
}

/**
 * An open list takes the repeats of a held key for letters to choose by: the press that lets the key
 * go does not open it.
 * @param {HTMLSelectElement} list
 */
function letGoBeforeList(list) {
  let keyWasHeld = false;
  list.addEventListener("focus", letGo);
  list.addEventListener("pointerdown", () => {
    keyWasHeld = stick.liftKeys();
    letGo();
  });
  list.addEventListener("mousedown", (event) => {
    if (keyWasHeld) event.preventDefault();
  });
}

function chooseTopSpeed() {
  const slider = input("top-speed-slider");
  slider.value = saved.speed ?? SPEED_FIRST;
  const show = () => write("top-speed-value", `${Number(slider.value).toFixed(2)} m/s`);
  slider.addEventListener("input", () => {
    show();
    keep({ speed: slider.value });
    drive(stick.value);
  });
  show();
}

// keys, help, tabs

function help() {
  stick.letGo();
  element("help", HTMLDialogElement).showModal();
}

function closeMenu() {
  const menu = [viewMenu, brushes].find((one) => one.isOpen);
  menu?.toggle(false);
  return menu !== undefined;
}

const SHORTCUTS = {
  KeyP: () => world.pauseOrGo(),
  Period: () => world.advance(),
  Backspace: () => world.resetByKey(),
  KeyR: () => lease.stopped && stopOrRelease(),
  KeyO: () => world.gallery.open(),
  KeyC: () => scene.home(),
  KeyK: () => viewMenu.nextCamera(),
  KeyV: () => viewMenu.toggle(),
  KeyB: () => brushes.toggle(),
  KeyG: () => postures.levelOrFollow(),
  KeyX: () => postures.sitOrStand(),
  KeyN: () => pose("standard"),
};

function wireButtons() {
  onPress(button("stop"), stopOrRelease);
  onPress(button("take"), () => link.take());
  onPress(button("help-button"), help);
  const dialog = element("help", HTMLDialogElement);
  dialog.addEventListener("click", (event) => event.target === dialog && dialog.close());
  for (const tab of buttons(".tab")) {
    onPress(tab, () => {
      keep({ tab: tab.dataset.tab });
      showTab();
    });
  }
  letEveryFingerClick();
}

/** The second strip: margins, or for a trace walker its footholds along s. */
function showTab() {
  const tab = newest?.follows_trace ? (saved.tab ?? "footholds") : "margin";
  if (document.body.dataset.tab === tab) return;
  document.body.dataset.tab = tab;
  series.tab = tab;
  mark(buttons(".tab"), "tab", tab, "aria-pressed");
  series.draw();
}

// what comes in

/** @param {LinkState} state */
function linkChanged(state) {
  linked = state === "open";
  showLink(state);
  if (state === "closed") stick.letGo();
  if (linked) world.fillLists();
}

/** @param {ServerFrame} frame */
function hear(frame) {
  switch (frame.type) {
    case "hello":
      return hearHello(frame);
    case "style":
      return takeStyle(frame);
    case "lease":
      lease = frame;
      return showLease(lease, ours, watches);
    case "refused":
      return hearRefusal(frame);
    case "decision":
      return decisions.show(frame);
    case "ahead":
      return series.footholds.foresee(frame);
    case "snapshot":
      return hearSnapshot(frame);
  }
}

/** @param {HelloFrame} frame */
function hearHello(frame) {
  ours = frame.lease_id;
  goBy(ours);
  watches = frame.watches;
  document.body.classList.toggle("watches", watches);
  world.watch(watches);
  showLease(lease, ours, watches);
  takeStyle(frame.style);
  if (greeted && greeted !== frame.started) say("The console was restarted: the machine stands at the start.");
  greeted = frame.started;
}

/** @param {RefusedFrame} frame */
function hearRefusal({ code, reason }) {
  if (code === "not_shown" && !stick.isHeld) return; // a last frame of the world before
  const text = refusalText(code, reason);
  if (text) say(text);
}

/**
 * A machine that nobody has moved yet shows what it can do.
 * @param {SnapshotFrame} s
 */
function playAtFirst(s) {
  seen = true;
  const fresh = s.step === 0 && s.mode === "stand" && s.posture === "stand" && !s.paused;
  if (watches || new URLSearchParams(location.search).has("stand")) return;
  if (fresh && !s.stopped && !s.playing && !lease.holder) world.play();
}

/** @param {SnapshotFrame} s */
function hearSnapshot(s) {
  // another world, or its beginning
  if (newest && s.tick < newest.tick) decisions.show(null);
  newest = s;
  document.body.classList.add("live");
  document.body.classList.toggle("on-trace", s.follows_trace);
  div("turn-control").hidden = div("turn-stick").hidden = !s.may_turn;
  if (s.stopped !== lease.stopped) {
    lease = { ...lease, stopped: s.stopped };
    showLease(lease, ours, watches);
  }
  if (!seen) playAtFirst(s);
  speakOf(s);
  showReadouts(s);
  series.add(s);
  world.show(s);
  course.follow(s);
  postures.show(s);
  showBanner(s);
  showTab();
}

new OwnFiles(letGo);
new GamepadHand(stick, {
  came: () => say("A gamepad: the left stick goes, the right one turns, B stops."),
  vanished: () => {
    letGo();
    say("The gamepad has gone: the machine stands.");
  },
  buttons: {
    1: stop,
    3: () => postures.sitOrStand(),
    9: () => world.pauseOrGo(),
  },
});
drawTicks();
explainWords();
chooseTopSpeed();
wireButtons();
letGoWhenLeft();
listenToKeys(stick, {
  stop,
  closeMenu,
  help,
  rate: (rate) => world.setRate(rate),
  shortcuts: SHORTCUTS,
});
showLease(lease, ours, watches);
