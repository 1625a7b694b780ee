// Measurements for the goals of the page: node measure.mjs <npm packages> <page>. Times are
// medians of several runs.
import { frames, open } from "../../../explorer/page/test/browser.mjs";
import { RATTLE } from "./rattle.mjs";

const [packages, page] = process.argv.slice(2);
const browser = await open(packages, page, "window.workbench && workbench.pictures > 0");
const median = (/** @type {number[]} */ all) => all.sort((a, b) => a - b)[Math.floor(all.length / 2)];
const first = [];
for (let i = 0; i < 7; i++) {
  const { tab, close } = await browser.tab();
  first.push(await tab.evaluate("performance.getEntriesByName('first-picture')[0].startTime"));
  await close();
}
console.log(`first picture after opening: ${median(first).toFixed(0)} ms (${Math.min(...first).toFixed(0)} to ${Math.max(...first).toFixed(0)})`);
const { tab, close } = await browser.tab();
const settled = () => tab.waitForFunction("!workbench.state().opening && workbench.state().whole", null, { timeout: 60_000 });
for (const name of ["bouncing_ball.toml", "damper_with_buffer.toml", "gear_backlash.toml", "bead_column.toml", "pipe_supports.toml"]) {
  await tab.selectOption("#example", name);
  await settled();
  const times = [];
  for (let i = 0; i < 12; i++) {
    await tab.press("#text", "End");
    await tab.press("#text", "Space");
    await settled();
    times.push(await tab.evaluate("workbench.edit"));
  }
  console.log(`${name}: an edit shows after ${median(times).toFixed(1)} ms`);
}
/** @param {string} name @param {() => Promise<any>} what */
async function tellFrames(name, what) {
  const gaps = (await frames(tab, what)).sort((a, b) => a - b);
  console.log(`${name}: ${gaps.length} frames, half of them within ${gaps[gaps.length >> 1].toFixed(0)} ms, the longest ${gaps[gaps.length - 1].toFixed(0)} ms`);
}
await tab.fill("#text", RATTLE.text);
await tab.waitForFunction("workbench.run.machine.name === 'Rattle'");
await settled();
await tellFrames("a rattle is computed", async () => {
  await tab.fill("#length", RATTLE.until); await tab.press("#length", "Enter");
  await tab.waitForFunction(`workbench.run.length === ${RATTLE.until}`);
  await settled();
});
await tellFrames("a rattle plays, 6 s", () => tab.waitForTimeout(6000));
await tellFrames("a servo is computed", async () => { await tab.selectOption("#example", "servo.toml"); await tab.waitForTimeout(200); await settled(); });
await tellFrames("a servo plays, 6 s", () => tab.waitForTimeout(6000));
await tab.selectOption("#example", "damper_with_buffer.toml");
await settled();
await tab.click("#play");
const began = Date.now();
await tab.click("#studyFold > summary");
await tab.click("#compute");
await tab.waitForFunction("workbench.study.found.rising.length === 200 && workbench.study.found.falling.length === 200 && !workbench.study.running", null, { timeout: 300_000, polling: 50 });
console.log(`diagram of 200 values of damper_with_buffer, both directions, two workers: ${((Date.now() - began) / 1000).toFixed(1)} s`);
if (await tab.evaluate("document.querySelector('#kit').textContent.length > 0")) {
  const times = [];
  for (let i = 0; i < 5; i++) { await Promise.all([tab.waitForEvent("download"), tab.click('[data-take="fmu3"]')]); times.push(await tab.evaluate("workbench.packed")); }
  console.log(`an FMU is packed in ${median(times).toFixed(0)} ms`);
}
await close();
await browser.close();
