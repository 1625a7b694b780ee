// Studies over a parameter, in separate workers: two directions of a bifurcation diagram in
// parallel, and periodic orbits.
import { FONT, Frame, theme } from "../../../explorer/page/src/plot.js";
import { Helper } from "./helper.js";
import { shownIn } from "./panels.js";
import { Growing, stepped } from "./thin.js";

/** @typedef {{index: number, start: string | null, values: number[], words: string}} Found */
/** @typedef {[number, number | null, number, string | null, string | null]} Point value (SI), largest of the quantity, 1 if stable, label, start on the orbit */
/** @typedef {{value: number, start: string | null, words: string}} Played a motion of the picture that can be played */

export const study = {
  parameter: "", /** @type {[number, number]} */ range: [0, 1], factor: 1, unit: "", of: "", ofUnit: "1", count: 0,
  /** @type {{rising: Found[], falling: Found[]}} */ found: { rising: [], falling: [] },
  /** @type {Point[][]} */ branches: [],
  /** The motion that the keyboard is at, and its place in the picture. */ at: /** @type {Played & {x: number, y: number} | null} */ (null),
  /** @type {Helper[]} */ helpers: [],
  /** @type {Frame | null} */ frame: null,
  running: false,
  /** Number of studies so far. */ begun: 0,
  /** What the picture shows. */ shown: /** @type {"diagram" | "plane"} */ ("diagram"),
  changed: () => {},
  told: /** @type {(part: number, words: string) => void} */ (() => {}),
};

/** Time beyond the chosen limit after which a search of orbits is ended by force, s. */
const GRACE = 0.5;

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
  Object.assign(study, asked, { found: { rising: [], falling: [] }, branches: [], at: null, running: true, begun: study.begun + 1, shown: "diagram" });
  const begun = performance.now(), helpers = [new Helper(), new Helper()];
  study.helpers = helpers;
  study.told(0, "Started.");
  const heard = () => {
    const done = study.found.rising.length + study.found.falling.length, all = 2 * asked.count, passed = (performance.now() - begun) / 1000;
    study.told(done / all, done > 6 ? `${done} of ${all} values, about ${Math.ceil(passed * (all - done) / done)} s left.` : `${done} of ${all} values.`);
    study.changed();
  };
  try {
    await Promise.all(/** @type {const} */ (["rising", "falling"]).map((way, i) => helpers[i].ask("diagram", { ...machine, ...asked, atSection: false, discard: 400, keep: 60, upward: way === "rising" }, 0, (part) => { study.found[way].push(part); heard(); })));
    const none = [...study.found.rising, ...study.found.falling].filter((found) => !found.start || !found.words).length;
    const without = none ? ` ${none} of them without a motion that returns to the section: there is no machine, it cannot go on, or its events cease.` : "";
    if (study.helpers === helpers) { study.running = false; study.told(1, `${2 * asked.count} values in ${((performance.now() - begun) / 1000).toFixed(1)} s.${without} Black: value rising; grey: falling. Click a point to play it.`); }
  } catch (error) {
    if (study.helpers === helpers) { study.running = false; study.told(NaN, String(/** @type {Error} */ (error).message ?? error)); }
  }
  if (study.helpers === helpers) halt();
  study.changed();
}

const several = (/** @type {number} */ n, /** @type {string} */ one, /** @type {string} */ more) => `${n} ${n === 1 ? one : more}`;

