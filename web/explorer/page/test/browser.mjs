// Chromium with the page open, for the tests and measurements.
import { createRequire } from "node:module";
import { join, resolve } from "node:path";
import { pathToFileURL } from "node:url";

/** Times between the frames of a page while something is done, ms. @param {any} tab @param {() => Promise<any>} what @returns {Promise<number[]>} */
export async function frames(tab, what) {
  await tab.evaluate("window.gaps = []; { let before = performance.now(); const look = () => { const now = performance.now(); gaps.push(now - before); before = now; if (window.gaps) requestAnimationFrame(look); }; const { gaps } = window; requestAnimationFrame(look); }");
  await what();
  return tab.evaluate("(() => { const { gaps } = window; window.gaps = null; return gaps; })()");
}

/** @param {string} packages folder of the npm packages @param {string} page @param {string} [ready] what is true once a page is */
export async function open(packages, page, ready = "window.explorer && window.explorer.diagram.id > 0") {
  const { chromium } = createRequire(join(resolve(packages), "package.json"))("playwright-core");
  const names = process.env.CHROMIUM ? [process.env.CHROMIUM] : ["/usr/bin/chromium", "/usr/bin/chromium-browser", "/usr/bin/google-chrome"];
  let browser;
  for (const executablePath of names) {
    try { browser = await chromium.launch({ executablePath, args: ["--no-sandbox"] }); break; } catch { /* the next one */ }
  }
  if (!browser) throw new Error(`none of ${names.join(", ")} runs: install Chromium (Debian: apt install chromium) or name it in CHROMIUM`);
  const address = pathToFileURL(resolve(page)).href;
  /** A page with a list of what went wrong in it. @param {any} options @param {string} hash @param {string} [before] */
  async function tab(options = {}, hash = "", before = "") {
    const context = await browser.newContext({ viewport: { width: 1280, height: 900 }, acceptDownloads: true, ...options });
    const tab = await context.newPage();
    /** @type {string[]} */
    const wrong = [];
    // The tests read canvases back, which triggers a warning of Chromium.
    tab.on("console", (/** @type {any} */ m) => { if (["error", "warning"].includes(m.type()) && !m.text().includes("willReadFrequently")) wrong.push(`console: ${m.text()}`); });
    tab.on("pageerror", (/** @type {Error} */ e) => wrong.push(`error: ${e.message}`));
    tab.on("request", (/** @type {any} */ r) => { if (!r.url().startsWith(address) && !/^(blob|data):/.test(r.url())) wrong.push(`request: ${r.url()}`); });
    if (before) await tab.addInitScript(before);
    await tab.goto(address + hash);
    if (!before) await tab.waitForFunction(ready);
    return { tab, wrong, close: () => context.close() };
  }
  return { tab, close: () => browser.close() };
}
