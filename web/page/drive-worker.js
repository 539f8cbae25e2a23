// Owns the /drive socket: repeats the newest command while the page lives, and lets go when it does
// not. In a worker, because heavy drawing stalls the page's own thread for hundreds of milliseconds.

/** @import {Command, PageMessage, Posture, ServerFrame, WorkerMessage} from "./frames" */

const TICK = 20; // ms between looks at the clock
const REPEAT = 40; // ms between repeats of a held command
const SOONEST = 16; // ms between two frames: the server allows 100 a second
const PAGE_SILENT = 500; // ms without a sign of life from the page after which the machine holds
const SETTLE = 400; // ms for which a released stick is still repeated as zero
const IDLE_RELEASE = 6000; // ms at rest after which others may drive
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
let pageSeen = 0;
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

function drive() {
  sentAt = now();
  send({ type: "drive", seq: sequence++, echo_tick: tick, ...command });
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
  command = REST;
  restSince = now() - SETTLE;
  send({ type: "posture", seq: sequence++, echo_tick: tick, posture });
}

function stop() {
  command = REST;
  send({ type: "stop" });
}

function take() {
  restSince = now();
  send({ type: "take" });
}

function rearm() {
  command = REST;
  send({ type: "take" });
  drive();
  send({ type: "rearm" });
  restSince = now();
}

function repeat() {
  const time = now();
  // its next sign of life says what the stick says then
  if (!rests(command) && time - pageSeen > PAGE_SILENT) obey(REST);
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
  mine.onopen = () => {
    retry = RETRY_FIRST;
    tick = 0;
  };
  mine.onmessage = (event) => hear(JSON.parse(event.data));
  mine.onclose = () => socket === mine && lose();
}

function lose() {
  socket = null;
  command = REST;
  holding = false;
  tell({ type: "link", state: "closed" });
  setTimeout(connect, retry);
  retry = Math.min(retry * 1.6, RETRY_MAX);
}

/** @param {ServerFrame} frame */
function hear(frame) {
  if (frame.type === "snapshot") {
    tick = frame.tick;
    if (holding && POSING.includes(frame.mode)) restSince = now();
  } else if (frame.type === "lease") holding = frame.held;
  else if (frame.type === "hello") tell({ type: "link", state: "open" });
  tell({ type: "frame", frame });
}

/** @param {MessageEvent<PageMessage>} event */
onmessage = ({ data }) => {
  pageSeen = now();
  switch (data.type) {
    case "command":
    case "alive":
      return obey(data.command);
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
