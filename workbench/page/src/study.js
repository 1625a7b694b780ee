// Studies over a number, in workers of their own: two directions of a bifurcation diagram side by
// side, and periodic orbits.
import { FONT, Frame, reach, theme } from "../../../explorer/page/src/plot.js";
import { Helper } from "./helper.js";
import { shownIn } from "./panels.js";

/** @typedef {{index: number, start: string | null, values: number[], words: string}} Found */

export const study = {
  parameter: "", /** @type {[number, number]} */ range: [0, 1], factor: 1, unit: "", of: "", ofUnit: "1", count: 0,
  /** @type {{rising: Found[], falling: Found[]}} */ found: { rising: [], falling: [] },
  /** @type {[number, number | null, number, string | null][][]} */ branches: [],
  /** @type {Helper[]} */ helpers: [],
  /** @type {Frame | null} */ frame: null,
  running: false,
  /** What the picture shows. */ shown: /** @type {"diagram" | "plane"} */ ("diagram"),
  changed: () => {},
  told: /** @type {(part: number, words: string) => void} */ (() => {}),
};

/** The value at an index, SI. @param {number} i */
export const valueAt = (i) => study.range[0] + (study.range[1] - study.range[0]) * i / Math.max(1, study.count - 1);

export function halt(words = "Stopped; what was found stays.") {
  for (const helper of study.helpers) helper.stop();
  study.helpers = [];
  if (study.running) study.told(NaN, words);
  study.running = false;
}

/** @param {{text: string, names: string[], texts: string[]}} machine @param {{parameter: string, range: [number, number], factor: number, unit: string, of: string, ofUnit: string, count: number}} asked */
export async function diagram(machine, asked) {
  halt();
  Object.assign(study, asked, { found: { rising: [], falling: [] }, branches: [], running: true, shown: "diagram" });
  const begun = performance.now(), helpers = [new Helper(), new Helper()];
  study.helpers = helpers;
  study.told(0, "Begun.");
  const heard = () => {
    const done = study.found.rising.length + study.found.falling.length, all = 2 * asked.count, passed = (performance.now() - begun) / 1000;
    study.told(done / all, done > 6 ? `${done} of ${all} values, about ${Math.ceil(passed * (all - done) / done)} s left.` : `${done} of ${all} values.`);
    study.changed();
  };
  try {
    await Promise.all(/** @type {const} */ (["rising", "falling"]).map((way, i) => helpers[i].ask("diagram", { ...machine, ...asked, atSection: false, discard: 400, keep: 60, upward: way === "rising" }, 0, (part) => { study.found[way].push(part); heard(); })));
    if (study.helpers === helpers) { study.running = false; study.told(1, `${2 * asked.count} values in ${((performance.now() - begun) / 1000).toFixed(1)} s. Click a point to play it.`); }
  } catch (error) {
    if (study.helpers === helpers) { study.running = false; study.told(NaN, String(/** @type {Error} */ (error).message ?? error)); }
  }
  if (study.helpers === helpers) halt();
  study.changed();
}

/** @param {{text: string, names: string[], texts: string[]}} machine @param {{parameter: string, range: [number, number], factor: number, unit: string, of: string, ofUnit: string, count: number}} asked */
export async function orbits(machine, asked) {
  const isSame = asked.parameter === study.parameter && asked.of === study.of && String(asked.range) === String(study.range);
  halt();
  if (!isSame) study.found = { rising: [], falling: [] };
  Object.assign(study, asked, { branches: [], running: true, shown: "diagram" });
  const begun = performance.now(), helper = new Helper();
  study.helpers = [helper];
  study.told(0, "Motions settle; then their orbits are followed over the range.");
  try {
    study.branches = await helper.ask("orbits", { ...machine, ...asked }, 0, ({ done, known }) => study.told(done / Math.max(1, known), `${done} branches of ${known} known of, after ${((performance.now() - begun) / 1000).toFixed(0)} s.`));
    const stable = study.branches.filter((b) => b.some((p) => p[2])).length;
    study.running = false;
    study.told(1, `${study.branches.length} branches of periodic orbits, ${stable} stable somewhere, in ${((performance.now() - begun) / 1000).toFixed(1)} s. Full: stable; dashed: unstable.`);
  } catch (error) {
    if (study.helpers[0] === helper) { study.running = false; study.told(NaN, String(/** @type {Error} */ (error).message ?? error)); }
  }
  if (study.helpers[0] === helper) halt();
  study.changed();
}

