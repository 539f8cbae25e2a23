// Why this leg: the decision of the running step, or of the last one refused, as a small panel.

import { legNames } from "./readouts.js";

const SEARCHES = {
  paper: "the paper's own step keeps the standard walk", back: "looked ahead: back to the standard walk",
  near: "looked ahead: steps near the paper's", wide: "looked ahead: any foothold in reach",
  turn: "looked ahead: sequences of swings and sways along the arc",
};
const OPEN = "walking-console.why";

const mm = (value) => (value === null || value === undefined ? "–" : `${Math.round(value * 1000)}`);

function make(tag, text = "", name = "") {
  const made = document.createElement(tag);
  made.textContent = text;
  if (name) made.className = name;
  return made;
}

function headings(columns) {
  const row = make("tr");
  for (const [text, title] of columns) {
    const cell = make("th", text);
    cell.title = title;
    row.append(cell);
  }
  return row;
}

export class Why {
  constructor(panel) {
    this.panel = panel;
    this.body = panel.querySelector("div");
    this.frame = null;
    this.legs = 4;
    panel.open = localStorage.getItem(OPEN) === "yes";
    panel.addEventListener("toggle", () => { localStorage.setItem(OPEN, panel.open ? "yes" : "no"); this.#draw(); });
  }

  tell(frame, legs) {
    this.frame = frame;
    this.legs = legs;
    this.#draw();
  }

  forget() {
    this.frame = null;
    this.#draw();
  }

  #name(leg) {
    if (leg === null) return "all four stand";
    const name = legNames(this.legs)[leg - 1];
    return name === String(leg) ? name : `${leg} ${name}`;
  }

  #draw() {
    if (!this.panel.open) return;
    const told = this.frame;
    if (!told) return this.body.replaceChildren(make("p", "Nothing decided yet.", "muted"));
    this.body.replaceChildren(...this.#answer(told), ...this.#tried(told), ...this.#ways(told), ...told.notes.map((note) => make("p", note, "muted")));
  }

  #answer(told) {
    const parts = [];
    if (told.shift_m) {
      const head = make("p");
      head.append(make("strong", told.leg === null ? "The body shifts" : `Leg ${this.#name(told.leg)}`), ` · goes ${mm(told.shift_m[1])} mm`);
      if (told.shift_m[0] > 0.0005 && told.leg !== null) head.append(`, ${mm(told.shift_m[0])} of it on all feet`);
      parts.push(head);
    } else parts.push(make("p", "No step", "bad"));
    if (told.escape) parts.push(make("p", `a way out: ${told.escape}`, "muted"));
    else if (told.search) parts.push(make("p", SEARCHES[told.search] ?? told.search, "muted"));
    return parts;
  }

  // legs in the order the paper's rule tries them: pairs that stand as in the standard walk, then the longest return
  #tried(told) {
    if (!told.legs.length) return [];
    const table = make("table");
    table.append(headings([["tried", "legs in the order they are tried"], ["pairs", "pairs of other feet that stand as in the standard walk"], ["return", "mm the foot can be brought forward"], ["", ""]]));
    for (const trial of told.legs) {
      const row = make("tr");
      const refused = Object.values(trial.refused).reduce((sum, count) => sum + count, 0);
      const taken = trial.leg === told.leg && !trial.reason;
      row.append(make("td", this.#name(trial.leg)), make("td", "●".repeat(trial.agreeing_pairs ?? 0) || "–", "pairs"), make("td", mm(trial.return_m)), make("td", taken ? "✓" : trial.reason ? "✗" : "·", taken ? "good" : "bad"));
      table.append(row);
      const why = [trial.reason, refused ? `${refused} cell${refused > 1 ? "s" : ""} refused (${Object.keys(trial.refused).join(", ")})` : ""].filter(Boolean).join("; ");
      if (!why) continue;
      const line = make("tr");
      const cell = make("td", why, "muted");
      cell.colSpan = 4;
      line.append(cell);
      table.append(line);
    }
    return [table];
  }

  // what a lookahead weighed: score in metres of way, over the steps it was followed
  #ways(told) {
    if (!told.candidates.length || told.search === "paper") return [];
    const best = Math.max(...told.candidates.map((way) => way.score_m ?? 0), 1e-6);
    const list = make("table", "", "ways");
    list.append(headings([["ahead", "first leg to swing"], ["score", "way gained and promised, m"], ["", ""], ["steps", "steps it was followed"]]));
    told.candidates.forEach((way) => {
      const row = make("tr");
      const bar = make("td", "", "bar");
      const fill = make("i");
      fill.style.width = `${Math.max(0, (100 * (way.score_m ?? 0)) / best)}%`;
      bar.append(fill);
      row.append(make("td", way.leg === null ? "shift" : this.#name(way.leg)), make("td", (way.score_m ?? 0).toFixed(2)), bar, make("td", String(way.steps)));
      row.title = `margin ${mm(way.margin_m)} mm, body goes ${mm(way.g_m)} mm`;
      list.append(row);
    });
    return [list];
  }
}
