// The frames of /drive as the page reads them, and what it says to its worker. Types only.

export interface Palette {
  legs: string[];
  good: string;
  warn: string;
  bad: string;
  path: string;
}

export interface Style {
  palette: Palette;
  margin_good_m: number;
  leg_names: string[];
}

export interface Command {
  crab_angle_rad: number;
  speed_m_s: number;
  turn_rate_rad_s: number;
}

export type Posture = "sit" | "stand" | "standard";
export type Attitude = "level" | "ground";

export interface HelloFrame {
  type: "hello";
  lease_id: string;
  started: string;
  dead_man_s: number;
  watches: boolean;
  style: Style;
}

export interface StyleFrame extends Style {
  type: "style";
}

export interface LeaseFrame {
  type: "lease";
  held: boolean;
  holder: string | null;
  holder_title: string | null;
  stopped: boolean;
}

export interface PongFrame {
  type: "pong";
  sent_ms: number;
  kept_ms: number;
}

export interface RefusedFrame {
  type: "refused";
  seq: number | null;
  code: string;
  reason: string;
}

export interface SnapshotFrame extends Command {
  type: "snapshot";
  tick: number;
  time_s: number;
  robot: string;
  scenario: string;
  planner: string;
  planner_mode: string;
  plant: string;
  body_way: string;
  body: number[];
  feet: number[][];
  contact: boolean[];
  support: boolean[];
  mode: string;
  reason: string;
  blocked_by: string;
  walked_m_s: number;
  speed_max_m_s: number;
  sway_slows: boolean;
  margin_m: number | null;
  polygon_margin_m: number | null;
  flags: boolean[]; // F1, F2, F3 of H §9.3
  energy_margin_m: number | null;
  contact_margin_m: number | null;
  step: number;
  distance_m: number;
  swing: number[];
  paused: boolean;
  rate: number;
  late_s: number;
  attitude: Attitude;
  posture: Posture;
  course_m: number;
  off_trace_m: number | null;
  departure: string;
  may_lean: boolean;
  may_turn: boolean;
  follows_trace: boolean;
  given_trace: boolean;
  playing: boolean;
  stopped: boolean;
  fault: string;
}

/** s1 and s2 of a foothold's existence segment, and where on it the foot is placed and lifted. */
export type Segment = [number, number, number, number];

export interface AheadFrame {
  type: "ahead";
  segments_m: Segment[][];
  states_m: [number, number][];
  reached_m: number | null;
  goal_m: number | null;
  complete: boolean;
  reason: string;
}

/** Sent when nothing is foreseen any more. */
export interface NothingAheadFrame {
  type: "ahead";
  segments_m?: undefined;
}

export interface LegTrial {
  leg: number;
  agreeing_pairs: number | null;
  return_m: number | null;
  reason: string;
  refused: Record<string, number>;
}

export interface Candidate {
  leg: number | null;
  score_m: number | null;
  steps: number;
  margin_m: number | null;
  g_m: number | null;
}

export interface DecisionFrame {
  type: "decision";
  step: number;
  leg: number | null;
  shift_m: [number | null, number | null] | null;
  legs: LegTrial[];
  search: string;
  escape: string;
  candidates: Candidate[];
  notes: string[];
}

export type ServerFrame =
  | HelloFrame
  | StyleFrame
  | LeaseFrame
  | RefusedFrame
  | PongFrame
  | SnapshotFrame
  | AheadFrame
  | NothingAheadFrame
  | DecisionFrame;

export type LinkState = "connecting" | "open" | "closed";

/** Page to worker. */
export type PageMessage =
  | { type: "command"; command: Command; press: number }
  | { type: "alive"; command: Command; press: number }
  | { type: "posture"; posture: Posture }
  | { type: "release" }
  | { type: "stop" }
  | { type: "take" }
  | { type: "rearm" };

/** Why a press was let go of without the hand. */
export type DropReason = "late" | "hung" | "refused";

/** Worker to page. */
export type WorkerMessage =
  | { type: "link"; state: LinkState }
  | { type: "health"; health: Health }
  | { type: "dropped"; press: number; reason: DropReason }
  | { type: "frame"; frame: ServerFrame };

/** How old what the page shows is, and how long the way to the server and back takes, ms. */
export interface Health {
  age: number;
  round_trip: number | null;
  late: boolean;
}

/**
 * What the stick asks for: x forward and y left with a length of at most 1, turn from -1 to 1; and
 * the speed at full length, m/s, where it is not the slider's.
 */
export interface StickValue {
  x: number;
  y: number;
  turn: number;
  speed?: number;
}

/** On the ground, m. */
export interface Place {
  x: number;
  y: number;
}

/** A way as it was planned ahead. */
export interface Route {
  reachable: boolean;
  steps: number;
  time_s: number;
  distance_m: number;
  left_m: number;
  reason: string;
}

/** How a scenario's timeline ended, and what of the expected came. */
export interface Played {
  result: string;
  reason: string;
  expected: Record<string, { wanted: number; got: number | null; pass: boolean }>;
}

/** What the browser keeps for its user. */
export interface Saved {
  repeats?: boolean; // held keys repeat here
  speed?: string;
  strips?: boolean;
  light?: boolean;
  camera?: string;
  tab?: string;
  brush?: string;
  decision?: boolean;
  layers?: Record<string, boolean>;
}

/** Sentences beside a tone: what is wrong. */
export interface Trouble {
  tone: "good" | "warn" | "bad";
  title: string;
  detail: string;
}
