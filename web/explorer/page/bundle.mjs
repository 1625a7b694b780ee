// Bundles a page into one HTML file: node bundle.mjs <folder of the page's sources> <folder of the core> <folder of npm packages> <page> [kit].
import { createRequire } from "node:module";
import { mkdir, readFile, writeFile } from "node:fs/promises";
import { dirname, join, resolve } from "node:path";
import { gzipSync } from "node:zlib";
import { CHANGED } from "./src/packed.js";

const [here, core, packages, page, kit] = process.argv.slice(2).map((path) => resolve(path));
const { build } = createRequire(join(packages, "package.json"))("esbuild");

/** The module and all that it imports, as one script. @param {string} entry @param {Record<string, string>} define */
async function bundled(entry, define) {
  const result = await build({
    entryPoints: [join(here, "src", entry)], bundle: true, minify: true, write: false, format: "iife", target: "es2022",
    alias: { "vibro-core": join(core, "core.js") }, define: { "import.meta.url": '"file:///"', ...define }, legalComments: "none", charset: "utf8",
  });
  return result.outputFiles[0].text;
}

/** Bytes as text, the reverse of what `packed.js` does. @param {Uint8Array} bytes */
function asText(bytes) {
  const letters = /** @type {number[]} */ ([]);
  let held = 0, bits = 0, before = -1;
  const put = (/** @type {number} */ seven) => {
    if (before >= 0) { letters.push(128 + 128 * before + seven); before = -1; return; }
    before = CHANGED.indexOf(seven);
    if (before < 0) letters.push(seven);
  };
  for (const byte of bytes) {
    held = (held << 8) | byte; bits += 8;
    while (bits >= 7) { bits -= 7; put(held >> bits); held &= (1 << bits) - 1; }
  }
  if (bits > 0) put((held << (7 - bits)) & 127);
  // An open pair is closed by bits that stand for no byte.
  if (before >= 0) put(1);
  return `${bytes.length}:${new TextDecoder("utf-16le").decode(Uint16Array.from(letters))}`;
}

const worker = await bundled("worker.js", {});
const script = await bundled("main.js", { WORKER: JSON.stringify(worker) });
const style = (await build({ entryPoints: [join(here, "style.css")], bundle: true, minify: true, write: false })).outputFiles[0].text;
const wasm = await readFile(join(core, "core_bg.wasm"));
// What web-build has compressed more, and what browsers unpack themselves.
const packed = await readFile(join(core, "core.lzma")).catch(() => gzipSync(wasm, { level: 9 }));
const parts = {
  style, core: asText(packed),
  kit: kit ? asText(await readFile(kit)) : "",
  // The end of the script's element must not stand in the script.
  script: script.replaceAll("</script", "<\\/script"),
};
const template = await readFile(join(here, "index.html"), "utf8");
const html = template.replace(/\{\{(\w+)\}\}/g, (_, name) => parts[/** @type {keyof typeof parts} */ (name)]);
await mkdir(dirname(page), { recursive: true });
await writeFile(page, html);
const kB = (/** @type {number} */ n) => `${(n / 1000).toFixed(0)} kB`;
console.error(`page ${kB(Buffer.byteLength(html))}: core ${kB(Buffer.byteLength(parts.core))} (${kB(wasm.length)} unpacked), script ${kB(script.length)}, style ${kB(style.length)}`);
