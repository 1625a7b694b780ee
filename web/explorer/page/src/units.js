// Units of displayed numbers: the units of the groups and of L or, in SI, the unit in which a value was typed, otherwise a usual unit
// for its size. The library's numbers stay in SI and in units of L; axes have a factor.
import { BY_NAME, set, state } from "./state.js";

/** @typedef {{plain: string, symbol: string, factor: number}} Unit a unit as files and as the page write it, and how many of it the SI unit is */
/** @typedef {import("./plot.js").Axis} Axis */

/** @type {Map<string, Unit>} */
const shown = new Map();

/** Lengths below this limit, m, are shown in mm. */
const SMALL = 0.1;

/** The unit that is usual for a value of this size. @param {string} name @param {string} si */
function usual(name, si) {
  const value = Math.abs(set.value(name));
  if (si === "m") return value < SMALL ? "mm" : si;
  if (si === "N/m") return value >= 1e4 ? "kN/m" : si;
  if (si === "rad/s") return value >= 2 * Math.PI ? "Hz" : si;
  return si;
}

/** Lets units follow the values again, except while a slider moves. */
export const chooseUnits = () => shown.clear();

/** The unit of a parameter. @param {string} name @returns {Unit} */
export function unitOf(name) {
  const known = shown.get(name);
  if (known) return known;
  const si = BY_NAME.get(name)?.unit ?? "1", plain = si === "1" ? "" : state.units[name] ?? usual(name, si);
  const unit = { plain, symbol: plain.replace(".", "·").replace(/^u/, "µ"), factor: plain ? 1 / set.read(name, "1", plain) : 1 };
  shown.set(name, unit);
  return unit;
}

/** A number to so many digits without zeros at its end. @param {number} x @param {number} digits */
export const digits = (x, digits) => String(Number.parseFloat(x.toPrecision(digits)));

const inSi = () => state.form === "si";

/** An axis of data in units of L. @param {string} symbol @returns {Axis} */
export function lengths(symbol) {
  if (!inSi()) return { label: `${symbol}/L`, factor: 1 };
  const unit = unitOf("stop.gap");
  return { label: `${symbol} (${unit.symbol})`, factor: set.value("stop.gap") * unit.factor };
}

/** An axis of speeds in units of which one is so many m/s and is called so. @param {string} symbol @param {number} speed @param {string} name @returns {Axis} */
export function speeds(symbol, speed, name) {
  if (!inSi()) return { label: `${symbol}/${name}`, factor: 1 };
  const small = speed < 0.5 && unitOf("stop.gap").plain !== "m";
  return { label: `${symbol} (${small ? "mm" : "m"}/s)`, factor: small ? 1000 * speed : speed };
}

/** An axis of times in drive periods. @param {number} period @returns {Axis} */
export const times = (period) => (inSi() ? { label: "t (s)", factor: period } : { label: "t/T", factor: 1 });

/** The axis of a parameter, whose data are in SI. @param {string} name @returns {Axis} */
export function parameterAxis(name) {
  const unit = unitOf(name), symbol = BY_NAME.get(name)?.symbol ?? "";
  if (!unit.symbol) return { label: symbol, factor: 1 };
  return { label: `${symbol}${["Hz", "mHz", "kHz", "rpm", "1/min"].includes(unit.plain) ? "/2π" : ""} (${unit.symbol})`, factor: unit.factor };
}

/** The least round number that is not below a positive one. @param {number} x */
export function round(x) {
  const power = 10 ** Math.floor(Math.log10(x));
  const step = [1, 1.5, 2, 2.5, 3, 4, 5, 6, 8, 10].find((f) => f * power >= x * (1 - 1e-12)) ?? 10;
  return Number((step * power).toPrecision(12));
}

/** A typical value of a physical parameter that is zero, from the others. @param {string} name */
function typical(name) {
  const [m, k, l] = ["box.m", "box.k", "stop.gap"].map((n) => set.value(n));
  return { "coupling.k": 0.05 * k, "secondary.k": 0.05 * k, "box.c": 0.05 * Math.sqrt(k * m), "secondary.c": 0.05 * Math.sqrt(k * m), "drive.amplitude": 0.05 * k * l }[name] || 1;
}

/** The ends of a parameter's slider, which hold its value: what is usual for a group, from nothing to about twice the value in SI. @param {import("./core.js").Parameter} p @returns {[number, number]} */
export function ends(p) {
  const value = set.value(p.name);
  if (p.group || p.unit === "rad" || p.name === "stop.restitution") {
    const low = value >= p.low ? p.low : value < 0 ? -round(-1.5 * value) : 0, high = value <= p.high ? p.high : round(1.5 * value);
    // A small value would be at the end of the usual range.
    return low === 0 && value > 0 && value < 0.05 * high ? [0, round(2 * value)] : [low, high];
  }
  const { factor } = unitOf(p.name);
  return [0, round(2 * (Math.abs(value) || typical(p.name)) * factor) / factor];
}

/** The range of a diagram over a parameter, which holds its value. @param {import("./core.js").Parameter} p @returns {[number, number]} */
export function range(p) {
  const value = set.value(p.name);
  if (p.name === "f10") return value < 0.5 ? [0, 5] : [0.5, Math.max(5, round(1.5 * value))];
  if (p.group || p.name === "stop.restitution") return ends(p);
  const { factor } = unitOf(p.name), size = (Math.abs(value) || typical(p.name)) * factor, step = round(size / 20);
  const edge = (/** @type {number} */ x) => Number((Math.round(x / step) * step).toPrecision(12)) / factor;
  return [edge(0.5 * size), edge(1.5 * size)];
}

/** Reason for an axis or caption to leave the oscillator out: it is not coupled to the block. */
export const uncoupled = () => set.value("coupling.k") === 0;
