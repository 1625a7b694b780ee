// The bifurcation diagram: columns come from two workers (value rising, value falling); its cursor is the parameter.
import { curves } from "./panels.js";
import { FONT, Frame, reach, rgb, theme } from "./plot.js";
import { tops } from "./motion.js";
import { set, startSi, state, units } from "./state.js";
import { lengths, parameterAxis } from "./units.js";

const AXIS = 34;

export const diagram = {
  columns: 0,
  /** Ordinates of each column and its state at the end, in L and L/s. @type {{rising: (Float64Array | null)[], falling: (Float64Array | null)[]}} */
  found: { rising: [], falling: [] },
  /** The width for which a column stands while finer ones are missing. @type {{rising: number[], falling: number[]}} */
  strides: { rising: [], falling: [] },
  /** @type {(Float64Array | null)[]} */
  exponents: [],
  /** @type {Float64Array} */
  branches: new Float64Array(0),
  id: 0,
  finished: 0,
  sharp: 1,
  /** Parts of the picture to redraw. */
  dirty: true,
  /** @type {[number, number]} */
  band: [-1, 1],
  /** A box that is being drawn, in pixels. @type {number[] | null} */
  drawn: null,
  /** Callback when the picture is complete. @type {() => void} */
  changed: () => {},
  problem: "",
  /** Progress of the search for exact orbits, in words. */
  searched: "",
};

/** @type {Worker[]} */
let workers = [];
/** The worker that looks for exact orbits: one call that may take seconds, so that a newer request ends the worker itself. @type {Worker | null} */
let searching = null;
/** @type {() => Worker} */
let another;

/** Makes the workers. @param {WebAssembly.Module} module @param {string} source */
export function startWorkers(module, source) {
  const address = URL.createObjectURL(new Blob([source], { type: "text/javascript" }));
  another = () => {
    const worker = new Worker(address);
    worker.postMessage({ module });
    worker.onmessage = ({ data }) => receive(data);
    return worker;
  };
  workers = [another(), another(), another()];
}

/** @param {any} data */
function receive(data) {
  if (data.kind === "curves") {
    if (data.id !== diagram.id) return;
    curves.exact = data.found.exact ?? new Float64Array(0);
    curves.scales = data.found.scales ?? new Float64Array(0);
    curves.strong = data.found.strong ?? new Float64Array(0);
    curves.problem = data.found.exact?.length ? "" : data.problem;
  } else if (data.id !== diagram.id) return;
  else if (data.kind === "columns") {
    const which = data.rising ? "rising" : "falling";
    for (const [i, stride, found] of data.batch) {
      diagram.found[which][i] = found;
      for (let j = i; j < Math.min(i + stride, diagram.columns); j++) diagram.strides[which][j] = i;
    }
    diagram.dirty = true;
  } else if (data.kind === "exponents") {
    for (let j = data.place; j < Math.min(data.place + data.stride, diagram.columns); j++) diagram.exponents[j] = data.exponents;
    diagram.dirty = true;
  } else if (data.kind === "progress") {
    diagram.searched = `exact orbits: ${data.done} of ${data.known} branches`;
  } else if (data.kind === "orbits") {
    searching?.terminate();
    searching = null;
    diagram.branches = data.rows;
    diagram.problem = data.problem;
    diagram.searched = "";
    diagram.dirty = true;
  } else if (data.kind === "done") {
    diagram.finished++;
  }
  diagram.changed();
}

/** Computes anew; what is there stays until the first columns come. @param {number} width of the panel */
export function compute(width) {
  const columns = Math.max(120, Math.min(720, Math.round(width - 54)));
  diagram.id++;
  Object.assign(diagram, { columns, finished: 0, problem: "", searched: "", branches: new Float64Array(0), exponents: Array(columns).fill(null) });
  for (const which of /** @type {const} */ (["rising", "falling"])) {
    diagram.found[which] = Array(columns).fill(null);
    diagram.strides[which] = Array(columns).fill(-1);
  }
  const { length } = units(), start = Array.from(startSi(), (x) => x / length);
  const request = {
    id: diagram.id, strong: state.strong, set: state.set, along: state.along, range: [...state.range], ordinate: state.ordinate, columns,
    settle: 160 * diagram.sharp, keep: 60 * diagram.sharp, start,
  };
  workers[0].postMessage({ ...request, kind: "diagram", rising: true });
  workers[1].postMessage({ ...request, kind: "diagram", rising: false });
  workers[2].postMessage({ ...request, kind: "curves" });
  searching?.terminate();
  searching = null;
  if (state.orbits && /^(x[123]|w)$/.test(state.ordinate)) {
    diagram.searched = "exact orbits: settling";
    searching = another();
    searching.postMessage({ ...request, kind: "orbits" });
  }
}

/** @param {number} width @param {number} height */
export function frameOf(width, height) {
  return new Frame(state.range, diagram.band, { left: 44, right: width - 10, top: 20, bottom: height - 22 - AXIS });
}

const picture = document.createElement("canvas");
/** Time of the last redraw, and the interval between redraws while columns arrive, ms. */
let shaded = 0;
const BETWEEN = 60;