/** @param {{text: string, names: string[], texts: string[]}} machine @param {{parameter: string, range: [number, number], factor: number, unit: string, of: string, ofUnit: string, count: number, seconds: number}} asked */
export async function orbits(machine, asked) {
  const isSame = asked.parameter === study.parameter && asked.of === study.of && String(asked.range) === String(study.range);
  halt();
  if (!isSame) study.found = { rising: [], falling: [] };
  Object.assign(study, asked, { branches: [], at: null, running: true, begun: study.begun + 1, shown: "diagram" });
  const begun = performance.now(), helper = new Helper();
  study.helpers = [helper];
  const { seconds } = asked, passed = () => (performance.now() - begun) / 1000;
  let known = 0;
  const heard = (/** @type {{branches: Point[][], known: number}} */ part) => {
    study.branches.push(...part.branches);
    ({ known } = part);
    study.told(Math.max(study.branches.length / Math.max(1, known), passed() / seconds), `${several(study.branches.length, "branch", "branches")} of ${known} known of so far, after ${passed().toFixed(0)} s of ${seconds} s at most.`);
    study.changed();
  };
  // A long motion or branch may not check the clock: the worker is then ended, and its reported results are kept.
  const late = window.setTimeout(() => helper.end("late"), 1000 * (seconds + GRACE));
  study.told(0, `Motions settle; then their orbits are followed over the range, for ${seconds} s at most.`);
  try {
    await helper.ask("orbits", { ...machine, ...asked }, 0, heard).catch((error) => { if (error.message !== "late") throw error; });
    const { branches } = study, stable = branches.filter((b) => b.some((p) => p[2])).length, rest = known - branches.length, unfinished = passed() > seconds;
    study.running = false;
    if (!branches.length && unfinished) study.told(1, `No branch was found in ${passed().toFixed(1)} s: the motions had not settled by then. Choose a longer time, or use the command line vibro.`);
    else study.told(1, `${several(branches.length, "branch", "branches")} of periodic orbits, ${stable} stable somewhere, in ${passed().toFixed(1)} s${rest > 0 ? `; ${several(rest, "more beginning was", "more beginnings were")} not followed in that time` : ""}. Full: stable; dashed: unstable. Click one to play its motion.`);
  } catch (error) {
    if (study.helpers[0] === helper) { study.running = false; study.told(NaN, String(/** @type {Error} */ (error).message ?? error)); }
  }
  clearTimeout(late);
  if (study.helpers[0] === helper) halt();
  study.changed();
}

/** The dots of a direction in the order in which they were found, and their picture. */
const dots = { rising: empty(), falling: empty() };
function empty() { return { picture: new Growing(), list: /** @type {Found[]} */ ([]), taken: 0, points: /** @type {[number, number][]} */ ([]) }; }
/** The range of the picture. */
const span = { of: 0, y: /** @type {[number, number]} */ ([NaN, NaN]) };

/** The dots of a direction as value and maximum, SI. @param {"rising" | "falling"} way */
function dotsOf(way) {
  const own = dots[way], list = study.found[way];
  if (own.list !== list) Object.assign(own, { list, taken: 0, points: [] });
  for (; own.taken < list.length; own.taken++) for (const y of list[own.taken].values) own.points.push([valueAt(list[own.taken].index), y]);
  return own;
}

/** Least and largest of the maxima, SI. @returns {[number, number]} */
function ends() {
  let low = Infinity, high = -Infinity;
  const take = (/** @type {number | null} */ y) => { if (y !== null && y < low) low = y; if (y !== null && y > high) high = y; };
  for (const way of /** @type {const} */ (["rising", "falling"])) for (const [, y] of dotsOf(way).points) take(y);
  for (const branch of study.branches) for (const [, y] of branch) take(y);
  return [low, high];
}

