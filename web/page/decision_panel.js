// Why this leg: the decision of the running step, or of the last one refused, as a small panel.

/** @import {Candidate, DecisionFrame, LegTrial} from "./frames" */

import { element, make, write } from "./dom.js";
import { legName, legTitle } from "./machine_style.js";
import { millimetres } from "./readouts.js";
import { keep, saved } from "./settings.js";

/** @type {Record<string, string>} */
const SEARCHES = {
  paper: "the paper's own step keeps the standard walk",
  back: "looked ahead: back to the standard walk",
  near: "looked ahead: steps near the paper's",
  wide: "looked ahead: any foothold in reach",
  turn: "looked ahead: sequences of swings and sways along the arc",
};
const TRIED = [
  ["tried", "legs in the order they are tried"],
  ["pairs", "pairs of other feet that stand as in the standard walk"],
  ["return", "mm the foot can be brought forward"],
  ["", ""],
];
const WEIGHED = [
  ["ahead", "first leg to swing"],
  ["score", "way gained and promised, m"],
  ["", ""],
  ["steps", "steps it was followed"],
];
const SHOWN_SHIFT = 0.0005; // m of shift on all feet that is worth a word

export class DecisionPanel {
  constructor() {
    this.panel = element("decision", HTMLDetailsElement);
    this.body = element("decision-body", HTMLDivElement);
    /** @type {DecisionFrame | null} */
    this.decision = null;
    this.panel.open = saved.decision ?? false;
    this.panel.addEventListener("toggle", () => {
      keep({ decision: this.panel.open });
      this.#draw();
    });
  }

  /** @param {DecisionFrame | null} decision null: nothing is decided in this world yet */
  show(decision) {
    this.decision = decision;
    this.#draw();
  }

  #draw() {
    write("why", this.decision ? whyOf(this.decision) : "");
    if (!this.panel.open) return;
    const parts = this.decision ? partsOf(this.decision) : [muted("Nothing decided yet.")];
    this.body.replaceChildren(...parts);
  }
}

/**
 * The decision in one sentence with its numbers.
 * @param {DecisionFrame} decision
 */
function whyOf({ leg, shift_m, legs, candidates }) {
  const refused = legs.filter((trial) => trial.reason && trial.leg !== leg);
  const first = refused[0];
  const because = first ? ` ${legName(first.leg)} stays: ${first.reason}.` : "";
  if (!shift_m) return `No step.${because}`;
  const mine = candidates.find((way) => way.leg === leg)?.margin_m;
  const kept = mine ? `, keeping ${millimetres(mine)} mm of margin` : "";
  const who = leg === null ? "The body shifts" : `${legName(leg)} swings while the body goes`;
  return `${who} ${millimetres(shift_m[1])} mm${kept}.${because}`;
}

/** @param {DecisionFrame} decision */
const partsOf = (decision) => [
  answer(decision),
  ...searched(decision),
  ...tried(decision),
  ...weighed(decision),
  ...decision.notes.map(muted),
];

/** @param {string} text */
const muted = (text) => make("p", text, "muted");

/** @param {DecisionFrame} decision */
function answer({ leg, shift_m }) {
  if (!shift_m) return make("p", "No step", "bad");
  const [on_all_feet, whole] = shift_m;
  const head = make("p");
  const who = make("strong", leg === null ? "The body shifts" : `Leg ${legTitle(leg)}`);
  head.append(who, ` · goes ${millimetres(whole)} mm`);
  if (leg !== null && (on_all_feet ?? 0) > SHOWN_SHIFT) {
    head.append(`, ${millimetres(on_all_feet)} of it on all feet`);
  }
  return head;
}

/** @param {DecisionFrame} decision */
function searched({ escape, search }) {
  if (escape) return [muted(`a way out: ${escape}`)];
  return search ? [muted(SEARCHES[search] ?? search)] : [];
}

/**
 * Legs in the order the paper's rule tries them: pairs that stand as in the standard walk, then the
 * longest return.
 * @param {DecisionFrame} decision
 */
function tried({ legs, leg }) {
  if (!legs.length) return [];
  const table = make("table");
  table.append(headings(TRIED), ...legs.flatMap((trial) => trialRows(trial, trial.leg === leg)));
  return [table];
}

/**
 * @param {LegTrial} trial
 * @param {boolean} swings
 */
function trialRows(trial, swings) {
  const row = make("tr");
  const taken = swings && !trial.reason;
  row.append(
    make("td", legTitle(trial.leg)),
    make("td", "●".repeat(trial.agreeing_pairs ?? 0) || "–", "pairs"),
    make("td", millimetres(trial.return_m)),
    make("td", verdict(taken, trial.reason), taken ? "good" : "bad"),
  );
  const why = whyNot(trial);
  return why ? [row, wideRow(why)] : [row];
}

/**
 * @param {boolean} taken
 * @param {string} reason
 */
function verdict(taken, reason) {
  if (taken) return "✓";
  return reason ? "✗" : "·";
}

/** @param {LegTrial} trial */
function whyNot({ reason, refused }) {
  const count = Object.values(refused).reduce((sum, cells) => sum + cells, 0);
  const cells = `${count} cell${count > 1 ? "s" : ""} refused (${Object.keys(refused).join(", ")})`;
  return [reason, count ? cells : ""].filter(Boolean).join("; ");
}

/** @param {string} text */
function wideRow(text) {
  const row = document.createElement("tr");
  const cell = row.insertCell();
  cell.textContent = text;
  cell.className = "muted";
  cell.colSpan = TRIED.length;
  return row;
}

/**
 * What a lookahead weighed: score in metres of way, over the steps it was followed.
 * @param {DecisionFrame} decision
 */
function weighed({ candidates, search }) {
  if (!candidates.length || search === "paper") return [];
  const best = Math.max(...candidates.map((way) => way.score_m ?? 0), 1e-6);
  const table = make("table", "", "ways");
  table.append(headings(WEIGHED), ...candidates.map((way) => candidateRow(way, best)));
  return [table];
}

/**
 * @param {Candidate} way
 * @param {number} best m
 */
function candidateRow(way, best) {
  const score = way.score_m ?? 0;
  const fill = make("i");
  fill.style.width = `${Math.max(0, (100 * score) / best)}%`;
  const bar = make("td", "", "bar");
  bar.append(fill);
  const row = make("tr");
  row.title = `margin ${millimetres(way.margin_m)} mm, body goes ${millimetres(way.g_m)} mm`;
  const who = make("td", way.leg === null ? "shift" : legTitle(way.leg));
  row.append(who, make("td", score.toFixed(2)), bar, make("td", String(way.steps)));
  return row;
}

/** @param {string[][]} columns text and explanation */
function headings(columns) {
  const row = make("tr");
  for (const [text, title] of columns) {
    const cell = make(text ? "th" : "td", text);
    cell.title = title;
    row.append(cell);
  }
  return row;
}
