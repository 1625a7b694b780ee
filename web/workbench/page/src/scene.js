// The sketch in motion. The library draws it with its bodies moved; this module shows it, with
// light at impacts.
import { FONT, rgb, theme } from "../../../explorer/page/src/plot.js";
import { columnOf, extent, isWhole, run } from "./run.js";

/** Largest displacement of a body from its middle, in units of the drawing. */
const REACH = 85;
/** Smallest size of the picture with readable letters. */
const LEAST = 0.2;
/** Room around the sketch for bodies that move beyond its margins, in units of the drawing. */
const EDGE = 50;

/** Middle of each body's motion, its mean rate if it drifts, and the scale of its drawn motion. */
const view = { bodies: /** @type {{place: number, middle: number, drift: number, scale: number}[]} */ ([]), stops: /** @type {{place: number, gap: number, scale: number}[]} */ ([]), scales: [0, 0], /** Number of examined rows. */ count: 0 };
/** Growth of the run after which it is examined again. */
const FURTHER = 1.1;
export const scene = {
  /** @type {Float32Array} */ marks: new Float32Array(0),
  /** @type {string[]} */ words: [],
  /** Light at each element, and what is written over it. @type {Map<number, {light: number, words: string}>} */
  glow: new Map(),
  /** Contacts that are closed, pressed or stick now, by the tag of the element. @type {Map<number, string>} */
  held: new Map(),
};

/** The tag of a drawn thing. @param {string} name */
export const tagOf = (name) => run.machine.sketch.names.lastIndexOf(name);

/** Whether the run has grown much since it was examined, or is whole. */
export const isFurther = () => isWhole() || run.count > FURTHER * view.count;

/** Examines the whole run, so that it fits. */
export function look() {
  const { machine, width, rows, count } = run;
  view.count = count;
  const first = rows[0], span = rows[(count - 1) * width] - first || 1;
  const most = [0, 0], found = machine.bodies.map((body) => {
    const place = columnOf(`${body.name}.s`);
    if (place < 0 || count < 2) return { place: -1, middle: 0, drift: 0, scale: 0 };
    let [low, high] = extent(place), drift = 0;
    // A body that drifts far more than it oscillates is shown without its mean rate.
    const rate = (rows[(count - 1) * width + place] - rows[place]) / span;
    let least = Infinity, largest = -Infinity;
    for (let i = 0; i < count; i++) { const x = rows[i * width + place] - rate * (rows[i * width] - first); if (x < least) least = x; if (x > largest) largest = x; }
    if (largest - least < 0.35 * (high - low)) { drift = rate; [low, high] = [least, largest]; }
    const of = body.rotates ? 1 : 0, size = (high - low) / 2;
    most[of] = Math.max(most[of], size);
    return { place, middle: (low + high) / 2, drift, scale: 0 };
  });
  view.scales = most.map((size) => (size > 0 ? REACH / size : 0));
  found.forEach((body, i) => { body.scale = view.scales[machine.bodies[i].rotates ? 1 : 0]; });
  view.bodies = found;
  view.stops = machine.elements.map(({ name, gap, rotates }) => ({ place: gap === null ? -1 : columnOf(`${name}.e`), gap: gap ?? 0, scale: view.scales[rotates ? 1 : 0] }));
}

/** Shifts of the bodies and openings of the stops at an instant, in units of the drawing. @param {Float64Array} values */
export function places(values) {
  const shifts = Float64Array.from(view.bodies, ({ place, middle, drift, scale }) => (place < 0 ? 0 : scale * (values[place] - drift * (values[0] - run.rows[0]) - middle)));
  const openings = Float64Array.from(view.stops, ({ place, gap, scale }) => (place < 0 || !scale ? NaN : scale * (gap - values[place])));
  return { shifts, openings };
}

/** Contacts that are held at an instant. @param {Float64Array} values */
export function hold(values) {
  const { machine } = run, from = machine.head + machine.columns.length;
  scene.held.clear();
  machine.elements.forEach(({ name, section }, i) => {
    if (values[from + i]) scene.held.set(tagOf(name), section === "friction" || section === "freewheel" ? "stick" : "closed");
  });
}

/** Whether there is light that fades; goes on fading. @param {number} seconds @param {boolean} still */
export function fade(seconds, still) {
  for (const [tag, own] of scene.glow) {
    own.light *= still ? 0 : Math.exp(-seconds / 0.35);
    if (own.light < 0.02) scene.glow.delete(tag);
  }
  return scene.glow.size > 0;
}

