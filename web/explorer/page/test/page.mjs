// The page in headless Chromium: node page.mjs <npm packages> <page> <folder for what is downloaded and shown>.
import assert from "node:assert/strict";
import { mkdirSync, readFileSync } from "node:fs";
import { join } from "node:path";
import { open } from "./browser.mjs";

const [packages, page, folder] = process.argv.slice(2);
mkdirSync(folder, { recursive: true });
const browser = await open(packages, page);

/** What is on a canvas: pixels that are not clear, and how many colours. @param {any} tab @param {string} id */
const drawn = (tab, id) => tab.evaluate((/** @type {string} */ id) => {
  const canvas = /** @type {HTMLCanvasElement} */ (document.getElementById(id));
  const data = /** @type {CanvasRenderingContext2D} */ (canvas.getContext("2d")).getImageData(0, 0, canvas.width, canvas.height).data;
  const colours = new Map();
  let filled = 0;
  for (let i = 0; i < data.length; i += 4) if (data[i + 3] > 40) { filled++; const c = `${data[i]},${data[i + 1]},${data[i + 2]}`; colours.set(c, (colours.get(c) ?? 0) + 1); }
  return { part: filled / (data.length / 4), colours: colours.size, of: (Object.fromEntries([...colours].filter(([, n]) => n > 50))) };
}, id);
const state = (/** @type {any} */ tab) => tab.evaluate("JSON.parse(JSON.stringify(explorer.state))");
const time = (/** @type {any} */ tab) => tab.evaluate("explorer.motion.now[0]");
const finished = (/** @type {any} */ tab) => tab.waitForFunction("explorer.diagram.finished === 2", null, { timeout: 60_000 });

/** The damper of docs/design-a-damper.md, in an engineer's units. */
const DAMPER = "#form=si&box.m=12kg&box.k=48kN/m&box.c=30&block.m=1.2&stop.gap=15mm&stop.restitution=0.6&drive.amplitude=75&drive.frequency=10Hz&coupling.k=0&secondary.m=1&secondary.k=1000&secondary.c=1";

