// Processor time of the core, which other programs hardly affect: node speed.mjs <folder of the
// core>.
import { readFileSync } from "node:fs";
import { join, resolve } from "node:path";
import { pathToFileURL } from "node:url";

const folder = resolve(process.argv[2]);
const core = await import(pathToFileURL(join(folder, "core.js")).href);
core.initSync({ module: new WebAssembly.Module(readFileSync(join(folder, "core_bg.wasm"))) });
const gallery = new Map(JSON.parse(core.examples()));
/** Processor time of a call, ms; the least of several. @param {() => void} what @param {number} times */
function spent(what, times = 5) {
  let least = Infinity;
  for (let i = 0; i < times; i++) { const before = process.cpuUsage(); what(); const { user, system } = process.cpuUsage(before); least = Math.min(least, (user + system) / 1000); }
  return least;
}
for (const name of ["bouncing_ball", "damper_with_buffer", "gear_backlash", "paper_machine", "bead_column"]) {
  const text = gallery.get(`${name}.toml`);
  const read = spent(() => new core.Bench(text, [], []).free(), 20);
  const { stop } = JSON.parse(new core.Bench(text, [], []).described());
  const long = spent(() => { const bench = new core.Bench(text, [], []); bench.record(20 * stop, 1, 1e9); bench.free(); });
  console.log(`${name}: read and begun ${read.toFixed(1)} ms, ${(20 * stop).toPrecision(3)} s of motion ${long.toFixed(0)} ms`);
}
const text = gallery.get("damper_with_buffer.toml");
for (const upward of [true, false]) {
  const took = spent(() => { const d = new core.Diagram(text, [], [], "load.shaker.frequency", Float64Array.from([5, 15]), 200, "box.s", false, 400, 60, upward); while (d.further() !== "null") { /* on */ } d.free(); }, 1);
  console.log(`diagram of 200 values, ${upward ? "rising" : "falling"}: ${(took / 1000).toFixed(2)} s`);
}
