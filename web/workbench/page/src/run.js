// The displayed run: rows of all columns from time 0 to its length, its events, and the position
// of the playhead.

import { Thin } from "./thin.js";

/** @typedef {{time: number, kind: string, element: string, value: number, stops: number, impulse: number}} Met */
/** @typedef {{name: string, unit: string, meaning: string}} Column */
/** @typedef {{name: string, rotates: boolean, prescribed: boolean, inner: boolean}} Body */
/** @typedef {{name: string, section: string, gap: number | null, rotates: boolean}} Element */
/** @typedef {{name: string, numbers: any[], columns: Column[], bodies: Body[], elements: Element[], period: number | null, stop: number, step: number, head: number, records: boolean, sketch: {width: number, height: number, names: string[]}}} Machine */

/** Number of values in a row before the columns. */
export const [TIME, KIND, KINETIC, STORED, INPUT, DAMPED, RUBBED, LOST] = Array(8).keys();
/** Largest number of stored values: 64 MB. */
const MOST = 8_000_000;

export const run = {
  /** @type {Machine} */
  machine: /** @type {any} */ (null),
  width: 1,
  rows: new Float64Array(0),
  count: 0,
  /** @type {Met[]} */
  events: [],
  /** Length of the run and interval of its ordinary rows, s. */
  length: 1,
  step: 1e-3,
  /** Computed length, and the reason if it ends there. */
  reached: 0,
  problem: "",
  /** Position of the playhead, s. */
  at: 0,
  largestImpulse: 0,
  /** Number of runs so far. */
  begun: 0,
};
/** What is known of the rows by place, up to a number of rows: least and largest value, and the thinned curve. */
const known = { extents: /** @type {Map<number, {count: number, low: number, high: number}>} */ (new Map()), curves: /** @type {Map<number, Thin>} */ (new Map()) };

/** A new machine begins. @param {Machine} machine @param {Float64Array} now @param {number | null} length */
export function begin(machine, now, length) {
  Object.assign(run, { machine, width: now.length, count: 0, events: [], reached: 0, problem: "", largestImpulse: 0 });
  run.length = length ?? machine.stop;
  run.begun++;
  known.extents.clear(); known.curves.clear();
  // One row per pixel of a wide screen, fewer with very many columns.
  const rows = Math.max(200, Math.min(1500, Math.floor(1_000_000 / run.width)));
  run.step = run.length / rows;
  run.at = Math.min(run.at, run.length);
  if (run.rows.length < run.width * 2000) run.rows = new Float64Array(Math.min(MOST, run.width * 4000));
  keep(now);
}

/** @param {Float64Array} rows */
function keep(rows) {
  const used = run.count * run.width;
  if (used + rows.length > run.rows.length) {
    const more = new Float64Array(Math.min(MOST, Math.max(used + rows.length, 2 * run.rows.length)));
    more.set(run.rows.subarray(0, used));
    run.rows = more;
  }
  if (used + rows.length > run.rows.length) { run.problem = "The run ends here: its rows fill the memory that this page allows itself. A shorter run has more room for its events."; return; }
  run.rows.set(rows, used);
  run.count += rows.length / run.width;
}

/** Takes what the worker has computed further. @param {{rows: Float64Array, events: string, time: number, problem: string}} more */
export function take({ rows, events, time, problem }) {
  keep(rows);
  for (const line of events.split("\n")) {
    if (!line) continue;
    const [at, kind, element, value, stops, impulse] = line.split("\t");
    const met = { time: +at, kind, element: element.slice(element.indexOf(".") + 1), value: value === "" ? NaN : +value, stops: +stops, impulse: impulse === "" ? NaN : +impulse };
    run.events.push(met);
    if (met.impulse > run.largestImpulse) run.largestImpulse = met.impulse;
  }
  run.reached = time;
  run.problem ||= problem;
}

export const isWhole = () => run.problem !== "" || run.reached >= run.length * (1 - 1e-12);

/** The last row at or before a time. @param {number} time */
export function rowBefore(time) {
  let low = 0, high = run.count - 1;
  while (low < high) { const middle = (low + high + 1) >> 1; if (run.rows[middle * run.width] <= time) low = middle; else high = middle - 1; }
  return low;
}

/** Values at a time, between two rows by a straight line; contacts as they are before it. @param {number} time */
export function valuesAt(time) {
  const { width, rows, count } = run, i = rowBefore(time), a = i * width;
  const values = rows.slice(a, a + width);
  if (i + 1 >= count) return values;
  const b = a + width, span = rows[b] - rows[a], part = span > 0 ? Math.min(1, Math.max(0, (time - rows[a]) / span)) : 0;
  const continuous = run.machine.head + run.machine.columns.length;
  for (let k = 0; k < continuous; k++) values[k] += part * (rows[b + k] - rows[a + k]);
  return values;
}

/** The place of a column in a row; -1 where there is none. @param {string} name */
export const columnOf = (name) => { const i = run.machine.columns.findIndex((c) => c.name === name); return i < 0 ? -1 : run.machine.head + i; };

/** Least and largest value of a place in the rows. @param {number} place @returns {[number, number]} */
export function extent(place) {
  const { rows, width, count } = run, own = known.extents.get(place) ?? { count: 0, low: Infinity, high: -Infinity };
  for (; own.count < count; own.count++) { const x = rows[own.count * width + place]; if (x < own.low) own.low = x; if (x > own.high) own.high = x; }
  known.extents.set(place, own);
  return own.low <= own.high ? [own.low, own.high] : [0, 0];
}

/** Rows through which a place's curve over time is drawn. @param {number} place */
export function curveOf(place) {
  const { rows, width, count } = run, own = known.curves.get(place) ?? new Thin(0, run.length);
  while (own.count < count) { const at = own.count * width; own.add(rows[at], rows[at + place]); }
  known.curves.set(place, own);
  return own.indices();
}

/** Events after one time and up to another. @param {number} from @param {number} to */
export function eventsBetween(from, to) {
  let low = 0, high = run.events.length;
  while (low < high) { const middle = (low + high) >> 1; if (run.events[middle].time <= from) low = middle + 1; else high = middle; }
  const found = [];
  for (let i = low; i < run.events.length && run.events[i].time <= to; i++) found.push(run.events[i]);
  return found;
}
