// A course in figures: crab angle, speed and distance from boxes. It can be planned ahead before it
// is walked, and it is walked while a button is held, as far as the distance says.

/** @import {Joystick} from "./joystick.js" */
/** @import {ViserFrame} from "./viser_frame.js" */
/** @import {Place, Route, SnapshotFrame, StickValue} from "./frames" */

import { ask } from "./api.js";
import { button, input, write } from "./dom.js";
import { onPress } from "./press.js";
import { degrees, sentence } from "./readouts.js";
import { REST } from "./stick_values.js";

const LOOK = 120; // ms between looks where a click has pointed

export class ExactCourse {
  /**
   * @param {Joystick} stick
   * @param {ViserFrame} scene
   */
  constructor(stick, scene) {
    this.stick = stick;
    this.scene = scene;
    this.pointer = button("course-point");
    this.pointed = ""; // as the scene last said
    this.points = () => {}; // somebody begins to point: for who else wants the clicks
    this.angle = input("course-angle");
    this.speed = input("course-speed");
    this.distance = input("course-distance");
    this.button = button("course-go");
    /** @type {SnapshotFrame | null} */
    this.newest = null;
    /** @type {Place} */
    this.began = { x: 0, y: 0 }; // m, where the hold did
    /** @type {number | string | null} */
    this.holder = null; // a pointer or a key
    stick.others.push(this);
    this.#listen();
  }

  get isHeld() {
    return this.holder !== null;
  }

  /** @returns {StickValue} */
  get value() {
    if (!this.isHeld) return REST;
    const angle = this.#crabAngle();
    return { x: Math.cos(angle), y: Math.sin(angle), turn: 0, speed: this.speed.valueAsNumber };
  }

  #crabAngle() {
    return (this.angle.valueAsNumber * Math.PI) / 180;
  }

  get isPointing() {
    return this.pointer.getAttribute("aria-pressed") === "true";
  }

  /** @param {boolean} on whether a click on the ground says where to go */
  point(on) {
    if (on === this.isPointing) return;
    this.pointer.setAttribute("aria-pressed", String(on));
    if (on) this.points();
    this.pointed = this.scene.pointed;
    this.scene.set("Point", on);
    this.scene.paints(on);
    write("course-answer", on ? "Click the ground: where to?" : "");
  }

  #lookWherePointed() {
    const said = this.isPointing ? this.scene.pointed : this.pointed;
    if (said === this.pointed || !this.newest || this.isHeld) return;
    this.pointed = said;
    const [x, y] = said.split(" ").map(Number);
    const [bodyX, bodyY, , , , yaw] = this.newest.body;
    const angle = Math.atan2(y - bodyY, x - bodyX) - yaw;
    this.angle.value = degrees(Math.atan2(Math.sin(angle), Math.cos(angle))).toFixed(1);
    this.distance.value = Math.hypot(x - bodyX, y - bodyY).toFixed(2);
    this.#lookAhead();
  }

  /** @param {SnapshotFrame} s */
  follow(s) {
    this.newest = s;
    if (!this.isHeld) return;
    const gone = Math.hypot(s.body[0] - this.began.x, s.body[1] - this.began.y);
    if (gone < this.distance.valueAsNumber) return;
    this.letGo();
    this.stick.show();
    write("course-answer", "There.");
  }

  /** Whether, in how many steps and how long, or why not: before anything moves. */
  async #lookAhead() {
    if (!this.newest || !this.#isFilledIn()) return;
    const [x, y, , , , yaw] = this.newest.body;
    const bearing = yaw + this.#crabAngle();
    const far = this.distance.valueAsNumber;
    write("course-answer", "Planning …");
    try {
      /** @type {Route} */
      const route = await ask("POST", "console/route", {
        x_m: x + far * Math.cos(bearing),
        y_m: y + far * Math.sin(bearing),
        speed_m_s: this.speed.valueAsNumber,
      });
      write("course-answer", answerOf(route));
    } catch (error) {
      write("course-answer", error instanceof Error ? error.message : String(error));
    }
  }

  #isFilledIn() {
    return [this.angle, this.speed, this.distance].every((box) => box.reportValidity());
  }

  letGo() {
    this.holder = null;
    this.button.setAttribute("aria-pressed", "false");
  }

  #listen() {
    onPress(button("course-ahead"), () => this.#lookAhead());
    onPress(this.pointer, () => this.point(!this.isPointing));
    setInterval(() => this.#lookWherePointed(), LOOK);
    this.button.addEventListener("pointerdown", (event) => {
      if (event.button !== 0) return;
      this.button.setPointerCapture(event.pointerId);
      this.#hold(event.pointerId);
    });
    for (const end of /** @type {const} */ (["pointerup", "pointercancel", "lostpointercapture"])) {
      this.button.addEventListener(end, ({ pointerId }) => this.#lift(pointerId));
    }
    this.button.addEventListener("keydown", ({ key, repeat }) => {
      if (key === "Enter" && !repeat) this.#hold(key);
    });
    this.button.addEventListener("keyup", ({ key }) => this.#lift(key));
    this.button.addEventListener("blur", () => this.#lift(this.holder));
    this.button.addEventListener("contextmenu", (event) => event.preventDefault());
  }

  /** @param {number | string} holder */
  #hold(holder) {
    if (this.isHeld || !this.#isFilledIn()) return;
    this.holder = holder;
    const [x, y] = this.newest?.body ?? [0, 0];
    this.began = { x, y };
    this.button.setAttribute("aria-pressed", "true");
    this.stick.pressed();
    this.stick.show();
  }

  /** @param {number | string | null} holder */
  #lift(holder) {
    if (holder === null || holder !== this.holder) return;
    this.letGo();
    this.stick.show();
  }
}

/** @param {Route} route */
function answerOf({ reachable, steps, time_s, distance_m, reason }) {
  if (reachable) return `Reached in about ${steps} steps and ${time_s.toFixed(0)} s.`;
  return `Not reached: it ends after ${distance_m.toFixed(1)} m. ${sentence(reason)}`;
}
