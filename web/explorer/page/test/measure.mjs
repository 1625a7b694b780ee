// Size of the page, and times in headless Chromium: node measure.mjs <npm packages> <page>.
import { statSync } from "node:fs";
import { open } from "./browser.mjs";

const [packages, page] = process.argv.slice(2);
const browser = await open(packages, page);
const median = (/** @type {number[]} */ all) => [...all].sort((a, b) => a - b)[all.length >> 1];
const ms = (/** @type {number} */ x) => `${x.toFixed(1)} ms`;

console.log(`page: ${(statSync(page).size / 1000).toFixed(0)} kB`);
const first = [];
for (let i = 0; i < 5; i++) {
  const { tab, close } = await browser.tab();
  first.push(await tab.evaluate("performance.getEntriesByName('first-picture')[0].startTime"));
  await close();
}
console.log(`first picture after opening: ${ms(median(first))} (median of ${first.length}; ${first.map((x) => x.toFixed(0)).join(", ")})`);

const { tab, close } = await browser.tab();
await tab.waitForFunction("explorer.diagram.finished === 2", null, { timeout: 60_000 });
const slider = await tab.evaluate(async () => {
  const input = /** @type {HTMLInputElement} */ (document.querySelector("#field-f10").parentElement.querySelector("input[type=range]"));
  const frame = () => new Promise(requestAnimationFrame), [change, picture] = [[], []];
  for (let i = 0; i < 100; i++) {
    await frame();
    input.value = String(100 + 2 * i);
    const begin = performance.now();
    input.dispatchEvent(new Event("input"));
    change.push(window.explorer.changes());
    picture.push(await new Promise((done) => requestAnimationFrame(() => setTimeout(() => done(performance.now() - begin), 0))));
  }
  return { change, picture };
});
const most = (/** @type {number[]} */ all) => [...all].sort((a, b) => a - b)[Math.floor(all.length * 0.95)];
console.log(`slider: new motion and its portrait computed in ${ms(median(slider.change))} (95 %: ${ms(most(slider.change))}); to the end of the next frame ${ms(median(slider.picture))} (95 %: ${ms(most(slider.picture))})`);
const diagram = await tab.evaluate(async () => {
  const explorer = window.explorer, begin = performance.now();
  document.getElementById("whole").click();
  let frames = 0, coarse = 0;
  while (explorer.diagram.finished < 2) {
    await new Promise(requestAnimationFrame);
    frames++;
    if (!coarse && explorer.diagram.strides.rising.every((i) => i >= 0)) coarse = performance.now() - begin;
  }
  const time = performance.now() - begin;
  return { time, coarse, rate: 1000 * frames / time, columns: explorer.diagram.columns };
});
console.log(`diagram of ${diagram.columns} values, both directions, with exponents: coarse after ${ms(diagram.coarse)}, whole after ${ms(diagram.time)}; ${diagram.rate.toFixed(0)} frames a second meanwhile`);
await close();
await browser.close();
