// Postures, and whether the body follows the ground.

/** @import {Attitude, Posture, SnapshotFrame} from "./frames" */

import { order } from "./api.js";
import { buttons, div, mark } from "./dom.js";
import { onPress } from "./press.js";
import { say } from "./status.js";

/** @type {Record<string, Posture>} */
const POSTURE_OF_MODE = {
  sit_down: "sit", sit: "sit", stand_up: "stand", regroup: "standard",
};

export class PostureControls {
  /** @param {(posture: Posture) => void} pose */
  constructor(pose) {
    this.pose = pose;
    this.postures = buttons("#postures button");
    this.attitudes = buttons("#attitudes button");
    /** @type {SnapshotFrame | null} */
    this.newest = null;
    for (const one of this.postures) {
      onPress(one, () => pose(/** @type {Posture} */ (one.dataset.posture)));
    }
    for (const one of this.attitudes) {
      const attitude = /** @type {Attitude} */ (one.dataset.attitude);
      onPress(one, () => takeAttitude(attitude));
    }
  }

  sitOrStand() {
    const sits = this.newest?.posture === "sit" && this.newest.mode !== "stand";
    this.pose(sits ? "stand" : "sit");
  }

  levelOrFollow() {
    if (!this.newest?.may_lean) return;
    takeAttitude(this.newest.attitude === "level" ? "ground" : "level");
  }

  /** @param {SnapshotFrame} s */
  show(s) {
    this.newest = s;
    const standing = s.mode === "stand" ? s.posture : "";
    mark(this.postures, "posture", POSTURE_OF_MODE[s.mode] ?? standing, "aria-pressed");
    mark(this.attitudes, "attitude", s.attitude, "aria-checked");
    div("attitudes").hidden = !s.may_lean;
  }
}

/** @param {Attitude} attitude */
const takeAttitude = (attitude) => order(say, "PUT", "console/attitude", { attitude });