/** @param {any} g @param {number} w @param {number} h @param {number} here the present value, SI */
export function drawStudy(g, w, h, here) {
  const [low, high] = ends();
  study.frame = null;
  if (!study.parameter || !(low <= high)) {
    g.fillStyle = theme.soft; g.font = `12px ${FONT}`; g.textAlign = "center"; g.textBaseline = "middle";
    g.fillText(study.running ? "Computing…" : study.parameter ? "Nothing was found" : "Not computed yet", w / 2, h / 2);
    return;
  }
  const [f, u] = shownIn(study.ofUnit, Math.max(Math.abs(low), Math.abs(high))), k = study.factor;
  if (span.of !== study.begun) Object.assign(span, { of: study.begun, y: [NaN, NaN] });
  span.y = stepped(span.y, [low, high], !study.running);
  const frame = new Frame([study.range[0] * k, study.range[1] * k], [span.y[0] * f, span.y[1] * f], { left: 56, right: w - 10, top: 22, bottom: h - 22 });
  study.frame = frame;
  frame.axes(g, { x: `${study.parameter}${study.unit && ` in ${study.unit}`}`, y: `maxima of ${study.of}${u && ` in ${u}`}` });
  const dot = w / Math.max(1, study.count) > 3 ? 1.6 : 1.1;
  for (const [way, colour] of /** @type {["rising" | "falling", string][]} */ ([["falling", theme.falling], ["rising", theme.ink]])) {
    const { picture, points } = dotsOf(way);
    picture.draw(g, `${study.parameter} ${frame.x} ${frame.y} ${dot} ${colour} ${study.begun}`, points.length, (own, from, to) => frame.inside(own, () => {
      own.fillStyle = colour;
      for (const [value, y] of points.slice(from, to)) own.fillRect(frame.px(value * k) - dot / 2, frame.py(y * f) - dot / 2, dot, dot);
    }));
  }
  frame.inside(g, () => {
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
    if (study.at) { g.strokeStyle = theme.here; g.lineWidth = 2; g.beginPath(); g.arc(frame.px(study.at.x), frame.py(study.at.y), 6, 0, 2 * Math.PI); g.stroke(); }
    if (Number.isFinite(here)) { g.strokeStyle = theme.here; g.lineWidth = 1; g.beginPath(); g.moveTo(frame.px(here * k), frame.box.top); g.lineTo(frame.px(here * k), frame.box.bottom); g.stroke(); }
  });
}

/** Discards the displayed result, which belongs to another machine. */
export function forget() {
  halt("");
  Object.assign(study, { parameter: "", found: { rising: [], falling: [] }, branches: [], at: null, frame: null, shown: "diagram" });
}

/** All that can be played, each with its place in the picture's units. @returns {(Played & {x: number, y: number})[]} */
function playable() {
  const { frame, factor: k } = study;
  if (!frame) return [];
  const [f] = shownIn(study.ofUnit, Math.max(Math.abs(frame.y[0]), Math.abs(frame.y[1])));
  const dots = [...study.found.rising, ...study.found.falling].flatMap(({ index, start, values, words }) => values.map((y) => ({ value: valueAt(index), start, words, x: valueAt(index) * k, y: y * f })));
  const orbit = (/** @type {Point} */ [value, top, stable, label, start]) => ({ value, start, words: `periodic orbit, ${stable ? "stable" : "unstable: rounding leads the motion away from it"}${label ? `, ${label}` : ""}`, x: value * k, y: (top ?? NaN) * f });
  return [...dots, ...study.branches.flat().map(orbit).filter(({ y, start }) => start && Number.isFinite(y))];
}

/** The motion that is nearest to a place of the picture. @param {number} px @param {number} py */
export function nearest(px, py) {
  const { frame } = study;
  let least = Infinity, best = null;
  if (!frame) return null;
  for (const one of playable()) {
    const dx = frame.px(one.x) - px, dy = frame.py(one.y) - py, away = 4 * dx * dx + dy * dy;
    if (Math.abs(dx) <= 12 && away < least) { least = away; best = one; }
  }
  return best;
}

/** Goes with the keyboard to the next motion: across to the next value, up and down among those there. @param {number} across @param {number} up */
export function step(across, up) {
  const { frame } = study, list = playable();
  if (!frame || !list.length) return null;
  const from = study.at ?? { x: (frame.x[0] + frame.x[1]) / 2, y: (frame.y[0] + frame.y[1]) / 2 }, tiny = 1e-9 * (frame.x[1] - frame.x[0]);
  const ahead = list.filter(({ x, y }) => (across ? (x - from.x) * across > tiny : Math.abs(x - from.x) <= tiny && (y - from.y) * up > 0));
  const away = (/** @type {{x: number, y: number}} */ { x, y }) => 1e3 * Math.abs(frame.px(x) - frame.px(from.x)) + Math.abs(frame.py(y) - frame.py(from.y));
  const next = (study.at ? ahead : list).sort((a, b) => away(a) - away(b))[0];
  if (next) study.at = next;
  return study.at;
}
