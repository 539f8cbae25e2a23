// Which world is walked in, and how its time goes: scenario, robot, planner mode, pause, rate.

/** @import {Played, SnapshotFrame} from "./frames" */

import { ask, order } from "./api.js";
import { button, buttons, div, element, make, mark, write } from "./dom.js";
import { Gallery } from "./gallery.js";
import { onPress } from "./press.js";
import { say } from "./status.js";

const ADVANCE_TICKS = 25; // half a second
const TWICE = 2500; // ms within which a key that loses the walk must be pressed again

export class WorldControls {
  /** @param {() => void} letGo called before another world is loaded, and before a pause */
  constructor(letGo) {
    this.letGo = letGo;
    this.gallery = new Gallery(letGo, (name, plays) => this.#begin(name, plays));
    this.scenario = element("scenario", HTMLSelectElement);
    this.robot = element("robot", HTMLSelectElement);
    this.mode = element("planner-mode", HTMLSelectElement);
    this.plant = element("plant", HTMLSelectElement);
    this.bodyWay = element("body-way", HTMLSelectElement);
    this.rates = buttons("#rate button");
    this.loading = false;
    this.wasPlaying = false;
    this.resetAsked = -Infinity; // ms
    /** @type {Played | null} */
    this.played = null; // how the timeline ended, until it is driven on
    /** @type {SnapshotFrame | null} */
    this.newest = null;
    this.#listen();
  }

  #listen() {
    onChoice(this.scenario, () => this.#load({ name: this.scenario.value, plant: this.plant.value }));
    for (const list of [this.robot, this.plant]) onChoice(list, () => this.#loadAgain({}));
    onChoice(this.bodyWay, () => this.#loadAgain({ body_way: this.bodyWay.value }));
    onChoice(this.mode, () => this.#loadAgain({ mode: this.mode.value }));
    onPress(button("play"), () => this.play());
    onPress(button("again"), () => this.play());
    onPress(button("free-stick"), () => this.#loadAgain({ free_stick: true }));
    onPress(button("pause"), () => this.pauseOrGo());
    onPress(button("advance"), () => this.advance());
    onPress(button("reset"), () => this.reset());
    for (const one of this.rates) onPress(one, () => this.setRate(Number(one.dataset.rate)));
  }

  /**
   * @param {string} action
   * @param {object} [body]
   */
  #post(action, body) {
    return order(say, "POST", `console/${action}`, body);
  }

  pauseOrGo() {
    if (this.newest?.paused) return this.#post("resume");
    this.letGo(); // by the socket, which is sooner there
    return this.#post("pause");
  }

  advance() {
    if (this.newest?.paused) this.#post("advance", { ticks: ADVANCE_TICKS });
  }

  /** @param {boolean} only whether this page may watch and no more */
  watch(only) {
    const lists = [this.scenario, this.robot, this.mode, this.plant, this.bodyWay];
    for (const list of lists) list.disabled = only;
  }

  /** Walk by the scenario's own timeline, from its start. */
  play() {
    this.letGo();
    return this.#post("play");
  }

  reset() {
    return this.#post("reset");
  }

  /** A key may be pressed in passing. */
  resetByKey() {
    const asked = this.resetAsked;
    this.resetAsked = performance.now();
    if (this.resetAsked - asked < TWICE) this.reset();
    else say("Press Backspace again to go back to the start.");
  }

  /** @param {number} rate */
  setRate(rate) {
    return this.#post("rate", { rate });
  }

  /** @param {object} changed */
  #loadAgain(changed) {
    const { scenario, robot, plant } = this;
    return this.#load({ name: scenario.value, robot: robot.value, plant: plant.value, ...changed });
  }

  /** @param {object} world */
  async #load(world) {
    this.loading = true;
    this.letGo();
    document.body.classList.add("loading");
    const loaded = await order(say, "PUT", "console/scenario", world);
    document.body.classList.remove("loading");
    this.loading = false;
    return loaded;
  }

  /**
   * @param {string} name
   * @param {boolean} plays by itself, or stands and waits for the stick
   */
  async #begin(name, plays) {
    if ((await this.#load({ name, free_stick: !plays })) && plays) this.play();
  }

  /** Ask for all there is to choose from. */
  async fillLists() {
    try {
      const [scenarios, robots] = await Promise.all([ask("GET", "scenarios"), ask("GET", "robots")]);
      fill(this.scenario, scenarios, (one) => one.name);
      this.gallery.fill(scenarios);
      fill(this.robot, robots, (one) => `${one.name} · ${one.legs} legs`);
      if (this.newest) this.#choose(this.newest);
    } catch (error) {
      say(error instanceof Error ? error.message : String(error));
    }
  }

  /** @param {SnapshotFrame} s */
  show(s) {
    this.newest = s;
    this.#choose(s);
    button("pause").setAttribute("aria-pressed", String(s.paused));
    button("advance").disabled = !s.paused;
    mark(this.rates, "rate", String(s.rate), "aria-checked");
    this.mode.hidden = s.follows_trace;
    this.#showCourse(s);
  }

  async #askPlayed() {
    try {
      this.#showPlayed(await ask("GET", "console/played"));
    } catch {
      this.#showPlayed(null); // the server has gone: there is nothing to show
    }
  }

  /**
   * What of the expected came, ticked off.
   * @param {Played | null} played
   */
  #showPlayed(played) {
    if (this.played === played) return;
    this.played = played;
    const lines = Object.entries(played?.expected ?? {}).map(([key, { wanted, got, pass }]) =>
      make("li", `${expectation(key)} ${wanted}${unitOf(key)}: ${rounded(got)}`, pass ? "good" : "bad"),
    );
    const list = div("expected");
    list.replaceChildren(...lines);
    list.hidden = !lines.length;
  }

  /**
   * @param {boolean} playing
   * @param {boolean} arrived
   */
  #courseText(playing, arrived) {
    if (playing) return "Playing by itself: touch the stick to drive";
    if (this.played) return ENDINGS[this.played.result] ?? "";
    return arrived ? "Its trace is walked" : "Follows its trace: stick = speed";
  }

