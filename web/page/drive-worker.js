// Owns the /drive socket: repeats the newest command while the page lives, and lets go when it does not.
// In a worker, because heavy drawing stalls the page's own thread for hundreds of milliseconds.

const REPEAT = 40;        // ms between repeats of a held command
const SOONEST = 16;       // ms between two frames: the server allows 100 a second
const PAGE_SILENT = 500;  // ms without a sign of life from the page after which the machine holds
const SETTLE = 400;       // ms for which a released stick is still repeated as zero
const IDLE_RELEASE = 6000; // ms at rest after which others may drive
const POSING = ["sit_down", "stand_up", "regroup"]; // modes in which letting go of the lease would stop the machine half-way

const REST = { crab_angle_rad: 0, speed_m_s: 0, turn_rate_rad_s: 0 };

let socket = null;
let sequence = 0;
let tick = 0;
let command = REST;       // what is sent
let pageSeen = 0;
let sentAt = 0;
let restSince = -Infinity;
let holding = false;      // this page has the lease, as far as we know
let retry = 250;
let again = 0;

const now = () => performance.now();
const rests = (c) => c.speed_m_s === 0 && c.turn_rate_rad_s === 0;
const tell = (type, more = {}) => postMessage({ type, ...more });

function say(frame) {
  if (socket?.readyState !== WebSocket.OPEN) return false;
  socket.send(JSON.stringify(frame));
  return true;
}

function drive() {
  sentAt = now();
  say({ type: "drive", seq: sequence++, echo_tick: tick, ...command });
}

function obey(next) {
  if (JSON.stringify(next) === JSON.stringify(command)) return;
  const rested = rests(command);
  command = next;
  if (rests(next)) {
    if (!rested) { restSince = now(); drive(); }
  } else if (now() - sentAt >= SOONEST) drive();
}

function letGo() {
  const drove = !rests(command);
  command = REST;
  if (drove) drive();
  if (holding || drove) say({ type: "release" });
  holding = false;
  restSince = -Infinity;
}

function pose(posture) {
  command = REST;
  restSince = now() - SETTLE;
  say({ type: "posture", seq: sequence++, echo_tick: tick, posture });
}

function beat() {
  const time = now();
  if (!rests(command) && time - pageSeen > PAGE_SILENT) obey(REST); // its next sign of life says what the stick says then
  if (!rests(command)) { if (time - sentAt >= REPEAT - 5) drive(); return; }
  const rested = time - restSince;
  if (rested < SETTLE && time - sentAt >= REPEAT - 5) drive();
  else if (holding && rested > IDLE_RELEASE) { holding = false; say({ type: "release" }); }
}

function connect() {
  clearTimeout(again);
  const address = new URL("/drive", self.location.href);
  address.protocol = address.protocol.replace("http", "ws");
  tell("link", { state: "connecting" });
  const mine = new WebSocket(address);
  socket = mine;
  mine.onopen = () => { retry = 250; tick = 0; };
  mine.onmessage = (event) => hear(JSON.parse(event.data));
  mine.onclose = (event) => {
    if (socket !== mine) return;
    socket = null;
    command = REST;
    holding = false;
    tell("link", { state: "closed", reason: event.reason });
    again = setTimeout(connect, retry);
    retry = Math.min(retry * 1.6, 3000);
  };
}

function hear(frame) {
  if (frame.type === "snapshot") {
    tick = frame.tick;
    if (holding && POSING.includes(frame.mode)) restSince = now();
  }
  else if (frame.type === "lease") holding = frame.held;
  else if (frame.type === "hello") tell("link", { state: "open" });
  tell(frame.type, { frame });
}

onmessage = ({ data }) => {
  pageSeen = now();
  if (data.type === "command" || data.type === "alive") obey(data.command);
  else if (data.type === "release") letGo();
  else if (data.type === "posture") pose(data.posture);
  else if (data.type === "stop") { command = REST; say({ type: "stop" }); }
  else if (data.type === "take") { restSince = now(); say({ type: "take" }); }
  else if (data.type === "rearm") { command = REST; say({ type: "take" }); drive(); say({ type: "rearm" }); restSince = now(); }
  else if (data.type === "reconnect" && !socket) connect();
};

connect();
setInterval(beat, 20);