/** @type {Record<string, () => Promise<void>>} */
const tests = {
  async "opens from a file without a request or an error, and moves"() {
    const { tab, wrong, close } = await browser.tab();
    await finished(tab);
    const before = await time(tab);
    await tab.waitForTimeout(400);
    assert.ok(await time(tab) > before, "the machine moves");
    assert.match(await tab.textContent("#status"), /repeats in every drive period: one impact at each stop; .*its own mirror image/);
    assert.match(await tab.textContent(".shown"), /default set.*reconstruction/s);
    // The bodies have the colours of all pictures (vibro's palette).
    const { of } = await drawn(tab, "machine");
    for (const colour of ["0,70,150", "200,75,0", "20,160,115"]) assert.ok(of[colour] > 500, `${colour} in the machine`);
    assert.deepEqual(wrong, []);
    await close();
  },
  async "every preset draws"() {
    const { tab, wrong, close } = await browser.tab();
    const presets = await tab.$$eval("#preset option", (/** @type {any[]} */ all) => all.map((o) => o.value).filter(Boolean));
    assert.ok(presets.length >= 12);
    for (const preset of presets) {
      await tab.selectOption("#preset", preset);
      await finished(tab);
      for (const [id, least, colours] of [["machine", 0.06, 20], ["history", 0.004, 20], ["portrait", 0.02, 20], ["poincare", 0.01, 3], ["diagram", 0.01, 12], ["response", 0.005, 10], ["bars", 0.1, 3]]) {
        const found = await drawn(tab, id);
        assert.ok(found.part > least && found.colours >= colours, `${preset}: ${id} ${JSON.stringify({ part: found.part, colours: found.colours })}`);
      }
      const columns = await tab.evaluate("explorer.diagram.found.rising.filter((f) => f && f.length > 6).length / explorer.diagram.columns");
      assert.ok(columns > 0.9, `${preset}: ${columns} of the columns`);
      // Speeds have both signs, one for each stop: both are in the picture.
      if (preset === "plastic") assert.ok(await tab.evaluate("explorer.diagram.band[1] > 2.5 && explorer.diagram.band[0] < -2.5"), "both stops' speeds");
      if (preset === "chatter") assert.match(await tab.textContent("#status"), /13 impacts at each stop.*rests at a stop/);
      assert.ok(!(await tab.getAttribute("#status", "class")).includes("bad"), `${preset}: ${await tab.textContent("#status")}`);
    }
    assert.deepEqual(wrong, []);
    await close();
  },
  async "the wasm's closed form is the motion's amplitude"() {
    const { tab, close } = await browser.tab();
    await finished(tab);
    // Second method: the settled motion against the exact orbit's curve at the same value of the force.
    const [found, curve] = await tab.evaluate("[explorer.motion.amplitudes, Array.from(explorer.curves.exact)]");
    let best = null;
    for (let i = 0; i + 5 < curve.length; i += 5) if (curve[i] <= 1.5 && curve[i + 5] > 1.5 && curve[i + 4]) best = [1, 2, 3].map((b) => curve[i + b] + (curve[i + 5 + b] - curve[i + b]) * (1.5 - curve[i]) / (curve[i + 5] - curve[i]));
    assert.ok(best, "a stable piece");
    // A sampled maximum is up to 0.1 % too small, and so is a chord of the curve.
    best.forEach((a, b) => assert.ok(Math.abs(a - found[b]) < 0.004, `${a} ${found[b]}`));
    await close();
  },
  async "a dragged body is the start state"() {
    const { tab, wrong, close } = await browser.tab();
    await tab.click("#play");
    const before = await state(tab);
    const box = await tab.locator("#machine").boundingBox();
    // The block is found by its colour: the middle of its pixels.
    const middle = await tab.evaluate(() => {
      const canvas = /** @type {HTMLCanvasElement} */ (document.getElementById("machine")), g = canvas.getContext("2d"), d = g.getImageData(0, 0, canvas.width, canvas.height).data;
      let [n, x, y] = [0, 0, 0];
      for (let i = 0; i < d.length; i += 4) if (d[i] === 200 && d[i + 1] === 75 && d[i + 2] === 0 && (i / 4 / canvas.width | 0) < 0.8 * canvas.height) { n++; x += i / 4 % canvas.width; y += i / 4 / canvas.width | 0; }
      return [x / n / devicePixelRatio, y / n / devicePixelRatio];
    });
    await tab.mouse.move(box.x + middle[0], box.y + middle[1]);
    await tab.mouse.down();
    await tab.mouse.move(box.x + middle[0] + 10, box.y + middle[1], { steps: 4 });
    await tab.mouse.up();
    const after = await state(tab);
    assert.notDeepEqual(after.start, before.start);
    assert.deepEqual(after.start.slice(3), [0, 0, 0]);
    assert.equal(await time(tab), 0);
    assert.ok(Math.abs(after.start[1] - after.start[0]) <= 1);
    assert.deepEqual(wrong, []);
    await close();
  },
  async "a click in the diagram plays that attractor, a box computes anew, back returns"() {
    const { tab, wrong, close } = await browser.tab();
    await finished(tab);
    const box = await tab.locator("#diagram").boundingBox();
    await tab.mouse.click(box.x + box.width * 0.78, box.y + box.height * 0.25);
    const clicked = await state(tab);
    const f10 = clicked.set.find((/** @type {any[]} */ s) => s[0] === "f10")[1];
    assert.ok(f10 > 3.5 && f10 < 4.3, String(f10));
    assert.equal(await tab.inputValue("#field-f10"), String(f10));
    assert.ok(clicked.start.some((/** @type {number} */ x) => x !== 0 && x !== 1), "the start is the attractor's");
    await tab.waitForTimeout(300);
    await tab.mouse.move(box.x + box.width * 0.4, box.y + 40);
    await tab.mouse.down();
    await tab.mouse.move(box.x + box.width * 0.6, box.y + 150, { steps: 3 });
    await tab.mouse.up();
    const closer = await state(tab);
    assert.ok(closer.range[0] > 1.5 && closer.range[1] < 4 && closer.band, JSON.stringify(closer.range));
    await finished(tab);
    assert.ok((await drawn(tab, "diagram")).part > 0.01);
    await tab.goBack();
    assert.deepEqual((await state(tab)).range, clicked.range);
    assert.deepEqual(wrong, []);
    await close();
  },
  async "a link holds the whole view"() {
    const { tab, close } = await browser.tab();
    await tab.selectOption("#preset", "coexisting");
    await tab.fill("#field-kappa", "0.7");
    await tab.selectOption("#section", "impact");
    await tab.selectOption("#shownOrdinate", "w");
    await tab.waitForTimeout(400);
    const before = await state(tab), hash = await tab.evaluate("location.hash");
    await close();
    const again = await browser.tab({}, hash);
    assert.deepEqual(await state(again.tab), before);
    assert.equal(await again.tab.inputValue("#field-kappa"), "0.7");
    assert.equal(await again.tab.evaluate("explorer.toHash()"), hash.slice(1));
    assert.deepEqual(again.wrong, []);
    await again.close();
    // A machine in SI is restored bit for bit.
    const si = await browser.tab({}, "#form=si&box.m=12&box.k=48000&stop.gap=0.002&block.m=1.1&drive.amplitude=14&drive.frequency=63.5");
    const values = await si.tab.evaluate("explorer.state.set"), link = await si.tab.evaluate("explorer.toHash()");
    await si.close();
    const twice = await browser.tab({}, `#${link}`);
    assert.deepEqual(await twice.tab.evaluate("explorer.state.set"), values);
    await twice.close();
  },
  async "a value that is refused is told beside its field, and the machine stays"() {
    const { tab, wrong, close } = await browser.tab();
    await tab.fill("#field-kappa", "2");
    assert.equal(await tab.textContent("#field-kappa-why"), "kappa = 2: expected 0 ≤ kappa ≤ 1");
    assert.equal(await tab.getAttribute("#field-kappa", "aria-invalid"), "true");
    assert.deepEqual((await state(tab)).set, []);
    await tab.fill("#field-kappa", "abc");
    assert.match(await tab.textContent("#field-kappa-why"), /kappa = `abc` is not a number: expected/);
    await tab.fill("#field-kappa", "nan");
    assert.match(await tab.textContent("#field-kappa-why"), /kappa = `nan` is not a number: expected/);
    await tab.fill("#field-kappa", "0.6");
    assert.ok(await tab.isHidden("#field-kappa-why"));
    assert.deepEqual((await state(tab)).set, [["kappa", 0.6]]);
    assert.deepEqual(wrong, []);
    await close();
    const linked = await browser.tab({}, "#kappa=3");
    assert.match(await linked.tab.textContent("#status"), /kappa = 3: expected/);
    await linked.close();
    const unreadable = await browser.tab({}, "#box.m=heavy");
    assert.match(await unreadable.tab.textContent("#status"), /box.m = `heavy` is not a number: expected/);
    await unreadable.close();
    const outside = await browser.tab({}, "#start=0:3:0:0:0:0");
    assert.match(await outside.tab.textContent("#status"), /could not be read in full: .*stop/);
    await outside.close();
  },
  async "a value with a unit is understood, and a unit of something else refused with what is allowed"() {
    const { tab, wrong, close } = await browser.tab({}, DAMPER);
    const value = async (/** @type {string} */ name) => (await state(tab)).set.find((/** @type {any[]} */ s) => s[0] === name)?.[1];
    const shown = async (/** @type {string} */ id) => [await tab.inputValue(`#${id}`), await tab.textContent(`.field:has(#${id}) .unit`)];
    assert.deepEqual([await value("stop.gap"), await value("box.k")], [0.015, 48000]);
    assert.deepEqual([await shown("field-stop-gap"), await shown("field-box-k"), await shown("field-drive-frequency")], [["15", "mm"], ["48", "kN/m"], ["10", "Hz"]]);
    await tab.fill("#field-stop-gap", "50 mm");
    assert.equal(await value("stop.gap"), 0.05);
    // A number without a unit is in the unit next to the field.
    await tab.fill("#field-stop-gap", "40");
    assert.equal(await value("stop.gap"), 0.04);
    await tab.fill("#field-stop-gap", "0,03m");
    assert.equal(await value("stop.gap"), 0.03);
    for (const [text, words] of [["5 kg", /stop\.gap: `kg` is not one of its units; expected one of m, cm, mm/], ["", /stop\.gap = `` is not a number: expected/], ["mm", /is not a number/], ["1e999", /not a number|expected/]]) {
      await tab.fill("#field-stop-gap", String(text));
      assert.match(await tab.textContent("#field-stop-gap-why"), /** @type {RegExp} */ (words));
      assert.equal(await value("stop.gap"), 0.03);
    }
    await tab.fill("#field-stop-gap", "15mm");
    await tab.fill("#field-drive-frequency", "10.65Hz");
    assert.ok(Math.abs(await value("drive.frequency") - 2 * Math.PI * 10.65) < 1e-12);
    assert.deepEqual(await shown("field-drive-frequency"), ["10.65Hz", "Hz"]);
    await tab.focus("#machine");
    assert.deepEqual(await shown("field-drive-frequency"), ["10.65", "Hz"]);
    assert.doesNotMatch(await tab.evaluate("document.body.innerText"), /NaN|undefined/);
    const link = await tab.evaluate("explorer.toHash()"), before = await state(tab);
    assert.deepEqual(wrong, []);
    await close();
    const again = await browser.tab({}, `#${link}`);
    assert.deepEqual(await state(again.tab), before);
    assert.equal(await again.tab.evaluate("explorer.toHash()"), link);
    await again.close();
  },
  async "sliders follow the machine at hand, with round numbers at their ends"() {
    const { tab, wrong, close } = await browser.tab({}, DAMPER);
    const places = () => tab.$$eval(".field", (/** @type {any[]} */ rows) => rows.map((row) => [row.querySelector("input[type=text]").id, row.querySelector("input[type=text]").value, Number(row.querySelector("input[type=range]").value) / 400]));
    for (const form of ["si", "groups"]) {
      await tab.locator(`input[name=form][value=${form}]`).evaluate((/** @type {any} */ e) => e.click());
      for (const [id, value, place] of await places()) if (Number(value) !== 0) assert.ok(place > 0.02 && place < 0.98, `${form}, ${id} = ${value} at ${place}`);
    }
    await tab.locator("input[name=form][value=si]").evaluate((/** @type {any} */ e) => e.click());
    // A machine of another size has other sliders and another range of the diagram.
    await tab.fill("#field-box-m", "24000 kg");
    await tab.fill("#field-box-k", "96 MN/m");
    await tab.focus("#machine");
    for (const [id, value, place] of (await places()).filter(([id]) => /box-[mk]/.test(id))) assert.ok(place > 0.2 && place < 0.8, `${id} = ${value} at ${place}`);
    await tab.locator("#field-box-m ~ input[type=range]").evaluate((/** @type {any} */ e) => { e.value = e.max; e.dispatchEvent(new Event("input")); });
    assert.equal((await state(tab)).set.find((/** @type {any[]} */ s) => s[0] === "box.m")[1], 50000);
    const { range, along } = await state(tab), here = await tab.evaluate("Number(document.getElementById('diagram').getAttribute('aria-valuenow'))");
    assert.ok(along === "f10" && here >= range[0] && here <= range[1], `${here} in ${range}`);
    assert.deepEqual(wrong, []);
    await close();
  },
  async "what nothing couples is not drawn, and SI has its units at the axes"() {
    const { tab, wrong, close } = await browser.tab({ viewport: { width: 1440, height: 1000 } }, DAMPER);
    await finished(tab);
    await tab.waitForTimeout(2000);
    for (const id of ["machine", "history", "response"]) {
      const { of } = await drawn(tab, id);
      assert.ok(!of["20,160,115"], `${id} without the oscillator: ${of["20,160,115"]}`);
      if (id === "machine") assert.ok(of["200,75,0"] > 500 && of["0,70,150"] > 500);
    }
    assert.ok(await tab.isHidden("#keyOscillator"));
    await tab.screenshot({ path: join(folder, "damper-light.png"), fullPage: true });
    for (const [figure, words] of [["history", ["x (mm)", "w (mm)", "t (s)"]], ["portrait", ["w (mm)", "w′ (m/s)"]], ["diagram", ["x₂ (mm)"]], ["machine", ["ticks at ±15 mm"]]]) {
      await tab.selectOption("#figure", figure);
      const [download] = await Promise.all([tab.waitForEvent("download"), tab.click("[data-export=svg]")]);
      const path = join(folder, `damper-${figure}.svg`);
      await download.saveAs(path);
      const svg = readFileSync(path).toString();
      for (const word of words) assert.ok(svg.includes(word), `${figure}: ${word}`);
    }
    // With a coupling the oscillator is shown again.
    await tab.fill("#field-coupling-k", "2 kN/m");
    await tab.waitForTimeout(300);
    assert.ok((await drawn(tab, "machine")).of["20,160,115"] > 500);
    assert.ok(await tab.isVisible("#keyOscillator"));
    assert.deepEqual(wrong, []);
    await close();
  },
  async "the steps lead through the machine, and a drag stays in its step"() {
    const { tab, wrong, close } = await browser.tab();
    for (const [i, id] of ["default", "figure-15-pair", "figure-15-long", "figure-15-chaos", "coexisting", "chatter"].entries()) {
      await tab.locator("#tour a").nth(i).click();
      await tab.waitForFunction(`explorer.state.preset === "${id}"`);
      assert.equal(await tab.locator("#tour a[aria-current]").count(), 1, id);
      assert.ok((await tab.textContent("#story")).length > 40, id);
      await tab.waitForFunction("document.querySelector('#status strong')", null, { timeout: 20_000 });
      const told = await tab.textContent("#status");
      assert.match(told, [/every drive period/, /every drive period/, /after 2 drive periods/, /Chaos.*exponent 0\.[01]/, /after 4 drive periods/, /rests at a stop/][i]);
    }
    await tab.locator("#tour a").nth(0).click();
    const story = await tab.textContent("#story");
    await tab.focus("#machine");
    await tab.keyboard.press("2");
    await tab.keyboard.press("ArrowLeft");
    assert.equal(await tab.textContent("#story"), story);
    assert.match(await tab.evaluate("explorer.toHash()"), /start=/);
    assert.deepEqual(wrong, []);
    await close();
  },
  async "a newer request ends the search for exact orbits"() {
    const { tab, wrong, close } = await browser.tab({}, "#preset=figure-16");
    await tab.waitForFunction("explorer.diagram.searched");
    const before = await tab.evaluate("explorer.diagram.id");
    await tab.fill("#field-kappa", "0.7");
    // In the frame of the new diagram: later its own search may have ended.
    const begun = await tab.waitForFunction(`explorer.diagram.id > ${before} && [explorer.diagram.branches.length]`);
    assert.deepEqual(await begun.jsonValue(), [0]);
    // The closed forms of the new value do not wait for the search.
    await tab.waitForFunction("explorer.curves.exact.length > 0 && explorer.diagram.searched");
    await tab.waitForFunction("explorer.diagram.branches.length > 0", null, { timeout: 60_000 });
    assert.equal(await tab.evaluate("explorer.diagram.searched"), "");
    assert.deepEqual(wrong, []);
    await close();
  },
  async "closed form: fixed points lie on the slow invariant manifold, stable where the paper has them"() {
    const { tab, wrong, close } = await browser.tab({}, "#preset=figure-9");
    // Figure 9 of the paper: P₂ is stable at 1.2 and 1.5, not at 0.6 and 2.5.
    for (const [f10, stable] of [[1.2, 1], [1.5, 1], [0.6, 0], [2.5, 0]]) {
      await tab.fill("#field-f10", String(f10));
      const rows = await tab.evaluate("Array.from(explorer.manifoldRows().rows)"), rho = 2 / Math.PI * 0.25 / 1.75;
      for (let i = 0; i < rows.length; i += 4) assert.ok(Math.abs(Math.hypot(rows[i] - 1, rho * rows[i]) - rows[i + 1]) < 1e-12, `${rows.slice(i, i + 4)}`);
      const upper = rows.length - 4;
      assert.deepEqual(rows.slice(upper + 2), [stable, 2], `P₂ at ${f10}`);
    }
    assert.deepEqual(wrong, []);
    await close();
  },
  async "every control and picture has a name for those who hear the page"() {
    const { tab, close } = await browser.tab();
    const client = await tab.context().newCDPSession(tab);
    const { nodes } = await client.send("Accessibility.getFullAXTree");
    const named = nodes.filter((/** @type {any} */ n) => !n.ignored && ["button", "slider", "checkbox", "combobox", "textbox", "radio", "link", "image", "img", "figure", "navigation", "toolbar"].includes(n.role?.value));
    assert.ok(named.length > 50, String(named.length));
    for (const node of named) if (node.role.value !== "figure") assert.ok(node.name?.value?.trim(), `${node.role.value} without a name`);
    await close();
  },
  async "with reduced motion nothing moves until asked"() {
    const { tab, wrong, close } = await browser.tab({ reducedMotion: "reduce" });
    await tab.waitForTimeout(300);
    assert.equal(await time(tab), 0);
    await tab.click("#impact");
    assert.ok(await time(tab) > 0);
    assert.deepEqual(wrong, []);
    await close();
  },
  async "keys alone reach everything, and the focus shows"() {
    const { tab, wrong, close } = await browser.tab();
    const reached = new Set();
    for (let i = 0; i < 70; i++) {
      await tab.keyboard.press("Tab");
      const [id, outline] = await tab.evaluate(() => { const e = document.activeElement, s = getComputedStyle(e.matches("[type=radio]") ? e.nextElementSibling : e); return [e.id || e.getAttribute("aria-label") || e.textContent.slice(0, 20), s.outlineStyle !== "none" && parseFloat(s.outlineWidth) >= 1]; });
      if (id && !(await tab.evaluate("document.activeElement === document.body"))) assert.ok(outline, `no outline on ${id}`);
      reached.add(id);
    }
    for (const id of ["machine", "play", "impact", "settle", "again", "pace", "sound", "preset", "field-kappa", "section", "along", "diagram", "orbits", "sharper", "whole", "theory", "figure"]) assert.ok(reached.has(id), `${id} in ${[...reached]}`);
    await tab.focus("#machine");
    await tab.keyboard.press("2");
    await tab.keyboard.press("ArrowRight");
    assert.equal((await state(tab)).start[4], 0, "the block is held");
    await tab.keyboard.press("n");
    assert.ok(await tab.evaluate("explorer.motion.impacts.length") > 0);
    await tab.focus("#diagram");
    await tab.keyboard.press("ArrowRight");
    assert.ok(Number(await tab.getAttribute("#diagram", "aria-valuenow")) > 1.5);
    await tab.keyboard.press("+");
    const closer = (await state(tab)).range;
    assert.ok(closer[0] > 0.5 && closer[1] < 5);
    await tab.keyboard.press("Backspace");
    await tab.waitForFunction("explorer.state.range[0] === 0.5");
    assert.deepEqual(wrong, []);
    await close();
  },
  async "fits a window of 360 pixels, light and dark"() {
    for (const colorScheme of ["light", "dark"]) {
      const { tab, wrong, close } = await browser.tab({ viewport: { width: 360, height: 740 }, colorScheme, hasTouch: true });
      await finished(tab);
      assert.ok(await tab.evaluate("document.documentElement.scrollWidth") <= 360);
      await tab.screenshot({ path: join(folder, `narrow-${colorScheme}.png`), fullPage: true });
      // Contrast of text with its background, WCAG 2.2, 1.4.3.
      const pale = await tab.evaluate(() => {
        const light = (/** @type {string} */ c) => { const [r, g, b] = c.match(/[\d.]+/g).map((v) => Number(v) / 255).map((v) => (v <= 0.04045 ? v / 12.92 : ((v + 0.055) / 1.055) ** 2.4)); return 0.2126 * r + 0.7152 * g + 0.0722 * b + 0.05; };
        const ground = (/** @type {Element} */ e) => { const c = getComputedStyle(e).backgroundColor; return c !== "rgba(0, 0, 0, 0)" ? c : e.parentElement ? ground(e.parentElement) : "rgb(255, 255, 255)"; };
        return [...document.querySelectorAll("p, label, button, span, small, i, b, h1, figcaption, option, output")].filter((e) => e.checkVisibility() && e.textContent.trim()).filter((e) => { const [a, b] = [light(getComputedStyle(e).color), light(ground(e))]; return Math.max(a, b) / Math.min(a, b) < 4.5; }).map((e) => `${e.tagName} ${e.textContent.slice(0, 30)}`);
      });
      assert.deepEqual(pale, [], colorScheme);
      assert.deepEqual(wrong, []);
      await close();
      const wide = await browser.tab({ colorScheme, viewport: { width: 1440, height: 1000 } }, "#preset=figure-16");
      await finished(wide.tab);
      await wide.tab.waitForFunction("explorer.diagram.branches.length > 0", null, { timeout: 60_000 });
      await wide.tab.waitForTimeout(500);
      await wide.tab.screenshot({ path: join(folder, `orbits-${colorScheme}.png`), fullPage: true });
      await wide.tab.goto(`${(await wide.tab.url()).split("#")[0]}#preset=figure-15-chaos&over=f10:0.5:5`);
      await finished(wide.tab);
      await wide.tab.waitForTimeout(3000);
      for (const id of ["settle", "play", "impact"]) { await wide.tab.click(`#${id}`); await wide.tab.waitForTimeout(id === "play" ? 4000 : 200); if (id === "play") await wide.tab.click("#play"); }
      await wide.tab.waitForTimeout(300);
      await wide.tab.screenshot({ path: join(folder, `wide-${colorScheme}.png`) });
      await wide.close();
    }
  },
  async "without WebAssembly it says so"() {
    const { tab, close } = await browser.tab({}, "", "delete globalThis.WebAssembly");
    assert.match(await tab.textContent("#broken"), /no WebAssembly/);
    assert.ok(await tab.isVisible("#broken"));
    for (const id of ["main", "tour"]) assert.ok(await tab.isHidden(`#${id}`), id);
    await close();
  },
  async "everything can be taken along"() {
    // A separate tab for each figure: Chromium holds back one of about twenty downloads from one page within two seconds.
    for (const figure of ["diagram", "history", "portrait", "poincare", "response", "machine"]) {
      const { tab, wrong, close } = await browser.tab({}, "#f10=2.2");
      await finished(tab);
      const get = async (/** @type {string} */ kind) => {
        const [download] = await Promise.all([tab.waitForEvent("download"), tab.click(`[data-export=${kind}]`)]);
        const path = join(folder, download.suggestedFilename());
        await download.saveAs(path);
        return readFileSync(path);
      };
      await tab.selectOption("#figure", figure);
      assert.ok((await get("png")).length > 4000, figure);
      const svg = (await get("svg")).toString();
      assert.ok(svg.startsWith("<svg") && !/NaN|undefined|\[object/.test(svg) && svg.split("<path").length > 8, figure);
      const rows = (await get("csv")).toString().trim().split("\n");
      assert.ok(rows.length > 5 && rows[0].includes("reconstruction"), figure);
      assert.match((await get("toml")).toString(), /\[si\]\nbox.m = 1.0/);
      assert.match((await get("fmpy")).toString(), /"drive.amplitude": 0.22/);
      assert.deepEqual(wrong, []);
      await close();
    }
  },
};

let failed = 0;
const wanted = process.argv[5];
for (const [name, test] of Object.entries(tests)) {
  if (wanted && !name.includes(wanted)) continue;
  const begin = Date.now();
  try { await test(); console.log(`ok      ${name} (${Date.now() - begin} ms)`); } catch (error) { failed++; console.log(`FAILED  ${name}\n${error.stack}`); }
}
await browser.close();
process.exit(failed ? 1 : 0);
