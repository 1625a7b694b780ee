// The state of the page that a link contains: parameters, start, and view.
import { setOf, parameters } from "./core.js";
import { MOVING_BLOCK, PRESETS } from "./presets.js";

/** @type {import("./core.js").Parameter[]} */
export let PARAMETERS = [];
/** @type {Map<string, import("./core.js").Parameter>} */
export const BY_NAME = new Map();

export const state = {
  strong: false,
  /** @type {[string, number][]} what was set, in order */
  set: [],
  /** x1, x2, x3 in L and v1, v2, v3 in L ω10 */
  start: [...MOVING_BLOCK],
  along: "f10",
  /** @type {[number, number]} */
  range: [0.5, 5],
  /** @type {[number, number] | null} of the ordinate; null: all */
  band: null,
  ordinate: "x2",
  section: "strobe",
  /** Plane of the phase portrait: w or a body. */
  plane: "w",
  form: "groups",
  /** The units in which physical parameters were written. @type {Record<string, string>} */
  units: {},
  /** Closed forms over the parameter, or the slow invariant manifold. */
  theory: "response",
  orbits: false,
  /** Speed of the motion: decimal logarithm of the drive periods per second. */
  pace: -0.3,
  /** The preset, unless something was changed. */
  preset: "default",
};

/** The library's set of these parameters. @type {import("vibro-core").Set} */
export let set;

export function prepare() {
  PARAMETERS = parameters();
  for (const p of PARAMETERS) BY_NAME.set(p.name, p);
  set = setOf(state.strong, state.set);
}

/** L in m and the speed unit L ω10 in m/s. */
export function units(of = set) {
  const length = of.value("stop.gap"), omega = Math.sqrt(of.value("box.k") / of.value("box.m"));
  return { length, omega, speed: length * (omega || 1) };
}

/** The start in SI. */
export function startSi(of = set) {
  const { length, speed } = units(of);
  return Float64Array.from(state.start, (x, i) => x * (i < 3 ? length : speed));
}

/** Sets a parameter, or throws the library's message and changes nothing. @param {string} name @param {number} value */
export function assign(name, value) {
  const next = set.with(name, value);
  const twin = { alpha23: "beta2", beta2: "alpha23" }[name];
  const rest = state.set.filter(([other]) => other !== name && other !== twin);
  const physical = [...rest, /** @type {[string, number]} */ ([name, value])].some(([n]) => !BY_NAME.get(n)?.group);
  // The order of two groups does not matter. If physical parameters are set too, all of them are written.
  state.set = physical ? PARAMETERS.filter((p) => !p.group).map((p) => [p.name, next.value(p.name)]) : [...rest, [name, value]];
  set = next;
  state.preset = "";
}

/** @param {import("./presets.js").Preset} preset */
export function usePreset(preset) {
  state.strong = preset.strong ?? false;
  state.set = preset.set.map(([n, v]) => [n, v]);
  state.start = [...(preset.start ?? MOVING_BLOCK)];
  state.along = preset.along;
  state.range = [...preset.range];
  state.band = null;
  state.ordinate = preset.ordinate ?? "x2";
  state.orbits = preset.orbits ?? false;
  state.theory = preset.theory ?? "response";
  state.preset = preset.id;
  state.units = {};
  set = setOf(state.strong, state.set);
}

const pair = (/** @type {readonly (number | string)[]} */ p) => p.join(":");

const presetOf = (/** @type {string} */ id) => PRESETS.find((p) => p.id === id);
/** Whether a preset shows exact orbits. @param {string} id */
const orbitsOf = (id) => presetOf(id)?.orbits ?? false;