/** Whether the two directions end on different attractors at a column. Two that wander over many values are taken for one. @param {number} i */
function apart(i) {
  const [a, b] = [diagram.found.rising[diagram.strides.rising[i]], diagram.found.falling[diagram.strides.falling[i]]];
  if (!a || !b) return false;
  const unit = (diagram.band[1] - diagram.band[0]) / 150, places = (/** @type {Float64Array} */ f) => new Set(Array.from(f.subarray(6), (x) => Math.round(x / unit)));
  const [p, q] = [places(a), places(b)];
  if (p.size > 14 && q.size > 14) return false;
  const lacks = (/** @type {Set<number>} */ one, /** @type {Set<number>} */ other) => [...one].some((x) => ![-2, -1, 0, 1, 2].some((d) => other.has(x + d)));
  return lacks(q, p) || lacks(p, q);
}

/** The columns as shades: how much of the kept periods falls into a pixel. @param {Frame} frame @param {number} ratio */
function shade(frame, ratio) {
  const w = Math.max(1, Math.round((frame.box.right - frame.box.left) * ratio)), h = Math.max(1, Math.round((frame.box.bottom - frame.box.top) * ratio));
  picture.width = w; picture.height = h;
  const g = /** @type {CanvasRenderingContext2D} */ (picture.getContext("2d")), image = g.createImageData(w, h), data = image.data;
  const paint = (/** @type {"rising" | "falling"} */ which, /** @type {[number, number, number]} */ colour, /** @type {number} */ strength) => {
    const counts = new Uint16Array(h), n = diagram.columns, different = which === "falling" ? Array.from({ length: n }, (_, i) => apart(i)) : [];
    for (let px = 0; px < w; px++) {
      const place = Math.min(n - 1, Math.floor(px * n / w)), column = diagram.strides[which][place];
      if (which === "falling" && !different[place]) continue;
      const found = column >= 0 ? diagram.found[which][column] : null;
      if (!found || found.length <= 6) continue;
      counts.fill(0);
      const total = found.length - 6;
      for (let k = 6; k < found.length; k++) {
        const py = Math.round((diagram.band[1] - found[k]) / (diagram.band[1] - diagram.band[0]) * (h - 1));
        if (py >= 0 && py < h) { counts[py]++; if (py + 1 < h) counts[py + 1]++; }
      }
      for (let py = 0; py < h; py++) {
        if (!counts[py]) continue;
        const at = 4 * (py * w + px), alpha = Math.round(255 * strength * Math.min(1, 0.34 + 8 * counts[py] / total));
        if (alpha <= data[at + 3] && which === "rising") continue;
        [data[at], data[at + 1], data[at + 2]] = colour;
        data[at + 3] = Math.max(data[at + 3], alpha);
      }
    }
  };
  paint("falling", rgb(theme.falling), 0.95);
  paint("rising", rgb(theme.ink), 1);
  g.putImageData(image, 0, 0);
}

/** The range of everything shown. */
function findBand() {
  if (state.band) { diagram.band = state.band; return; }
  const all = [];
  for (const which of /** @type {const} */ (["rising", "falling"])) for (const found of diagram.found[which]) if (found) for (let k = 6; k < found.length; k++) all.push(found[k]);
  if (all.length) diagram.band = reach(all, 0.05);
}

/** @param {any} g @param {number} width @param {number} height @param {number} ratio @param {boolean} [vector] */
export function drawDiagram(g, width, height, ratio, vector = false) {
  const symbol = { x1: "x₁", x2: "x₂", x3: "x₃", w: "w", strobe: "x₂" }[state.ordinate];
  // New columns arrive many times per frame: the whole picture is redrawn about fifteen times a second.
  const anew = vector || (diagram.dirty && (performance.now() - shaded > BETWEEN || diagram.finished === 2 || picture.width !== Math.round((width - 54) * ratio)));
  if (anew) findBand();
  const frame = frameOf(width, height), { box } = frame;
  // Each column's speeds are in units of its own L ω₁; over the gap, lengths are in units of its own L.
  const ordinate = !symbol ? "±v/Lω₁" : state.along === "stop.gap" ? `${symbol}/L` : lengths(symbol), parameter = parameterAxis(state.along);
  frame.axes(g, { xTicks: false, x: { ...parameter, label: "" }, y: ordinate });
  if (anew) {
    shade(frame, ratio);
    shaded = performance.now();
    diagram.dirty = false;
  }
  g.drawImage(picture, box.left, box.top, box.right - box.left, box.bottom - box.top);
  frame.inside(g, () => drawBranches(g, frame));
  drawExponents(g, frame, height, parameter);
  const here = set.value(state.along);
  if (here >= state.range[0] && here <= state.range[1]) {
    g.strokeStyle = theme.here; g.lineWidth = 1.5;
    g.beginPath(); g.moveTo(frame.px(here), box.top - 4); g.lineTo(frame.px(here), height - 20); g.stroke();
    g.fillStyle = theme.here;
    g.beginPath(); g.moveTo(frame.px(here), box.top + 3); g.lineTo(frame.px(here) - 5, box.top - 6); g.lineTo(frame.px(here) + 5, box.top - 6); g.closePath(); g.fill();
  }
  if (here >= state.range[0] && here <= state.range[1]) frame.inside(g, () => {
    g.fillStyle = theme.card; g.strokeStyle = theme.here; g.lineWidth = 1.5;
    for (const top of tops(state.ordinate)) { g.beginPath(); g.arc(frame.px(here), frame.py(top), 3.4, 0, 2 * Math.PI); g.fill(); g.stroke(); }
  });
  if (diagram.drawn) {
    const [x0, y0, x1, y1] = diagram.drawn;
    g.strokeStyle = theme.here; g.lineWidth = 1.5; g.setLineDash([4, 3]);
    g.beginPath(); g.rect(Math.min(x0, x1), Math.min(y0, y1), Math.abs(x1 - x0), Math.abs(y1 - y0)); g.stroke();
    g.setLineDash([]);
  }
  const words = diagram.problem || diagram.searched || (diagram.found.rising.some((f) => f && f.length > 6) || diagram.id === 0 ? "" : "computing …");
  if (words) { g.fillStyle = theme.soft; g.font = `12px ${FONT}`; g.textAlign = "left"; g.textBaseline = "top"; g.fillText(words, box.left + 8, box.top + 6); }
  return [frame];
}

