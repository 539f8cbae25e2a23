// Owns the /drive socket: repeats the newest command while the page lives, and lets go when it does
// not. In a worker, because heavy drawing stalls the page's own thread for hundreds of milliseconds.
//
// Every press of a hand has a number. A press that was let go of without the hand, since the page
// hung or its picture grew old, moves nothing any more: the next press does. A press that comes just
// after the page stood still, as pages do while they load, has moved nothing yet: it waits for a calm
// page, held all the while, instead of being let go at the next stall.

/**
 * @import {Command, DropReason, Health, PageMessage, PongFrame, Posture, RefusedFrame,
 *   ServerFrame, SnapshotFrame, WorkerMessage} from "./frames"
 */

const TICK = 20; // ms between looks at the clock
const REPEAT = 40; // ms between repeats of a held command
const SOONEST = 16; // ms between two frames: the server allows 100 a second
const PAGE_SILENT = 450; // ms without a sign of life from the page after which the machine holds
const STUTTERS = 300; // ms between two signs of life of the page: it is busy, and may be again
const STUTTERED = 3000; // ms after that in which a fresh press waits
const CALM = 400; // ms without that after which what waits moves
const WAITS = 6000; // ms a press waits at most
const SETTLE = 400; // ms for which a released stick is still repeated as zero
const IDLE_RELEASE = 6000; // ms at rest after which others may drive
const PING_EVERY = 250; // ms
const LATE = 600; // ms without a new picture, or without an answer, after which the hand is let go
const GONE = 3000; // ms of the same after which a new connection is tried
const OPENS_WITHIN = 6000; // ms a new connection may take
const STALLED = 250; // ms between two looks at the clock: this worker itself was not run
const HEALTH_EVERY = 100; // ms
const RETRY_FIRST = 250; // ms
const RETRY_MAX = 3000; // ms
// modes in which letting go of the lease would stop the machine half-way
const POSING = ["sit_down", "stand_up", "regroup"];

/** @type {Command} */
const REST = { crab_angle_rad: 0, speed_m_s: 0, turn_rate_rad_s: 0 };

/** @type {WebSocket | null} */
let socket = null;
let sequence = 0;
let tick = 0; // of the newest snapshot
let command = REST; // what is sent
let press = 0; // of a hand, the newest heard of
let dropped = 0; // the newest press that moves nothing any more
let pressSequence = 0; // of the first frame of the newest press
let looked = 0; // when the clock was looked at
let pictured = 0; // when the newest picture came
let pinged = 0; // when the ping was sent that is not answered yet; 0: none is out
let pingDue = 0;
let openBy = 0; // when a connection being made is given up
let healthSaid = 0;
/** @type {number | null} */
let roundTrip = null; // ms
let pageSeen = 0;
let stuttered = -Infinity; // when the page last came back from standing still
let waiting = 0; // the press that has moved nothing yet, for the page to be calm
let waitsUntil = 0;
let sentAt = 0;
let restSince = -Infinity;
let holding = false; // this page has the lease, as far as we know
let retry = RETRY_FIRST;

const now = () => performance.now();

/** @param {Command} c */
const rests = (c) => c.speed_m_s === 0 && c.turn_rate_rad_s === 0;

/** @param {WorkerMessage} message */
const tell = (message) => postMessage(message);

/** @param {object} frame */
function send(frame) {
  if (socket?.readyState === WebSocket.OPEN) socket.send(JSON.stringify(frame));
}

/** @param {boolean} by_hand whether what rests was let go of by a hand */
function drive(by_hand = press > dropped) {
  sentAt = now();
  send({ type: "drive", seq: sequence++, echo_tick: tick, ...command, by_hand });
}

/**
 * Hold, whatever the hand does: what it presses now moves nothing any more.
 * @param {DropReason} reason
 */
function drop(reason) {
  if (dropped === press) return;
  dropped = press;
  if (!rests(command)) {
    command = REST;
    restSince = now();
    drive();
  }
  tell({ type: "dropped", press, reason });
}

/**
 * What the page says of its stick.
 * @param {Command} next
 * @param {number} number of the press
 */
function follow(next, number) {
  if (number > press) {
    const anew = dropped === press; // so the hand has let go of what was dropped
    press = number;
    pressSequence = sequence;
    waitIfStuttering();
    if (anew) {
      drive(true);
      sentAt = -Infinity;
    }
  }
  if (isLate()) drop("late");
  if (now() - stuttered > CALM) waiting = 0;
  const obeyed = press > dropped && waiting !== press;
  obey(obeyed ? next : REST);
}

function waitIfStuttering() {
  const time = now();
  if (!rests(command) || time - stuttered > STUTTERED) return;
  waiting = press;
  waitsUntil = time + WAITS;
}

/** The page has not been heard for too long: a press that moves nothing yet may wait on. */
function pageIsSilent() {
  if (waiting !== press || now() > waitsUntil) drop("hung");
}

/** The page is heard. */
function seePage() {
  const time = now();
  if (time - pageSeen > STUTTERS) stuttered = time;
  pageSeen = time;
}

