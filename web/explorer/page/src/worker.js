// A worker of the page: columns of the diagram from coarse to fine, and curves over its parameter. A newer request ends an older one.
import { branches, Columns, response, setOf, use } from "./core.js";

/** Working time between two checks for messages, ms. */
const SLICE = 14;

/** Number of the last request of each kind. */
const latest = { diagram: 0, curves: 0, orbits: 0 };

// The core calls a function of this name with its progress.
Object.assign(self, { orbitsProgress: (/** @type {number} */ done, /** @type {number} */ known) => self.postMessage({ kind: "progress", id: latest.orbits, done, known }) });

/** Lets messages arrive. */
const pause = () => new Promise((resolve) => setTimeout(resolve, 0));

/**
 * @typedef {object} Request
 * @property {"diagram" | "curves" | "orbits"} kind
 * @property {number} id
 * @property {boolean} strong
 * @property {[string, number][]} set
 * @property {string} along
 * @property {[number, number]} range
 * @property {string} ordinate
 * @property {number} columns
 * @property {number} settle
 * @property {number} keep
 * @property {boolean} rising
 * @property {number[]} start in L and L/s
 */

/** @param {Request} r */
async function diagram(r) {
  const columns = new Columns(setOf(r.strong, r.set), r.along, r.ordinate);
  const n = r.columns, value = (/** @type {number} */ i) => r.range[0] + (r.range[1] - r.range[0]) * (i + 0.5) / n;
  /** @type {(number[] | null)[]} */
  const ends = Array(n).fill(null);
  /** @type {[number, number, Float64Array][]} */
  let batch = [];
  let until = performance.now() + SLICE;
  const look = async (/** @type {boolean} */ last) => {
    if (!last && performance.now() < until) return true;
    if (batch.length) { self.postMessage({ kind: "columns", id: r.id, rising: r.rising, batch }); batch = []; }
    await pause();
    until = performance.now() + SLICE;
    return latest.diagram === r.id;
  };
  const most = 2 ** Math.floor(Math.log2(Math.max(1, n / 12)));
  for (let stride = most; stride >= 1; stride /= 2) {
    const count = Math.ceil(n / stride);
    for (let k = 0; k < count; k++) {
      // From left to right, or from right to left: each value starts where its neighbour ended.
      const i = (r.rising ? k : count - 1 - k) * stride;
      if (ends[i] || i >= n) continue;
      let from = null;
      for (let j = i; from === null && j >= 0 && j < n; j += r.rising ? -stride : stride) from = ends[j];
      try {
        const found = columns.column(value(i), Float64Array.from(from ?? r.start), r.settle, r.keep);
        ends[i] = Array.from(found.subarray(0, 6));
        batch.push([i, stride, found]);
      } catch { ends[i] = null; batch.push([i, stride, new Float64Array(6).fill(NaN)]); }
      if (!await look(false)) return columns.free();
    }
  }
  if (!await look(true)) return columns.free();
  if (r.rising) {
    // Exponents of the settled motions, also from coarse to fine.
    for (let stride = 16, first = true; stride >= 2; stride /= 2, first = false) {
      for (let i = 0; i < n; i += stride) {
        if (!first && i % (2 * stride) === 0) continue;
        const end = ends[i];
        if (!end) continue;
        try {
          const found = columns.exponents(value(i), Float64Array.from(end), Math.max(60, r.keep));
          self.postMessage({ kind: "exponents", id: r.id, place: i, stride, exponents: found });
        } catch { /* a value that is refused has no exponents */ }
        if (!await look(false)) return columns.free();
      }
    }
  }
  columns.free();
  self.postMessage({ kind: "done", id: r.id, rising: r.rising });
}

/** @param {Request} r */
function curves(r) {
  const set = setOf(r.strong, r.set);
  /** @type {Record<string, Float64Array>} */
  const found = {};
  let problem = "";
  for (const theory of r.strong ? ["exact", "strong"] : ["exact", "scales"]) {
    try { found[theory] = response(set, r.along, r.range[0], r.range[1], theory, 120); } catch (error) { problem = String(/** @type {Error} */ (error).message ?? error); }
  }
  self.postMessage({ kind: "curves", id: r.id, found, problem });
}

/** @param {Request} r */
function orbits(r) {
  try {
    const rows = branches(setOf(r.strong, r.set), r.along, r.range[0], r.range[1], r.ordinate, 13);
    self.postMessage({ kind: "orbits", id: r.id, rows, problem: "" });
  } catch (error) {
    self.postMessage({ kind: "orbits", id: r.id, rows: new Float64Array(0), problem: String(/** @type {Error} */ (error).message ?? error) });
  }
}

self.onmessage = async ({ data }) => {
  if (data.module) return use(data.module);
  const request = /** @type {Request} */ (data);
  latest[request.kind] = request.id;
  if (request.kind === "diagram") return diagram(request);
  // Requests that arrived in the meantime come first.
  await pause();
  if (latest[request.kind] !== request.id) return;
  if (request.kind === "curves") curves(request); else orbits(request);
};
