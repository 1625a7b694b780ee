// Motions of the gallery from the WebAssembly core, for comparison with the native library: node
// core.mjs <folder of the core> <rows>. One line of JSON per machine: its file, the length of its
// default experiment, all columns at equal intervals, and its events.
import { readFileSync } from "node:fs";
import { join, resolve } from "node:path";
import { pathToFileURL } from "node:url";
import { pieces } from "../src/kinds.js";
import { decoder } from "../src/lzma.js";

const folder = resolve(process.argv[2]), count = Number(process.argv[3]);
const core = await import(pathToFileURL(join(folder, "core.js")).href);
const wasm = readFileSync(join(folder, "core_bg.wasm")), packed = new Uint8Array(readFileSync(join(folder, "core.lzma")));
// The page unpacks the compressed module byte for byte.
if (!wasm.equals(Buffer.concat([...pieces(decoder(packed))]))) throw new Error("core.lzma does not unpack to core_bg.wasm");
core.initSync({ module: new WebAssembly.Module(wasm) });
const gallery = JSON.parse(core.examples()), records = gallery.filter(([name]) => !name.endsWith(".toml"));
for (const [file, text] of gallery) {
  if (!file.endsWith(".toml")) continue;
  const bench = new core.Bench(text, records.map(([name]) => name), records.map(([, own]) => own));
  const { stop, head, columns } = JSON.parse(bench.described()), rows = [];
  for (let i = 1; i <= count; i++) {
    bench.record(stop * i / count, 1, 1e6);
    rows.push(Array.from(bench.now().slice(head, head + columns.length)));
  }
  const events = bench.take_events().split("\n").filter(Boolean).map((line) => line.split("\t")).map(([time, kind, element]) => [Number(time), kind, element]);
  console.log(JSON.stringify({ file, stop, rows, events }));
  bench.free();
}
