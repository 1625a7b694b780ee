// Writes a module with the bytes of its code separated by kind: node apart.mjs <module> <file>.
import { readFileSync, writeFileSync } from "node:fs";
import { KINDS, pieces, walk } from "./src/kinds.js";

/** Number of functions in a block: the page compiles one block while it unpacks the next. */
const BLOCK = 1000;

const [from, to] = process.argv.slice(2), module = readFileSync(from);
let at = 8;
const number = () => {
  for (let value = 0, shift = 0; ; shift += 7) { const own = module[at++]; value |= (own & 127) << shift; if (own < 128) return value; }
};
// The code section has the number 10.
while (module[at++] !== 10) { const size = number(); at += size; }
number();
const parts = /** @type {Uint8Array[]} */ ([]);
const word = (/** @type {number} */ value) => parts.push(new Uint8Array(Uint32Array.of(value).buffer));
const bytes = (/** @type {Uint8Array} */ own) => { word(own.length); parts.push(own); };
let functions = number();
bytes(module.subarray(0, at));
for (; functions > 0; functions -= BLOCK) {
  const count = Math.min(functions, BLOCK), kinds = Array.from({ length: KINDS }, () => /** @type {number[]} */ ([]));
  walk((kind) => { const byte = module[at++]; kinds[kind].push(byte); return byte; }, count);
  word(count);
  kinds.forEach((kind) => bytes(Uint8Array.from(kind)));
}
word(0);
bytes(module.subarray(at));
const apart = Buffer.concat(parts), joined = Buffer.concat([...pieces({ out: Uint8Array.from(apart), until() { /* all are known */ } })]);
if (!module.equals(joined)) throw new Error("the module's bytes do not come together again");
writeFileSync(to, apart);