/** The colour on the page of a colour of the drawing. @param {number} colour */
function colourOf(colour) {
  if (colour === 0) return theme.ink;
  if (colour === 0xffffff) return theme.card;
  const [r, g, b] = [colour >> 16, (colour >> 8) & 255, colour & 255];
  // Grey strokes; otherwise the fill of bodies.
  return r === g && g === b ? theme.soft : theme.body;
}

/** Size of the picture in a box. @param {number} width @param {number} height */
export function sizeIn(width, height) {
  const { sketch } = run.machine, w = sketch.width + 2 * EDGE, h = sketch.height + 2 * EDGE;
  const scale = Math.max(LEAST, Math.min(width / w, height / h, 0.5));
  return { scale, wide: Math.max(width, Math.ceil(w * scale)), high: Math.max(height, Math.ceil(h * scale)) };
}

/** Draws the sketch. @param {any} g @param {number} width @param {number} height @param {number} scale */
export function draw(g, width, height, scale) {
  const { marks, words, glow, held } = scene, { sketch } = run.machine;
  const left = Math.max(0, (width - sketch.width * scale) / 2), top = Math.max(0, (height - sketch.height * scale) / 2);
  const X = (/** @type {number} */ x) => left + x * scale, Y = (/** @type {number} */ y) => top + y * scale;
  g.lineCap = "round"; g.lineJoin = "round";
  let tag = -1, over = "", /** @type {Map<number, {x: number, y: number, n: number}>} */ middles = new Map();
  const path = (/** @type {number} */ at, /** @type {number} */ n) => {
    g.beginPath();
    for (let k = 0; k < n; k++) { const x = X(marks[at + 2 * k]), y = Y(marks[at + 2 * k + 1]); if (k) g.lineTo(x, y); else g.moveTo(x, y); note(x, y); }
    return at + 2 * n;
  };
  const note = (/** @type {number} */ x, /** @type {number} */ y) => { if (tag < 0) return; const m = middles.get(tag) ?? { x: 0, y: Infinity, n: 0 }; m.x += x; m.n++; m.y = Math.min(m.y, y); middles.set(tag, m); };
  for (let i = 0; i < marks.length;) {
    const kind = marks[i++];
    if (kind === 0) {
      tag = marks[i++];
      const light = glow.get(tag)?.light ?? 0, state = held.get(tag);
      over = state === "stick" ? theme.secondary : state === "closed" ? theme.spark : "";
      if (light > 0) { const [a, b] = [rgb(theme.ink), rgb(theme.spark)]; over = `rgb(${a.map((c, k) => Math.round(c + (b[k] - c) * Math.min(1, 2 * light))).join(" ")})`; }
      continue;
    }
    const colour = over || colourOf(marks[i]), size = marks[i + 1];
    if (kind === 1) {
      const n = marks[i + 2], light = glow.get(tag)?.light ?? 0;
      i = path(i + 3, n);
      g.strokeStyle = colour; g.lineWidth = Math.max(1, size * scale * (1 + 0.8 * light));
      g.stroke();
    } else if (kind === 2) {
      g.fillStyle = over && marks[i] !== 0 ? colourOf(marks[i]) : colour;
      i = path(i + 3, marks[i + 2]);
      g.fill();
    } else if (kind === 3) {
      const n = marks[i + 2]; i += 3;
      g.fillStyle = colour;
      for (let k = 0; k < n; k++, i += 2) { g.beginPath(); g.arc(X(marks[i]), Y(marks[i + 1]), size * scale, 0, 2 * Math.PI); g.fill(); }
    } else {
      g.fillStyle = colour; g.font = `${(size * scale).toFixed(1)}px ${FONT}`; g.textBaseline = "alphabetic"; g.textAlign = ["left", "center", "right"][marks[i + 2]];
      g.fillText(words[marks[i + 3]] ?? "", X(marks[i + 4]), Y(marks[i + 5]));
      i += 6;
    }
  }
  // Impulses above the struck elements, while the light lasts.
  g.textAlign = "center"; g.textBaseline = "bottom"; g.font = `600 11px ${FONT}`;
  for (const [own, { light, words: told }] of glow) {
    const at = middles.get(own);
    if (!at || light < 0.08 || !told) continue;
    g.globalAlpha = Math.min(1, 1.5 * light); g.fillStyle = theme["spark-text"];
    g.fillText(told, at.x / at.n, at.y - 46 * scale);
    g.globalAlpha = 1;
  }
}
