// Motions by the WebAssembly core, for a comparison with the native library: node core.mjs <folder of the core>.
// A line of the standard input is a list name=value;…; the answer is a line of numbers: t, x1, x2, x3, v1, v2, v3 at the end of each of
// twenty drive periods, then the number of impacts.
import { readFileSync } from "node:fs";
import { join, resolve } from "node:path";
import { pathToFileURL } from "node:url";

const folder = resolve(process.argv[2]);
const core = await import(pathToFileURL(join(folder, "core.js")).href);
core.initSync({ module: new WebAssembly.Module(readFileSync(join(folder, "core_bg.wasm"))) });
for (const line of readFileSync(0, "utf8").trim().split("\n")) {
  let set = new core.Set(false);
  for (const part of line.split(";").filter(Boolean)) {
    const [name, value] = part.split("=");
    set = set.with(name, Number(value));
  }
  const machine = new core.Machine(set, Float64Array.from([0, 0, 0, 0, 1, 0])), period = 2 * Math.PI / set.value("drive.frequency");
  const numbers = [];
  // As in the page: in frames, with the histories of each.
  for (let i = 1; i <= 20; i++) {
    machine.record(i * period, 120);
    numbers.push(...machine.now().subarray(0, 7));
  }
  const now = machine.now();
  numbers.push(now[now.length - 2] + now[now.length - 1]);
  console.log(numbers.join(" "));
}