/** The text after # of a link. */
export function toHash() {
  const parts = new URLSearchParams();
  if (state.preset && state.preset !== "default") parts.set("preset", state.preset);
  if (state.strong) parts.set("base", "strong");
  for (const [name, value] of state.set) parts.set(name, String(value));
  if (pair(state.start) !== pair(presetOf(state.preset)?.start ?? MOVING_BLOCK)) parts.set("start", state.start.map((x) => +x.toPrecision(9)).join(":"));
  parts.set("over", `${state.along}:${pair(state.range)}`);
  if (state.band) parts.set("band", pair(state.band));
  for (const [key, usual] of /** @type {const} */ ([["ordinate", "x2"], ["section", "strobe"], ["plane", "w"], ["form", "groups"]])) if (state[key] !== usual) parts.set(key, state[key]);
  if (state.theory !== (presetOf(state.preset)?.theory ?? "response")) parts.set("theory", state.theory);
  if (state.orbits !== orbitsOf(state.preset)) parts.set("orbits", state.orbits ? "1" : "0");
  const units = Object.entries(state.units).map(pair);
  if (units.length) parts.set("units", units.join(","));
  if (state.pace !== -0.3) parts.set("pace", String(state.pace));
  return parts.toString().replaceAll("%3A", ":").replaceAll("%2C", ",").replaceAll("%2F", "/");
}

/** Takes over a link; returns what was wrong in it, in words. @param {string} hash @returns {string} */
export function fromHash(hash) {
  const parts = new URLSearchParams(hash.replace(/^#/, ""));
  const preset = PRESETS.find((p) => p.id === (parts.get("preset") ?? "default")) ?? PRESETS[0];
  if (![...parts.keys()].some((key) => BY_NAME.has(key)) || parts.has("preset")) usePreset(preset);
  const problems = [];
  const numbers = (/** @type {string | null} */ text) => (text ?? "").split(":").map(Number);
  if (!parts.has("preset")) {
    state.strong = parts.get("base") === "strong";
    /** @type {[string, number][]} */
    const wanted = [];
    /** @type {Record<string, string>} */
    const units = {};
    try {
      for (const [key, text] of parts) {
        if (!BY_NAME.has(key)) continue;
        wanted.push([key, set.read(key, text, "")]);
        const unit = set.typed(key, text);
        if (unit) units[key] = unit;
      }
      for (const [name, unit] of (parts.get("units") ?? "").split(",").map((text) => text.split(":"))) {
        if (unit && BY_NAME.has(name) && set.typed(name, `1${unit}`) === unit) units[name] = unit;
      }
      state.units = units;
      set = setOf(state.strong, wanted);
      state.set = wanted;
      state.preset = wanted.length || state.strong ? "" : "default";
    } catch (error) {
      problems.push(String(/** @type {Error} */ (error).message ?? error));
    }
  }
  const start = numbers(parts.get("start"));
  if (start.length === 6 && start.every(Number.isFinite)) state.start = start; else if (!parts.has("preset")) state.start = [...MOVING_BLOCK];
  const [along, from, to] = (parts.get("over") ?? "").split(":");
  if (BY_NAME.has(along) && Number(from) < Number(to)) [state.along, state.range] = [along, [Number(from), Number(to)]];
  const band = numbers(parts.get("band"));
  state.band = band.length === 2 && band[0] < band[1] ? [band[0], band[1]] : null;
  const one = (/** @type {string} */ key, /** @type {string[]} */ of, /** @type {string} */ usual) => { const v = parts.get(key) ?? usual; return of.includes(v) ? v : usual; };
  state.ordinate = one("ordinate", ["x1", "x2", "x3", "w", "strobe", "speed"], (parts.has("preset") && preset.ordinate) || "x2");
  state.section = one("section", ["strobe", "impact"], "strobe");
  state.plane = one("plane", ["w", "x1", "x2", "x3"], "w");
  state.form = one("form", ["groups", "si"], "groups");
  state.theory = one("theory", ["response", "manifold"], (parts.has("preset") && preset.theory) || "response");
  state.orbits = parts.has("orbits") ? parts.get("orbits") === "1" : orbitsOf(parts.has("preset") ? preset.id : "");
  const pace = Number(parts.get("pace") ?? -0.3);
  state.pace = pace >= -2 && pace <= 1.3 ? pace : -0.3;
  return problems.join("; ");
}
