// FMUs packed by the page, downloaded in headless Chromium: node fmu.mjs <npm packages> <page with
// a kit> <folder> <example>….
import assert from "node:assert/strict";
import { join } from "node:path";
import { open } from "../../../explorer/page/test/browser.mjs";

const [packages, page, folder, ...examples] = process.argv.slice(2);
const browser = await open(packages, page, "window.workbench && workbench.pictures > 0");
for (const example of examples) {
  const { tab, wrong, close } = await browser.tab({}, `#example=${example}`);
  for (const version of [2, 3]) {
    const [download] = await Promise.all([tab.waitForEvent("download"), tab.click(`[data-take="fmu${version}"]`)]);
    assert.equal(download.suggestedFilename().endsWith("-FMI3.fmu"), version === 3, download.suggestedFilename());
    await download.saveAs(join(folder, `${example}-fmi${version}.fmu`));
    console.log(`${example} FMI ${version}.0: ${await tab.evaluate("workbench.packed.toFixed(0)")} ms`);
  }
  if (wrong.length) { console.log(wrong); process.exit(1); }
  await close();
}
await browser.close();
