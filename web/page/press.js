// Controls that act the moment a finger comes down, whatever other fingers do: a second finger on
// the screen gives pointer events but never a click.

/**
 * Act on the press itself; on a click only where no press came before it (keys, screen readers).
 * @param {HTMLButtonElement} button
 * @param {() => void} act
 */
export function onPress(button, act) {
  let pressed = false;
  button.addEventListener("pointerdown", (event) => {
    if (button.disabled || event.button !== 0) return;
    pressed = true;
    act();
  });
  button.addEventListener("click", (event) => {
    // detail 0: nobody pressed, so it is not the end of a press that has acted already
    if (event.detail === 0 || !pressed) act();
    pressed = false;
  });
}

const CONTROLS = "select, summary, label, a";

/** What is no button is clicked by a second finger too, when that is lifted. */
export function letEveryFingerClick() {
  /** @type {Map<number, HTMLElement>} */
  const under = new Map();
  document.addEventListener("pointerdown", (event) => {
    if (event.isPrimary || !(event.target instanceof Element)) return;
    const control = event.target.closest(CONTROLS);
    if (control instanceof HTMLElement) under.set(event.pointerId, control);
  });
  document.addEventListener("pointerup", (event) => {
    const control = under.get(event.pointerId);
    if (control instanceof HTMLSelectElement) control.showPicker();
    else control?.click();
  });
  for (const end of /** @type {const} */ (["pointerup", "pointercancel"])) {
    document.addEventListener(end, (event) => under.delete(event.pointerId));
  }
}
