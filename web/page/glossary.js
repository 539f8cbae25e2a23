// The field's words: said where they stand on the page when the pointer rests on them, and all
// together in the help.

import { element, make } from "./dom.js";

/** @type {Record<string, string>} */
const WORDS = {
  "Crab angle": "Where the body goes, measured from where it points: 0° is ahead, 90° to its left.",
  "Support polygon": "What the feet that carry span on the ground. The centre of gravity must stay above it.",
  "Longitudinal margin": "How far the centre of gravity is from the edge of the support polygon, along the course.",
  "Polygon margin": "The least distance from the centre of gravity to any edge of the support polygon. Below nought the machine tips.",
  "Energy margin": "How high the centre of gravity would have to rise before the machine tips over the weakest edge.",
  Step: "One leg lifted and set down again.",
  "Swing leg": "The leg in the air.",
  Foothold: "Where a foot stands, or may.",
  "Search domain": "Where the planner looks for the next foothold: in reach, and keeping the margin.",
  "Standard gait": "The gait of level ground, to which the walk comes back after every obstacle.",
  Late: "How long after its time the newest tick came.",
  "Off trace": "How far the body is from the trace it was given.",
  "crab planner": "Hirose's: goes whichever way the stick points, leg by leg.",
  "trace planner": "Kugushev's: plans footholds far ahead along a way, where hardly any ground may be stepped on.",
  "predictive, paper, naive": "How the crab planner chooses: looking several steps ahead; by the paper's rules, made safe; as that paper warns against.",
};

/** Say what the words mean, wherever they stand. */
export function explainWords() {
  for (const label of document.querySelectorAll("dt, .label, .field span")) {
    const meaning = WORDS[label.textContent?.trim() ?? ""];
    if (meaning) label.setAttribute("title", meaning);
  }
  const list = element("words", HTMLDListElement);
  for (const [word, meaning] of Object.entries(WORDS)) {
    const entry = make("div", "");
    entry.append(make("dt", word), make("dd", meaning));
    list.append(entry);
  }
}
