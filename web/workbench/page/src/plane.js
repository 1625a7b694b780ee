// Classes of motions over a plane of two parameters, row by row in two workers.
import { FONT, Frame, theme } from "../../../explorer/page/src/plot.js";
import { Helper } from "./helper.js";
import { halt, study } from "./study.js";

/** @typedef {{name: string, range: [number, number], factor: number, unit: string, count: number}} Axis the ends in SI */
/** @typedef {[string | null, number | null, boolean]} Cell class, impacts and first touches a return, whether it rests */

/** Number of discarded returns of each motion. */
const DISCARDED = 400;

export const plane = {
  x: /** @type {Axis | null} */ (null), y: /** @type {Axis | null} */ (null),
  /** By row from the lowest what was found. */ rows: /** @type {(Cell[] | undefined)[]} */ ([]),
  /** The cell that the keyboard is at. */ at: /** @type {[number, number] | null} */ (null),
  frame: /** @type {Frame | null} */ (null),
};

/** Kinds of motion, each with its colour; the last takes all others. The colours are those of the pictures of `vibro`, with even steps of lightness. @type {[string, string, (cell: Cell) => boolean][]} */
const KINDS = [
  ["no returns", "rgb(255 255 255)", ([own]) => own === null],
  ["without impacts", "rgb(239 239 239)", ([, contacts, rests]) => contacts === 0 && !rests],
  ["1T", "rgb(141 185 223)", ([own]) => own === "1T"],
  ["2T", "rgb(25 105 63)", ([own]) => own === "2T"],
  ["3T", "rgb(88 25 116)", ([own]) => own === "3T"],
  ["4T", "rgb(170 76 166)", ([own]) => own === "4T"],
  ["longer periods", "rgb(222 135 0)", ([own]) => /^\d+T$/.test(own ?? "")],
  ["periodic, settling", "rgb(133 133 133)", ([own]) => own === "periodic, settling"],
  ["quasi-periodic", "rgb(226 211 26)", ([own]) => own === "quasi-periodic"],
  ["chaotic", "rgb(0 0 0)", ([own]) => own === "chaotic"],
  ["undecided", "rgb(149 20 0)", () => true],
];
const kindOf = (/** @type {Cell} */ cell) => KINDS.findIndex(([, , is]) => is(cell));

/** @param {Axis} axis @param {number} i */
export const valueOn = ({ range: [from, to], count }, i) => from + (to - from) * i / (count - 1);

/** @param {{text: string, names: string[], texts: string[]}} machine @param {Axis} x @param {Axis} y */
export async function classify(machine, x, y) {
  halt();
  Object.assign(plane, { x, y, rows: Array(y.count), at: null });
  const begun = performance.now(), helpers = [new Helper(), new Helper()], all = x.count * y.count;
  Object.assign(study, { helpers, running: true, shown: "plane" });
  study.told(0, "Started.");
  let next = 0, done = 0;
  const work = async (/** @type {Helper} */ helper) => {
    await helper.ask("plane", { ...machine, across: x.name, upwards: y.name, ranges: [...x.range, ...y.range], counts: [x.count, y.count], discard: DISCARDED });
    while (next < y.count) {
      const row = next++;
      plane.rows[row] = await helper.ask("row", { row });
      done += x.count;
      const passed = (performance.now() - begun) / 1000;
      study.told(done / all, `${done} of ${all} motions, about ${Math.ceil(passed * (all - done) / done)} s left.`);
      study.changed();
    }
  };
  try {
    await Promise.all(helpers.map(work));
    if (study.helpers === helpers) { study.running = false; study.told(1, `${all} motions in ${((performance.now() - begun) / 1000).toFixed(1)} s. Click one to play its machine.`); }
  } catch (error) {
    if (study.helpers === helpers) { study.running = false; study.told(NaN, String(/** @type {Error} */ (error).message ?? error)); }
  }
  if (study.helpers === helpers) halt();
  study.changed();
}

