// The library: unpacked from the page itself and compiled once; workers get the compiled module.
import * as glue from "vibro-core";
import { unzipped } from "./packed.js";

export const { Set: ParameterSet, Machine, Columns, catalogue, response, branches, manifold } = glue;

/** Number of values in a row of a record: time, x1, x2, x3, v1, v2, v3, w, w', drive phase, kind. */
export const ROW = 11;
export const [TIME, X1, X2, X3, V1, V2, V3, W, RATE, PHASE, KIND] = Array(ROW).keys();

/** @param {WebAssembly.Module} module */
export function use(module) {
  glue.initSync({ module });
}

/** The module in the page, gzip-compressed. */
export const unpack = async () => WebAssembly.compile(await unzipped("core").arrayBuffer());

/** @typedef {{name: string, symbol: string, unit: string, allowed: string, low: number, high: number, meaning: string, group: boolean}} Parameter */

/** All parameters, physical ones first. @returns {Parameter[]} */
export function parameters() {
  return catalogue().trim().split("\n").map((line, i) => {
    const [name, word, unit, allowed, low, high, meaning] = line.split("\t");
    const symbol = word === "drive phase" ? "φ" : word;
    return { name, symbol, unit, allowed, low: +low, high: +high, meaning, group: i >= 13 };
  });
}

/** A parameter set from its assignments, in their order. @param {boolean} strong @param {[string, number][]} assignments */
export function setOf(strong, assignments) {
  let set = new ParameterSet(strong);
  for (const [name, value] of assignments) set = set.with(name, value);
  return set;
}
