// Bundles a page into one HTML file: node bundle.mjs <folder of the page's sources> <folder of the core> <folder of npm packages> <page> [kit].
import { createRequire } from "node:module";
import { mkdir, readFile, writeFile } from "node:fs/promises";
import { dirname, join, resolve } from "node:path";
import { gzipSync } from "node:zlib";

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

const worker = await bundled("worker.js", {});
const script = await bundled("main.js", { WORKER: JSON.stringify(worker) });
const style = (await build({ entryPoints: [join(here, "style.css")], bundle: true, minify: true, write: false })).outputFiles[0].text;
const wasm = await readFile(join(core, "core_bg.wasm"));
const parts = {
  style, core: gzipSync(wasm, { level: 9 }).toString("base64"),
  kit: kit ? (await readFile(kit)).toString("base64") : "",
  // The end of the script's element must not stand in the script.
  script: script.replaceAll("</script", "<\\/script"),
};
const template = await readFile(join(here, "index.html"), "utf8");
const html = template.replace(/\{\{(\w+)\}\}/g, (_, name) => parts[/** @type {keyof typeof parts} */ (name)]);
await mkdir(dirname(page), { recursive: true });
await writeFile(page, html);
const kB = (/** @type {number} */ n) => `${(n / 1000).toFixed(0)} kB`;
console.error(`page ${kB(html.length)}: core ${kB(parts.core.length)} (${kB(wasm.length)} unpacked), script ${kB(script.length)}, style ${kB(style.length)}`);
