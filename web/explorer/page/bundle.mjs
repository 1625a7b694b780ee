// Bundles a page into one HTML file: node bundle.mjs <folder of the page's sources> <folder of the core> <folder of npm packages> <page> [kit].
import { createRequire } from "node:module";
import { mkdir, readFile, writeFile } from "node:fs/promises";
import { dirname, join, resolve } from "node:path";
import { fileURLToPath } from "node:url";
import { gzipSync } from "node:zlib";
import { BLOCK, following } from "./src/packed.js";

const [here, core, packages, page, kit] = process.argv.slice(2).map((path) => resolve(path));
const { build } = createRequire(join(packages, "package.json"))("esbuild");

/** The module and all that it imports, as one script. @param {string} entry @param {Record<string, string>} define */
async function bundled(entry, define) {
  const result = await build({
    entryPoints: [entry], bundle: true, minify: true, write: false, format: "iife", target: "es2022",
    alias: { "vibro-core": join(core, "core.js") }, define: { "import.meta.url": '"file:///"', ...define }, legalComments: "none", charset: "utf8",
  });
  return result.outputFiles[0].text;
}

/** Whether HTML and UTF-16 keep a letter as it is: no zero, carriage return, < or half of a pair. @param {number} letter */
const isKept = (letter) => letter !== 0 && letter !== 13 && letter !== 60 && (letter & 0xf800) !== 0xd800;

/** Letters mixed with the numbers of a key, after the key; null where a letter is not kept. @param {Uint16Array} block @param {number} key */
function mixed(block, key) {
  const letters = new Uint16Array(block.length + 1);
  letters[0] = key;
  for (let i = 0; isKept(letters[i]); i++) {
    if (i === block.length) return letters;
    key = following(key);
    letters[i + 1] = block[i] ^ key;
  }
  return null;
}

/** Bytes as text, the reverse of what `packed.js` does. @param {Uint8Array} bytes */
function asText(bytes) {
  const all = new Uint16Array(Math.ceil(bytes.length / 2)), blocks = [];
  new Uint8Array(all.buffer).set(bytes);
  for (let i = 0; i < all.length; i += BLOCK) {
    const block = all.subarray(i, i + BLOCK);
    let key = 1, letters = mixed(block, key);
    while (!letters && key < 0xffff) letters = mixed(block, ++key);
    if (!letters) throw new Error(`no key for the block at ${i}: make BLOCK smaller`);
    blocks.push(Buffer.from(letters.buffer).toString("utf16le"));
  }
  return `${bytes.length}:${blocks.join("")}`;
}

const worker = await bundled(join(here, "src/worker.js"), {});
const script = await bundled(join(here, "src/main.js"), { WORKER: JSON.stringify(worker) });
const style = (await build({ entryPoints: [join(here, "style.css")], bundle: true, minify: true, write: false })).outputFiles[0].text;
const wasm = await readFile(join(core, "core_bg.wasm"));
// Parts that web-build compressed more, and parts that browsers unpack themselves.
const packed = await readFile(join(core, "core.lzma")).catch(() => gzipSync(wasm, { level: 9 }));
const parts = {
  style, core: asText(packed),
  kit: kit ? asText(await readFile(kit)) : "",
  script: asText(gzipSync(script, { level: 9 })),
  begin: await bundled(fileURLToPath(new URL("src/begin.js", import.meta.url)), {}),
};
const template = await readFile(join(here, "index.html"), "utf8");
const html = template.replace(/\{\{(\w+)\}\}/g, (_, name) => parts[/** @type {keyof typeof parts} */ (name)]);
await mkdir(dirname(page), { recursive: true });
// The byte order mark overrides the encoding stated by a server.
const file = Buffer.from(`\ufeff${html}`, "utf16le");
await writeFile(page, file);
const kB = (/** @type {number} */ n) => `${(n / 1000).toFixed(0)} kB`;
console.error(`page ${kB(file.length)}: core ${kB(2 * parts.core.length)} (${kB(wasm.length)} unpacked), script ${kB(2 * parts.script.length)} (${kB(script.length)} unpacked), style ${kB(2 * style.length)}, the rest ${kB(2 * (parts.begin.length + template.length))}`);
