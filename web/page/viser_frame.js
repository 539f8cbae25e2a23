// The canvas in its frame: our own menu works viser's (hidden) switches, which are this viewer's alone.

const TRIES = 40;
const STYLE = ".mantine-Notifications-root, .mantine-Paper-root { display: none !important; } canvas { outline: none; } .paints canvas { cursor: crosshair !important; }";

export class View {
  constructor(frame) {
    this.frame = frame;
    this.wanted = new Map();
    frame.addEventListener("load", () => this.#dress());
    if (this.#document?.readyState === "complete") this.#dress();
    setInterval(() => this.#apply(), 700); // a reconnected viewer gets new switches
  }

  get #document() {
    try { return this.frame.contentDocument; } catch { return null; }
  }

  set(label, on) {
    this.wanted.set(label, on);
    this.#apply();
  }

  paints(on) {
    this.painting = on;
    this.#document?.documentElement.classList.toggle("paints", on);
  }

  home() {
    const button = [...(this.#document?.querySelectorAll("button") ?? [])].find((found) => found.textContent.trim() === "Home");
    button?.click();
  }

  #dress(tries = TRIES) {
    const page = this.#document;
    if (!page?.head) return void (tries && setTimeout(() => this.#dress(tries - 1), 250));
    if (!page.getElementById("console-style")) {
      const style = page.createElement("style");
      style.id = "console-style";
      style.textContent = STYLE;
      page.head.append(style);
      this.paints(this.painting ?? false);
    }
  }

  #apply() {
    if (!this.wanted.size) return;
    for (const box of this.#document?.querySelectorAll("input[type=checkbox]") ?? []) {
      const label = labelOf(box);
      if (this.wanted.has(label) && box.checked !== this.wanted.get(label)) box.click();
    }
  }
}

function labelOf(box) {
  for (let element = box.parentElement, up = 0; element && up < 5; element = element.parentElement, up++) {
    const text = element.textContent.trim();
    if (text) return text;
  }
  return "";
}