/** @param {any} g @param {Frame} frame */
function drawBranches(g, frame) {
  const rows = diagram.branches;
  const body = { x1: "box", x2: "block", x3: "drawn-secondary", w: "relative" }[state.ordinate] ?? "ink";
  g.lineWidth = 1.2; g.strokeStyle = theme[body]; g.globalAlpha = 0.85;
  for (const stable of [1, 0]) {
    g.setLineDash(stable ? [] : [4, 3]);
    g.beginPath();
    let pen = false;
    for (let i = 0; i + 5 < rows.length; i += 3) {
      if (rows[i + 2] !== stable || !(rows[i] === rows[i]) || !(rows[i + 3] === rows[i + 3])) { pen = false; continue; }
      if (!pen) g.moveTo(frame.px(rows[i]), frame.py(rows[i + 1]));
      g.lineTo(frame.px(rows[i + 3]), frame.py(rows[i + 4]));
      pen = true;
    }
    g.stroke();
  }
  g.setLineDash([]);
  g.globalAlpha = 1;
}

/** The strip of Lyapunov exponents under the diagram. @param {any} g @param {Frame} above @param {number} height @param {import("./units.js").Axis} parameter */
function drawExponents(g, above, height, parameter) {
  const known = diagram.exponents.filter((e) => e !== null), most = Math.min(0.25, Math.max(0.02, ...known.map((e) => e[0])));
  const strip = new Frame(state.range, [-most, most], { left: above.box.left, right: above.box.right, top: height - 18 - AXIS, bottom: height - 22 });
  strip.axes(g, { x: parameter, yTicks: 0 });
  g.fillStyle = theme.soft; g.font = `10px ${FONT}`; g.textAlign = "right"; g.textBaseline = "middle";
  if (known.length) g.fillText(most.toFixed(2), strip.box.left - 6, strip.box.top + 3);
  g.fillStyle = theme.ink; g.font = `11px ${FONT}`;
  g.fillText("λ₁, λ₂", strip.box.left - 6, strip.py(0) + 1);
  const wide = (strip.box.right - strip.box.left) / diagram.columns;
  strip.inside(g, () => {
    for (const [index, colour] of /** @type {const} */ ([[1, theme.faint], [0, theme.ink]])) {
      g.fillStyle = colour;
      diagram.exponents.forEach((e, i) => {
        if (!e || !Number.isFinite(e[index])) return;
        const zero = strip.py(0), y = strip.py(Math.max(-most, e[index]));
        g.fillRect(strip.box.left + i * wide, Math.min(zero, y), wide + 0.3, Math.max(1, Math.abs(y - zero)));
      });
    }
  });
}

/** The column nearest to a value whose ordinates come nearest to `ordinate`: its value and its state at the end in L and L/s. @param {number} value @param {number} ordinate */
export function attractorAt(value, ordinate) {
  const i = Math.max(0, Math.min(diagram.columns - 1, Math.floor((value - state.range[0]) / (state.range[1] - state.range[0]) * diagram.columns)));
  let best = null, nearest = Infinity;
  for (const which of /** @type {const} */ (["rising", "falling"])) {
    const column = diagram.strides[which][i], found = column >= 0 ? diagram.found[which][column] : null;
    if (!found || !Number.isFinite(found[0])) continue;
    let distance = 1e9;
    for (let k = 6; k < found.length; k++) distance = Math.min(distance, Math.abs(found[k] - ordinate));
    if (distance < nearest) [nearest, best] = [distance, { value: state.range[0] + (state.range[1] - state.range[0]) * (column + 0.5) / diagram.columns, end: Array.from(found.subarray(0, 6)) }];
  }
  return best;
}