/** @param {any} g @param {number} w @param {number} h @param {number} here the present value, SI */
export function drawStudy(g, w, h, here) {
  const all = [...study.found.rising, ...study.found.falling], tops = all.flatMap((f) => f.values).concat(study.branches.flatMap((b) => b.map((p) => p[1]).filter((x) => x !== null)));
  study.frame = null;
  if (!study.parameter || !tops.length) {
    g.fillStyle = theme.soft; g.font = `12px ${FONT}`; g.textAlign = "center"; g.textBaseline = "middle";
    g.fillText(study.running ? "Computing…" : "Not computed yet", w / 2, h / 2);
    return;
  }
  const [f, u] = shownIn(study.ofUnit, Math.max(...tops.map((x) => Math.abs(Number(x))))), k = study.factor;
  const frame = new Frame([study.range[0] * k, study.range[1] * k], reach(tops.map((x) => Number(x) * f)), { left: 56, right: w - 10, top: 22, bottom: h - 22 });
  study.frame = frame;
  frame.axes(g, { x: `${study.parameter}${study.unit && ` in ${study.unit}`}`, y: `maxima of ${study.of}${u && ` in ${u}`}` });
  frame.inside(g, () => {
    const dot = w / Math.max(1, study.count) > 3 ? 1.6 : 1.1;
    for (const [list, colour] of /** @type {[Found[], string][]} */ ([[study.found.falling, theme.falling], [study.found.rising, theme.ink]])) {
      g.fillStyle = colour;
      for (const { index, values } of list) { const x = frame.px(valueAt(index) * k); for (const y of values) g.fillRect(x - dot / 2, frame.py(y * f) - dot / 2, dot, dot); }
    }
    g.lineWidth = 1.6;
    for (const branch of study.branches) {
      for (let i = 1; i < branch.length; i++) {
        const [a, b] = [branch[i - 1], branch[i]];
        if (a[1] === null || b[1] === null) continue;
        g.strokeStyle = a[2] ? theme.box : theme.block; g.setLineDash(a[2] ? [] : [5, 4]);
        g.beginPath(); g.moveTo(frame.px(a[0] * k), frame.py(a[1] * f)); g.lineTo(frame.px(b[0] * k), frame.py(b[1] * f)); g.stroke();
      }
    }
    g.setLineDash([]);
    if (Number.isFinite(here)) { g.strokeStyle = theme.here; g.lineWidth = 1; g.beginPath(); g.moveTo(frame.px(here * k), frame.box.top); g.lineTo(frame.px(here * k), frame.box.bottom); g.stroke(); }
  });
}

/** The motion of the diagram that is nearest to a place of its picture. @param {number} px @param {number} py */
export function nearest(px, py) {
  const { frame } = study;
  if (!frame) return null;
  let least = Infinity, /** @type {Found | null} */ best = null;
  for (const found of [...study.found.rising, ...study.found.falling]) {
    const dx = frame.px(valueAt(found.index) * study.factor) - px;
    if (Math.abs(dx) > 12) continue;
    const [f] = shownIn(study.ofUnit, Math.max(Math.abs(frame.y[0]), Math.abs(frame.y[1])));
    for (const y of found.values) { const dy = frame.py(y * f) - py, away = 4 * dx * dx + dy * dy; if (away < least) { least = away; best = found; } }
  }
  return best;
}