/** @param {Command} next */
function obey(next) {
  if (JSON.stringify(next) === JSON.stringify(command)) return;
  const rested = rests(command);
  command = next;
  if (!rests(next)) {
    if (now() - sentAt >= SOONEST) drive();
  } else if (!rested) {
    restSince = now();
    drive();
  }
}

function release() {
  const drove = !rests(command);
  command = REST;
  if (drove) drive();
  if (holding || drove) send({ type: "release" });
  holding = false;
  restSince = -Infinity;
}

/** @param {Posture} posture */
function pose(posture) {
  dropped = press;
  command = REST;
  restSince = now() - SETTLE;
  send({ type: "posture", seq: sequence++, echo_tick: tick, posture });
}

function stop() {
  dropped = press;
  command = REST;
  send({ type: "stop" });
}

function take() {
  restSince = now();
  send({ type: "take" });
}

function rearm() {
  dropped = press;
  command = REST;
  send({ type: "take" });
  drive(true); // the page has seen the stick at rest
  send({ type: "rearm" });
  restSince = now();
}

/** How old what the page shows may be, ms. */
const age = () => Math.max(now() - pictured, pinged && now() - pinged);

const isLate = () => socket?.readyState !== WebSocket.OPEN || age() > LATE;

/** The link as it is: said to the page, let go of when late, given up when gone. */
function watch() {
  const time = now();
  const stall = time - looked;
  looked = time;
  // not the link's fault: what has come meanwhile is still to be heard
  if (stall > STALLED) {
    pictured += stall;
    pageSeen += stall;
    if (pinged) pinged += stall;
  }
  if (stall > PAGE_SILENT && !rests(command)) drop("hung"); // and nobody has heard of it meanwhile
  if (socket?.readyState === WebSocket.OPEN) watchOpen(time);
  else if (socket && time > openBy) lose();
  if (time - healthSaid < HEALTH_EVERY) return;
  healthSaid = time;
  /** @type {Health} */
  const health = { age: age(), round_trip: roundTrip, late: isLate() };
  tell({ type: "health", health });
}

/** @param {number} time */
function watchOpen(time) {
  if (!pinged && time > pingDue) {
    pinged = time;
    send({ type: "ping", sent_ms: time, echo_tick: tick });
  }
  if (isLate()) drop("late");
  if (age() > GONE) lose();
}

function repeat() {
  watch();
  const time = now();
  if (time - pageSeen > PAGE_SILENT) pageIsSilent();
  const due = time - sentAt >= REPEAT - 5;
  if (!rests(command)) {
    if (due) drive();
    return;
  }
  const rested = time - restSince;
  if (rested < SETTLE && due) drive();
  else if (holding && rested > IDLE_RELEASE) {
    holding = false;
    send({ type: "release" });
  }
}

function connect() {
  const address = new URL("drive", self.location.href);
  address.protocol = address.protocol.replace("http", "ws");
  tell({ type: "link", state: "connecting" });
  const mine = new WebSocket(address);
  socket = mine;
  openBy = now() + OPENS_WITHIN;
  mine.onopen = () => {
    retry = RETRY_FIRST;
    tick = 0;
    pictured = now();
    pinged = 0;
    roundTrip = null;
  };
  mine.onmessage = (event) => hear(JSON.parse(event.data));
  mine.onclose = () => socket === mine && lose();
}

function lose() {
  const old = socket;
  socket = null;
  old?.close();
  drop("late");
  command = REST;
  holding = false;
  tell({ type: "link", state: "closed" });
  setTimeout(connect, retry);
  retry = Math.min(retry * 1.6, RETRY_MAX);
}

/** @param {ServerFrame} frame */
function hear(frame) {
  if (frame.type === "snapshot") hearSnapshot(frame);
  else if (frame.type === "lease") holding = frame.held;
  else if (frame.type === "hello") tell({ type: "link", state: "open" });
  else if (frame.type === "pong") return hearPong(frame);
  else if (frame.type === "refused") hearRefused(frame);
  tell({ type: "frame", frame });
}

/** @param {SnapshotFrame} frame */
function hearSnapshot(frame) {
  tick = frame.tick;
  pictured = now();
  if (holding && POSING.includes(frame.mode)) restSince = now();
}

/** @param {RefusedFrame} frame */
function hearRefused({ code, seq }) {
  if (code === "centre_first" && (seq ?? 0) > pressSequence) drop("refused");
}

/** @param {PongFrame} frame */
function hearPong({ sent_ms, kept_ms }) {
  roundTrip = Math.max(0, now() - sent_ms - kept_ms);
  pinged = 0;
  pingDue = now() + PING_EVERY;
}

/** @param {MessageEvent<PageMessage>} event */
onmessage = ({ data }) => {
  seePage();
  switch (data.type) {
    case "command":
    case "alive":
      return follow(data.command, data.press);
    case "posture":
      return pose(data.posture);
    case "release":
      return release();
    case "stop":
      return stop();
    case "take":
      return take();
    case "rearm":
      return rearm();
  }
};

connect();
setInterval(repeat, TICK);
