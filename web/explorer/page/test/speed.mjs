// The core's time per drive period: node speed.mjs <folder of the core>.
import { readFileSync } from "node:fs";
import { join, resolve } from "node:path";
import { pathToFileURL } from "node:url";

const folder = resolve(process.argv[2]);
const core = await import(pathToFileURL(join(folder, "core.js")).href);
core.initSync({ module: new WebAssembly.Module(readFileSync(join(folder, "core_bg.wasm"))) });
const start = Float64Array.from([0, 0, 0, 0, 1, 0]);
for (const [what, f10] of [["two impacts a period", 1.5], ["chaos", 3.6]]) {
  const set = new core.Set(false).with("f10", f10), settled = new core.Machine(set, start).settled(400);
  let best = Infinity;
  for (let i = 0; i < 12; i++) {
    // The smallest processor time counts, so that other work on the machine does not matter.
    const begin = process.cpuUsage();
    settled.settled(10_000).free();
    best = Math.min(best, process.cpuUsage(begin).user / 1000);
  }
  const columns = new core.Columns(set, "f10", "x2");
  const begin = process.cpuUsage();
  for (let i = 0; i < 100; i++) columns.column(2 + 0.02 * i, start, 160, 60);
  console.log(`${what}: ${(best / 10).toFixed(2)} µs a drive period; a column of 160 + 60 periods with maxima ${(process.cpuUsage(begin).user / 1e5).toFixed(2)} ms`);
}
