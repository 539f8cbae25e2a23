// The drive stick: pointer, touch and held keys become one direction (x forward, y left, length 0 to 1) and one turn (-1 to 1).

const DEAD = 0.10;  // share of the throw that still counts as rest
const SLOW = 1 / 3; // with Shift

const DIRECTIONS = {
  KeyW: [1, 0], ArrowUp: [1, 0], KeyS: [-1, 0], ArrowDown: [-1, 0],
  KeyA: [0, 1], ArrowLeft: [0, 1], KeyD: [0, -1], ArrowRight: [0, -1],
};
const TURNS = { KeyQ: 1, KeyE: -1 };

export const isDrivingKey = (code) => code in DIRECTIONS || code in TURNS;

export class Stick {
  constructor(pad, knob, slider, changed) {
    this.pad = pad;
    this.knob = knob;
    this.slider = slider;
    this.changed = changed;
    this.pointer = null;
    this.drag = [0, 0];
    this.keys = new Set();
    this.slow = false;
    this.slide = 0;
    this.wedge = pad.querySelector("#stick-wedge");
    this.line = pad.querySelector("#stick-line");
    this.#listen();
  }

  // what is asked for now
  get value() {
    let [x, y] = this.pointer === null ? [0, 0] : this.drag;
    let turn = this.slide;
    if (this.pointer === null && this.keys.size) {
      for (const code of this.keys) {
        const [dx, dy] = DIRECTIONS[code] ?? [0, 0];
        x += dx;
        y += dy;
      }
      const length = Math.hypot(x, y);
      const size = this.slow ? SLOW : 1;
      [x, y] = length ? [(x / length) * size, (y / length) * size] : [0, 0];
    }
    for (const code of this.keys) turn += (TURNS[code] ?? 0) * (this.slow ? SLOW : 1);
    return { x, y, turn: Math.max(-1, Math.min(1, turn)) };
  }

  press(code, slow) {
    this.slow = slow;
    if (this.keys.has(code)) return;
    this.keys.add(code);
    this.#show();
  }

  lift(code, slow) {
    this.slow = slow;
    if (this.keys.delete(code)) this.#show();
  }

  liftKeys() {
    if (!this.keys.size) return;
    this.keys.clear();
    this.#show();
  }

  letGo() {
    this.pointer = null;
    this.drag = [0, 0];
    this.keys.clear();
    this.slide = 0;
    this.slider.value = 0;
    this.#show();
  }

  #listen() {
    const pad = this.pad;
    pad.addEventListener("pointerdown", (event) => {
      if (this.pointer !== null || (event.pointerType === "mouse" && event.button !== 0)) return;
      event.preventDefault();
      pad.focus({ preventScroll: true });
      this.pointer = event.pointerId;
      pad.setPointerCapture(event.pointerId);
      this.#move(event);
    });
    pad.addEventListener("pointermove", (event) => event.pointerId === this.pointer && this.#move(event));
    for (const end of ["pointerup", "pointercancel", "lostpointercapture"]) {
      pad.addEventListener(end, (event) => event.pointerId === this.pointer && this.#release());
    }
    pad.addEventListener("contextmenu", (event) => event.preventDefault());
    this.slider.addEventListener("input", () => { this.slide = -Number(this.slider.value); this.#show(); });
    for (const end of ["pointerup", "pointercancel", "lostpointercapture", "blur", "keyup"]) {
      this.slider.addEventListener(end, () => { this.slider.value = 0; this.slide = 0; this.#show(); });
    }
  }

  #move(event) {
    const box = this.pad.getBoundingClientRect();
    const reach = box.width / 2 - this.knob.offsetWidth / 2 + 8;
    let right = (event.clientX - box.left - box.width / 2) / reach;
    let down = (event.clientY - box.top - box.height / 2) / reach;
    const length = Math.hypot(right, down);
    if (length > 1) { right /= length; down /= length; }
    const share = Math.min(length, 1);
    const size = share < DEAD ? 0 : (share - DEAD) / (1 - DEAD);
    this.drag = size && share ? [(-down / share) * size || 0, (-right / share) * size || 0] : [0, 0];
    if (length > 1) this.drag = [-down, -right];
    this.#show();
  }

  #release() {
    this.pointer = null;
    this.drag = [0, 0];
    this.#show();
  }

  #show() {
    const { x, y } = this.value;
    const active = x !== 0 || y !== 0;
    const throwLength = this.pad.clientWidth / 2 - this.knob.offsetWidth / 2 + 8;
    this.knob.style.transform = `translate(${-y * throwLength}px, ${-x * throwLength}px)`;
    this.pad.classList.toggle("held", active || this.pointer !== null);
    this.line.setAttribute("x2", String(-y * 70));
    this.line.setAttribute("y2", String(-x * 70));
    this.wedge.setAttribute("d", active ? arc(Math.atan2(y, x)) : "");
    this.changed(this.value);
  }
}

// from straight ahead to the crab angle, just inside the rim
function arc(angle) {
  const [x, y] = [-Math.sin(angle) * 88, -Math.cos(angle) * 88];
  return `M0 -88A88 88 0 0 ${angle > 0 ? 0 : 1} ${x.toFixed(1)} ${y.toFixed(1)}`;
}
