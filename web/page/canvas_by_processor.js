// Canvases that the processor paints. One that the graphics process paints keeps the page's thread
// waiting until that process has time: where it draws the scene by software, up to 800 ms, and what
// is held meanwhile is let go. Imported before whatever makes a canvas, the chart library too.

const get = HTMLCanvasElement.prototype.getContext;

/**
 * @this {HTMLCanvasElement}
 * @param {string} kind
 * @param {object} [options]
 */
function getContext(kind, options) {
  const flat = kind === "2d";
  return get.call(this, kind, flat ? { willReadFrequently: true, ...options } : options);
}

HTMLCanvasElement.prototype.getContext = /** @type {typeof get} */ (getContext);
