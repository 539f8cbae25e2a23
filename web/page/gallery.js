// The scenarios as picture cards, the best ones first: watch one, or drive it.

import { button, element, make } from "./dom.js";
import { onPress } from "./press.js";

const BEST = ["river", "holes", "fig19", "stairs-up", "k-curve", "dem"];

/**
 * @typedef {object} Scenario
 * @property {string} name
 * @property {string} title
 */

export class Gallery {
  /**
   * @param {() => void} letGo called before it covers the stick
   * @param {(name: string, plays: boolean) => void} choose
   */
  constructor(letGo, choose) {
    this.letGo = letGo;
    this.choose = choose;
    this.dialog = element("gallery", HTMLDialogElement);
    this.cards = element("cards", HTMLUListElement);
    onPress(button("gallery-button"), () => this.open());
    this.dialog.addEventListener("click", ({ target }) => {
      if (target === this.dialog) this.dialog.close();
    });
  }

  open() {
    this.letGo();
    this.dialog.showModal();
  }

  /** @param {Scenario[]} scenarios */
  fill(scenarios) {
    const best = BEST.flatMap((name) => scenarios.filter((one) => one.name === name));
    const others = scenarios.filter((one) => !best.includes(one));
    this.cards.replaceChildren(...[...best, ...others].map((one) => this.#card(one)));
  }

  /** @param {Scenario} scenario */
  #card({ name, title }) {
    const picture = new Image(320, 180);
    picture.loading = "lazy";
    picture.alt = "";
    picture.src = `cards/${name}.jpg`;
    const acts = make("div", "", "acts");
    acts.append(this.#act("Play", name, true), this.#act("Drive it yourself", name, false));
    const card = make("li", "", "card");
    card.append(picture, make("h2", title), make("small", name, "muted"), acts);
    return card;
  }

  /**
   * @param {string} text
   * @param {string} name
   * @param {boolean} plays
   */
  #act(text, name, plays) {
    const act = document.createElement("button");
    act.textContent = text;
    act.className = "small";
    act.setAttribute("aria-label", `${text}: ${name}`);
    onPress(act, () => {
      this.dialog.close();
      this.choose(name, plays);
    });
    return act;
  }
}
