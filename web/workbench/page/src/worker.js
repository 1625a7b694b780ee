// Work of a worker for the page: one question at a time, in order of arrival.
import * as core from "vibro-core";

const post = (/** @type {any} */ message, /** @type {Transferable[]} */ moved = []) => /** @type {any} */ (self).postMessage(message, moved);
let id = 0;
/** @type {any} */ (globalThis).panicked = (/** @type {string} */ words) => post({ panicked: words });
/** @type {any} */ (globalThis).progressed = (/** @type {string} */ branches, /** @type {number} */ known) => { post({ id, part: { branches: JSON.parse(branches), known } }); return performance.now() < until; };

/** Time limit of a fit or a search of orbits, its number of steps, and the time of the last report. */
let until = 0, steps = 0, toldAt = 0;
/** @type {any} */ (globalThis).goesOn = () => {
  const now = performance.now();
  steps++;
  if (now - toldAt > 100) { toldAt = now; post({ id, part: { steps } }); }
  return now < until;
};

/** @type {core.Bench | null} */
let bench = null;
/** Start time of the run, s: the page counts from it. */
let zero = 0;
/** @type {core.Plane | null} */
let plane = null;

/** Lines of events, each with its time first, counted from the run's begin. @param {string} lines */
const sinceZero = (lines) => (zero ? lines.replace(/^[^\t\n]+/gm, (time) => String(Number(time) - zero)) : lines);

/** Rows and events until a time, or until so many milliseconds have passed. @param {{to: number, step: number, time: number, most: number}} asked */
function run({ to, step, time, most }) {
  const until = performance.now() + time, parts = /** @type {Float64Array[]} */ ([]), now = () => (bench ? bench.time() - zero : 0);
  let problem = "", length = 0, at = now();
  while (bench && at < to - 1e-9 * step && length < most) {
    // The instants are whole multiples of the step, so they do not depend on the slices.
    const next = Math.min(to, (Math.floor(at / step + 1e-9) + 1) * step);
    try { const rows = bench.record(zero + next, 1, 2000); parts.push(rows); length += rows.length; } catch (error) { problem = String(/** @type {Error} */ (error).message ?? error); break; }
    at = now();
    if (performance.now() > until) break;
  }
  const rows = new Float64Array(length);
  let place = 0;
  for (const part of parts) { rows.set(part, place); place += part.length; }
  if (bench && zero) { const width = bench.now().length; for (let i = 0; i < length; i += width) rows[i] -= zero; }
  return { rows, events: bench ? sinceZero(bench.take_events()) : "", time: at, problem };
}

/** @type {Record<string, (asked: any) => {answer: any, moved?: Transferable[]}>} */
const answers = {
  examples: () => ({ answer: JSON.parse(core.examples()) }),
  open: ({ text, names, texts, start }) => {
    const next = new core.Bench(text, names, texts);
    bench?.free();
    bench = next;
    if (start) bench.restart(start);
    zero = bench.time();
    const now = bench.now();
    now[0] = 0;
    return { answer: { machine: JSON.parse(bench.described()), words: bench.words().split("\n"), now, marks: bench.sketch(new Float64Array(0), new Float64Array(0)) } };
  },
  run: (asked) => { const answer = run(asked); return { answer, moved: [answer.rows.buffer] }; },
  sketch: ({ shifts, openings }) => { const answer = bench ? bench.sketch(shifts, openings) : new Float32Array(0); return { answer, moved: [answer.buffer] }; },
  edit: ({ text, names, texts, name, value }) => ({ answer: core.edited(text, names, texts, name, value) }),
  completion: ({ head, tail }) => ({ answer: JSON.parse(core.completion(head, tail)) }),
  pack: ({ text, names, texts, version, kit }) => { const answer = core.pack(text, names, texts, version, kit); return { answer, moved: [answer.buffer] }; },
  platforms: ({ kit }) => ({ answer: core.platforms(kit) }),
  diagram: ({ text, names, texts, parameter, range, count, of, atSection, discard, keep, upward }) => {
    const diagram = new core.Diagram(text, names, texts, parameter, Float64Array.from(range), count, of, atSection, discard, keep, upward);
    for (let part = JSON.parse(diagram.further()); part; part = JSON.parse(diagram.further())) post({ id, part });
    diagram.free();
    return { answer: null };
  },
  plane: ({ text, names, texts, across, upwards, ranges, counts, discard }) => {
    plane = new core.Plane(text, names, texts, across, upwards, Float64Array.from(ranges), Uint32Array.from(counts), discard);
    return { answer: null };
  },
  row: ({ row }) => ({ answer: plane ? JSON.parse(plane.row(row)) : [] }),
  recorded: ({ table }) => ({ answer: JSON.parse(core.recorded(table)) }),
  fit: ({ text, names, texts, table, free, seconds }) => {
    [until, steps, toldAt] = [performance.now() + 1000 * seconds, 0, 0];
    return { answer: JSON.parse(core.fitted(text, names, texts, table, free)) };
  },
  orbits: ({ text, names, texts, parameter, range, of, seconds }) => {
    until = performance.now() + 1000 * seconds;
    core.branches(text, names, texts, parameter, Float64Array.from(range), of);
    return { answer: null };
  },
};

self.onmessage = ({ data }) => {
  if (data.kind === "module") return void core.initSync({ module: data.module });
  ({ id } = data);
  try {
    const { answer, moved } = answers[data.kind](data);
    post({ id, answer }, moved);
  } catch (error) {
    if (error instanceof WebAssembly.RuntimeError) return post({ panicked: error.message });
    post({ id, refused: String(/** @type {Error} */ (error).message ?? error) });
  }
};
