// Elements of the page: found with the kind they must have, written only when something differs.

/** @type {Map<string, string>} */
const written = new Map();

/**
 * The element with an id; throws where the page has none of that kind.
 * @template {Element} E
 * @param {string} id
 * @param {new () => E} kind
 * @returns {E}
 */
export function element(id, kind) {
  const found = document.getElementById(id);
  if (!(found instanceof kind)) throw new Error(`the page has no ${kind.name} #${id}`);
  return found;
}

/** @param {string} id */
export const div = (id) => element(id, HTMLElement);

/** @param {string} id */
export const button = (id) => element(id, HTMLButtonElement);

/** @param {string} id */
export const input = (id) => element(id, HTMLInputElement);

/**
 * Every button in a place.
 * @param {string} selector
 * @returns {HTMLButtonElement[]}
 */
export const buttons = (selector) => [...document.querySelectorAll(selector)].filter(isButton);

/**
 * @param {Element} found
 * @returns {found is HTMLButtonElement}
 */
const isButton = (found) => found instanceof HTMLButtonElement;

/**
 * A new element with a text and a class.
 * @param {string} tag
 * @param {string} [text]
 * @param {string} [className]
 */
export function make(tag, text = "", className = "") {
  const made = document.createElement(tag);
  made.textContent = text;
  if (className) made.className = className;
  return made;
}

/**
 * Write a text where it is not there already.
 * @param {string} id
 * @param {string} text
 */
export function write(id, text) {
  if (written.get(id) === text) return;
  written.set(id, text);
  div(id).textContent = text;
}

/**
 * Set a style property where it is not so already.
 * @param {string} id
 * @param {string} property
 * @param {string} value
 */
export function restyle(id, property, value) {
  const key = `${id}.${property}`;
  if (written.get(key) === value) return;
  written.set(key, value);
  div(id).style.setProperty(property, value);
}

/**
 * Check the one button of a group whose data attribute has a value.
 * @param {HTMLButtonElement[]} group
 * @param {string} key of the data attribute
 * @param {string} value
 * @param {"aria-checked" | "aria-pressed"} state
 */
export function mark(group, key, value, state) {
  for (const one of group) one.setAttribute(state, String(one.dataset[key] === value));
}

/**
 * A colour or size of style.css.
 * @param {string} name with its two dashes
 */
export const css = (name) =>
  getComputedStyle(document.documentElement).getPropertyValue(name).trim();