  /** @param {SnapshotFrame} s */
  #showCourse({ given_trace, playing, blocked_by, speed_m_s }) {
    if (this.wasPlaying && !playing) this.#askPlayed();
    if (playing || speed_m_s > 0) this.#showPlayed(null);
    this.wasPlaying = playing;
    div("course-choice").hidden = !given_trace && !playing && !this.played;
    write("course-text", this.#courseText(playing, blocked_by === "arrived"));
    button("free-stick").hidden = !given_trace;
    button("again").hidden = playing;
  }

  /** @param {SnapshotFrame} s */
  #choose(s) {
    if (this.loading) return;
    choose(this.scenario, s.scenario);
    choose(this.robot, s.robot);
    choose(this.mode, s.planner_mode);
    choose(this.plant, s.plant);
    choose(this.bodyWay, s.body_way);
  }
}

/**
 * A choice is made by picking from the open list, or with Enter: arrow keys only look through it.
 * @param {HTMLSelectElement} list
 * @param {() => void} act
 */
function onChoice(list, act) {
  let looks = false;
  let open = false;
  list.addEventListener("pointerdown", () => {
    open = true;
    looks = false;
  });
  list.addEventListener("keydown", ({ key, altKey }) => {
    open = false; // an open list keeps its keys for itself
    if (key === "Enter" && looks) act();
    looks = key !== "Enter" && (looks || !altKey) && key !== "Tab" && key !== "Escape";
  });
  list.addEventListener("change", () => {
    if (open || !looks) act();
    if (open) looks = false;
    open = false;
  });
  list.addEventListener("blur", () => {
    looks = false;
    open = false;
  });
}

/** @type {Record<string, string>} */
const ENDINGS = {
  completed: "The scenario is walked to its end", blocked: "The way ended here",
  fell: "The machine fell", interrupted: "The walk was interrupted",
};

/**
 * "distance_min" as people read it: "distance at least".
 * @param {string} key
 */
const expectation = (key) =>
  key.replace(/_min$/, " at least").replace(/_max$/, " at most").replaceAll("_", " ");

/** @type {[RegExp, string][]} */
const UNITS = [[/speed/, " m/s"], [/^time/, " s"], [/distance|margin|off_line|off_trace/, " m"]];

/** @param {string} key */
const unitOf = (key) => UNITS.find(([pattern]) => pattern.test(key))?.[1] ?? "";

/** @param {number | null} figure */
const rounded = (figure) => (figure === null ? "–" : String(Number(figure.toFixed(3))));

/**
 * @typedef {object} Choice
 * @property {string} name
 * @property {string} title
 * @property {number} [legs]
 */

/**
 * @param {HTMLSelectElement} list
 * @param {Choice[]} choices
 * @param {(choice: Choice) => string} textOf
 */
function fill(list, choices, textOf) {
  list.replaceChildren(...choices.map((one) => option(one.name, textOf(one), one.title)));
}

/**
 * @param {string} value
 * @param {string} text
 * @param {string} title
 */
function option(value, text, title) {
  const made = new Option(text, value);
  made.title = title;
  return made;
}

/**
 * Show a value in a list, unless somebody is choosing in it.
 * @param {HTMLSelectElement} list
 * @param {string} value
 */
function choose(list, value) {
  if (list.value === value || document.activeElement === list) return;
  const known = [...list.options].some((one) => one.value === value);
  if (list.options.length && !known) list.add(option(value, value, ""));
  list.value = value;
}
