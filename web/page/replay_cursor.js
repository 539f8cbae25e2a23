// A page of one walk: a line over each curve where the player is, and the value there.

const curves = [...document.querySelectorAll("#walk svg")];
const drawn = curves.map((curve) => ({
  line: curve.querySelector("line"),
  shown: curve.previousElementSibling?.querySelector("output"),
  times: numbers(curve, "times"),
  values: numbers(curve, "values"),
}));

/** @param {Element} curve @param {string} name */
function numbers(curve, name) {
  return (curve.getAttribute(`data-${name}`) ?? "").split(" ").map(Number);
}

/** Where the player is, s, and how long the recording; nothing before it has been read. */
function playback() {
  const slider = document.querySelector("[role=slider][aria-valuemax]");
  const now = Number(slider?.getAttribute("aria-valuenow"));
  const end = Number(slider?.getAttribute("aria-valuemax"));
  return end > 0 ? { now, end } : null;
}

/**
 * The value of a curve at a time: that of its last point until then.
 * @param {number[]} times @param {number[]} values @param {number} now
 */
function valueAt(times, values, now) {
  const next = times.findIndex((time) => time > now);
  return values.at(next < 0 ? -1 : Math.max(0, next - 1)) ?? NaN;
}

/** @param {{ now: number, end: number }} at */
function mark(at) {
  for (const { line, shown, times, values } of drawn) {
    if (!line || !shown) continue;
    const width = line.ownerSVGElement?.viewBox.baseVal.width ?? 0;
    const x = String((at.now / at.end) * width);
    line.setAttribute("x1", x);
    line.setAttribute("x2", x);
    const value = valueAt(times, values, at.now);
    shown.textContent = Number.isNaN(value) ? "none" : value.toFixed(3);
  }
}

function follow() {
  const at = playback();
  if (at) mark(at);
}

// The player moves its slider once a picture; the lines move with it, not a picture later.
new MutationObserver(follow).observe(document.body, {
  subtree: true,
  attributeFilter: ["aria-valuenow", "aria-valuemax"],
});
follow();
