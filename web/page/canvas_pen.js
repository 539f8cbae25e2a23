// A canvas made ready to draw on: sharp on dense screens, empty, in our small type.

export const SMALL_TYPE = "500 10px system-ui, sans-serif";
const RATIO_MAX = 2; // pixels a CSS pixel; more costs time that nobody sees

/**
 * @typedef {object} Pen
 * @property {CanvasRenderingContext2D} ink
 * @property {number} width CSS pixels
 * @property {number} height CSS pixels
 */

/**
 * A pen for a canvas; null while it is not shown.
 * @param {HTMLCanvasElement} canvas
 * @returns {Pen | null}
 */
export function penFor(canvas) {
  const { clientWidth: width, clientHeight: height } = canvas;
  const ink = canvas.getContext("2d");
  if (!width || !height || !ink) return null;
  const ratio = Math.min(window.devicePixelRatio || 1, RATIO_MAX);
  const wide = Math.round(width * ratio);
  const high = Math.round(height * ratio);
  if (canvas.width !== wide) canvas.width = wide;
  if (canvas.height !== high) canvas.height = high;
  ink.setTransform(ratio, 0, 0, ratio, 0, 0);
  ink.clearRect(0, 0, width, height);
  ink.globalAlpha = 1;
  ink.font = SMALL_TYPE;
  ink.textBaseline = "middle";
  ink.textAlign = "start";
  return { ink, width, height };
}