/** Classes found so far, each with its colour and its number of motions. */
export function legend() {
  const counts = KINDS.map(() => 0);
  for (const row of plane.rows) for (const cell of row ?? []) counts[kindOf(cell)]++;
  return KINDS.map(([words, colour], i) => ({ words, colour, count: counts[i] })).filter((kind) => kind.count);
}

/** @param {any} g @param {number} w @param {number} h @param {[number, number]} here the present values, SI */
export function drawPlane(g, w, h, here) {
  const { x, y, rows } = plane;
  plane.frame = null;
  if (!x || !y) return;
  const edges = (/** @type {Axis} */ { range: [from, to], factor, count }) => { const half = (to - from) / (count - 1) / 2; return /** @type {[number, number]} */ ([(from - half) * factor, (to + half) * factor]); };
  const frame = new Frame(edges(x), edges(y), { left: 56, right: w - 10, top: 22, bottom: h - 22 }), { box } = frame;
  plane.frame = frame;
  const wide = (box.right - box.left) / x.count, high = (box.bottom - box.top) / y.count;
  const place = (/** @type {number} */ i, /** @type {number} */ j) => /** @type {[number, number]} */ ([box.left + i * wide, box.bottom - (j + 1) * high]);
  const label = (/** @type {Axis} */ { name, unit }) => `${name}${unit && ` in ${unit}`}`;
  frame.axes(g, { x: label(x), y: label(y) });
  frame.inside(g, () => {
    // Slightly larger than a cell, so that no seams are visible.
    rows.forEach((row, j) => row?.forEach((cell, i) => { g.fillStyle = KINDS[kindOf(cell)][1]; g.fillRect(...place(i, j), wide + 0.5, high + 0.5); }));
    if (plane.at) { g.strokeStyle = theme.here; g.lineWidth = 2; g.beginPath(); g.rect(...place(...plane.at), wide, high); g.stroke(); }
    const [px, py] = [frame.px(here[0] * x.factor), frame.py(here[1] * y.factor)];
    if (Number.isFinite(px) && Number.isFinite(py)) { g.fillStyle = theme.here; g.strokeStyle = theme.card; g.lineWidth = 2; g.beginPath(); g.arc(px, py, 5, 0, 2 * Math.PI); g.fill(); g.stroke(); }
  });
  if (!rows.some(Boolean)) { g.fillStyle = theme.soft; g.font = `12px ${FONT}`; g.textAlign = "center"; g.textBaseline = "middle"; g.fillText("Computing…", w / 2, h / 2); }
}

/** The cell at a place of the picture. @param {number} px @param {number} py @returns {[number, number] | null} */
export function cellAt(px, py) {
  const { x, y, frame } = plane;
  if (!x || !y || !frame) return null;
  const { left, right, top, bottom } = frame.box;
  const i = Math.floor((px - left) / (right - left) * x.count), j = Math.floor((bottom - py) / (bottom - top) * y.count);
  return i >= 0 && i < x.count && j >= 0 && j < y.count ? [i, j] : null;
}

/** Values in the file's units, and the words of a cell; null where it is not computed. @param {[number, number]} place */
export function cellOf([i, j]) {
  const { x, y, rows } = plane, cell = rows[j]?.[i];
  if (!x || !y || !cell) return null;
  const [vx, vy] = [valueOn(x, i) * x.factor, valueOn(y, j) * y.factor].map((v) => Number(v.toPrecision(8)));
  const kind = KINDS[kindOf(cell)][0], own = cell[0] ?? "", contacts = cell[1] ?? 0;
  const words = kind === "undecided" ? "undecided: not settled within the simulated time" : kind === "no returns" ? "no result: the machine is not valid, its motion cannot continue, or no event occurs" : `${own}, ${Number(contacts.toPrecision(3))} impacts and first touches a return${cell[2] ? ", rests" : ""}`;
  return { x: vx, y: vy, words: `${x.name} = ${Number(vx.toPrecision(4))} ${x.unit}, ${y.name} = ${Number(vy.toPrecision(4))} ${y.unit}: ${words}.` };
}
