// The workbench in headless Chromium: node page.mjs <npm packages> <page> <folder for what is
// downloaded and shown> [name of a test].
import assert from "node:assert/strict";
import { mkdirSync, readFileSync } from "node:fs";
import { join } from "node:path";
import { frames, open } from "../../../explorer/page/test/browser.mjs";
import { INTERVALS, Thin } from "../src/thin.js";
import { RATTLE } from "./rattle.mjs";

const [packages, page, folder, only] = process.argv.slice(2);
mkdirSync(folder, { recursive: true });
const READY = "window.workbench && workbench.pictures > 0";
const browser = await open(packages, page, READY);
const axe = readFileSync(join(packages, "node_modules/axe-core/axe.min.js"), "utf8");

const opened = browser.tab;
/** A page with its studies unfolded. */
browser.tab = async (...given) => {
  const found = await opened(...given);
  await found.tab.evaluate("document.querySelectorAll('.fold').forEach((fold) => { fold.open = true; })");
  return found;
};
const text = (/** @type {any} */ tab) => tab.inputValue("#text");
/** Longest wait for a motion, ms. The hammer drill's takes 11 s alone, and more beside other tests. */
const LONGEST = 300_000;
const settled = (/** @type {any} */ tab) => tab.waitForFunction("!workbench.state().opening && !workbench.state().extending", null, { timeout: LONGEST });
const whole = (/** @type {any} */ tab) => tab.waitForFunction("workbench.state().whole", null, { timeout: LONGEST });
const pick = async (/** @type {any} */ tab, /** @type {string} */ name) => { await tab.selectOption("#example", name); await tab.waitForFunction("document.querySelector('#example').value !== ''"); await settled(tab); };
/** A page without response for longer than this is frozen, ms. */
const FROZEN = 1500;
/** Longest time of a frame, ms, and the part of frames to which it applies: other programs on the computer delay some. */
const FRAME = 50, SHARE = 0.9;
/** Longest time of any frame while much is drawn, ms: other programs may take most of it. Without thinned curves it is 4 s. */
const BLOCKED = 500;
/** Checks that the page responds while something is done. @param {any} tab @param {string} name @param {() => Promise<any>} what */
async function isSmooth(tab, name, what) {
  const gaps = (await frames(tab, what)).sort((a, b) => a - b), most = gaps[Math.floor(SHARE * gaps.length)], last = gaps[gaps.length - 1];
  console.log(`    ${name}: ${gaps.length} frames, ${100 * SHARE} % within ${most.toFixed(0)} ms, the longest ${last.toFixed(0)} ms`);
  assert.ok(most <= FRAME && last <= BLOCKED, `${name}: ${most} ms, ${last} ms`);
}
/** Parameters of the record in docs/fit.md (crates/command-line/tests/fit.rs). */
const MADE = { stiffness: 1e4, force: 1 };

/** @type {Record<string, () => Promise<void>>} */
const tests = {
  async "every machine of the gallery opens, moves and is drawn"() {
    const { tab, wrong, close } = await browser.tab();
    const names = await tab.$$eval("#example option", (/** @type {any[]} */ all) => all.map((o) => o.value).filter(Boolean));
    assert.ok(names.length >= 26, `${names.length}`);
    for (const name of names) {
      await pick(tab, name);
      await whole(tab);
      assert.ok(await tab.isHidden("#problems"), `${name}: ${await tab.textContent("#problems")}`);
      const found = await tab.evaluate(`(() => { const { run, scene } = workbench, at = (t) => Array.from(workbench.valuesAt(t)); const a = at(0.1 * run.length), b = at(0.37 * run.length);
        return { count: run.count, events: run.events.length, moved: a.some((x, i) => i > 7 && x !== b[i]) || at(0).some((x, i) => i > 7 && x !== b[i]), finite: run.rows.subarray(0, run.count * run.width).every(Number.isFinite), marks: scene.marks.length, numbers: document.querySelectorAll(".field").length, problem: run.problem }; })()`);
      assert.ok(found.count > 200 && found.moved && found.finite && found.marks > 100 && found.numbers > 0, `${name}: ${JSON.stringify(found)}`);
      assert.equal(found.problem, "", name);
    }
    assert.deepEqual(wrong, []);
    await close();
  },
  async "a new machine is small, moves, and leaves the text before it to be undone; studies are folded until asked"() {
    const { tab, wrong, close } = await opened();
    for (const id of ["compute", "fitBegin"]) assert.ok(await tab.isHidden(`#${id}`), id);
    await tab.click("#studyFold > summary");
    assert.ok(await tab.isVisible("#compute"));
    const before = await text(tab);
    await tab.click("#new");
    await tab.waitForFunction("workbench.run.machine?.name === 'Machine'");
    await whole(tab);
    assert.ok(await tab.isHidden("#problems"));
    assert.ok(await tab.evaluate("workbench.run.events.length > 5"));
    // A time with a unit is understood; another text is refused with its words.
    for (const [said, seconds] of [["1500 ms", 1.5], ["0,5", 0.5]]) {
      await tab.fill("#length", said);
      await tab.press("#length", "Enter");
      await tab.waitForFunction(`workbench.run.length === ${seconds}`);
    }
    await tab.fill("#length", "3 kg");
    await tab.press("#length", "Enter");
    assert.match(await tab.textContent("#status"), /“3 kg”: expected a time above 0, in s or with one of the units us, ms, s, min, h/);
    await tab.focus("#text");
    await tab.keyboard.press("Control+z");
    assert.equal(await text(tab), before);
    assert.deepEqual(wrong, []);
    await close();
  },
  async "errors stand at their lines in fifty broken files, and go"() {
    const { tab, wrong, close } = await browser.tab();
    let broken = 0;
    for (const name of ["damper_with_buffer.toml", "gear_backlash.toml", "two_blocks.toml", "percussion_drill.toml"]) {
      await pick(tab, name);
      const whole = await text(tab), lines = whole.split("\n");
      for (let i = 0; i < lines.length && broken < 60; i++) {
        const key = lines[i].match(/^(\w+)( *= *)(.*)$/);
        if (!key) continue;
        // An unknown key, and an invalid value.
        const worse = broken % 2 ? `${key[1]}${key[2]}"none of it"` : `${key[1]}x${key[2]}${key[3]}`;
        await tab.fill("#text", lines.with(i, worse).join("\n"));
        await settled(tab);
        const told = await tab.$$eval("#problems li", (/** @type {any[]} */ all) => all.map((li) => li.textContent));
        assert.ok(told.some((/** @type {string} */ words) => words.startsWith(`Line ${i + 1} `)), `${name}:${i + 1} ${worse}: ${told}`);
        assert.equal(await tab.getAttribute("#text", "aria-invalid"), "true");
        broken++;
      }
      await tab.fill("#text", whole);
      await settled(tab);
      assert.ok(await tab.isHidden("#problems"));
    }
    assert.ok(broken >= 50, `${broken}`);
    assert.deepEqual(wrong, []);
    await close();
  },
  async "a number is changed by field, unit and slider, and all else of the text stays"() {
    const { tab, wrong, close } = await browser.tab({}, "#example=damper_with_buffer");
    const before = await text(tab);
    await tab.fill("[id='n-stop.steel.gap']", "5");
    await tab.press("[id='n-stop.steel.gap']", "Enter");
    await tab.waitForFunction("document.querySelector('#text').value.includes('gap = \"5 mm\"')");
    assert.equal(await text(tab), before.replace('gap = "4 mm"', 'gap = "5 mm"'));
    await tab.fill("[id='n-stop.steel.gap']", "0.6 cm");
    await tab.press("[id='n-stop.steel.gap']", "Enter");
    await tab.waitForFunction("document.querySelector('#text').value.includes('gap = \"0.6 cm\"')");
    await settled(tab);
    await tab.focus("[aria-label='stop.steel.restitution, slider']");
    await tab.keyboard.press("ArrowLeft");
    await tab.waitForFunction("!document.querySelector('#text').value.includes('restitution = 0.7\\n')");
    await settled(tab);
    const after = await text(tab);
    assert.equal(after.split("\n").length, before.split("\n").length);
    assert.equal(after.replace(/gap = .*|restitution = .*/g, ""), before.replace(/gap = .*|restitution = .*/g, ""));
    await tab.fill("[id='n-stop.steel.restitution']", "7");
    await tab.press("[id='n-stop.steel.restitution']", "Enter");
    await tab.waitForSelector(".field.bad");
    assert.match(await tab.textContent(".field.bad .why"), /expected a number from 0 to 1/);
    // Undo and redo: typed text, numbers, and the example that replaced the text.
    await pick(tab, "gear_backlash.toml");
    await tab.focus("#text");
    const gears = await text(tab);
    await tab.keyboard.press("Control+z");
    assert.equal(await text(tab), after);
    await tab.keyboard.press("Control+z");
    assert.match(await text(tab), /restitution = 0.7\n/);
    await tab.keyboard.press("Control+y"); await tab.keyboard.press("Control+y");
    assert.equal(await text(tab), gears);
    await settled(tab);
    // A negative number keeps its unit.
    assert.match(gears, /"-937\.5 rpm"/);
    assert.ok((await tab.$$eval("#fields input[type=text]", (/** @type {any[]} */ all) => all.map((i) => i.value))).includes("-937.5"));
    assert.deepEqual(wrong, []);
    await close();
  },
  async "a link holds the file; one that is too long, or has records, is refused"() {
    const { tab, wrong, close } = await browser.tab({ permissions: ["clipboard-read", "clipboard-write"] }, "#example=gear_backlash");
    await tab.waitForFunction("location.hash.startsWith('#z=')");
    const first = await tab.evaluate("location.hash");
    await tab.fill("[id='n-body.pinion.inertia']", "0.0005");
    await tab.press("[id='n-body.pinion.inertia']", "Enter");
    await tab.waitForFunction((/** @type {string} */ first) => location.hash.startsWith("#z=") && location.hash !== first, first);
    await settled(tab);
    const [hash, written] = [await tab.evaluate("location.hash"), await text(tab)];
    const other = await browser.tab({}, hash);
    assert.equal(await text(other.tab), written);
    assert.deepEqual(other.wrong, []);
    await other.close();
    let noise = "";
    for (let i = 0, x = 1; i < 9000; i++) { x = (x * 48271) % 2147483647; noise += `# ${x.toString(36)}${i % 6 ? "" : "\n"}`; }
    await tab.fill("#text", `${written}\n${noise}`);
    await settled(tab);
    await tab.click("#copy");
    await tab.waitForFunction("/too long for a link/.test(document.querySelector('#status').textContent)");
    await pick(tab, "valve_train.toml");
    await tab.click("#copy");
    await tab.waitForFunction("/cannot contain records \\(cam_lift.csv\\)/.test(document.querySelector('#status').textContent)");
    // A link of an earlier version has no checksum and still opens.
    const old = await browser.tab({}, "#m=y0vMTVWwVVDyz0lR4opOyk-p1EuK5cpNLC4GihrqGXBFFxcUZeal62XHciWllpSnpuYBJaKV0ovyS_NSlHQUlJKUYrmKSzLT0vJS4ZoA");
    assert.equal(await text(old.tab), "name = \"Old\"\n[body.b]\nmass = 1.0\n[spring.k]\nbetween = [\"ground\", \"b\"]\nstiffness = 1.0\n");
    await old.close();
    assert.deepEqual(wrong, []);
    await close();
  },
  async "a damaged link says so and keeps the text; a reload keeps one's own text and records"() {
    const { tab, wrong, close } = await browser.tab({}, "#example=gear_backlash");
    await tab.waitForFunction("location.hash.startsWith('#z=')");
    const hash = await tab.evaluate("location.hash"), before = await text(tab), middle = Math.floor(hash.length / 2);
    const changed = hash.slice(0, middle) + (hash[middle] === "A" ? "B" : "A") + hash.slice(middle + 1);
    const isTold = () => tab.waitForFunction("/link is incomplete or changed/.test(document.querySelector('#status').textContent)");
    for (const damaged of [changed, hash.slice(0, -9), "#z=", "#example=nothing", "#x=1"]) {
      await tab.evaluate("document.querySelector('#status').textContent = ''");
      await tab.evaluate((/** @type {string} */ to) => { location.hash = to; }, damaged);
      await isTold();
      assert.equal(await text(tab), before, damaged);
      // The address is unchanged, so that a reload shows the same.
      await tab.waitForTimeout(500);
      assert.equal(await tab.evaluate("location.hash"), damaged);
    }
    await tab.reload(); await tab.waitForFunction(READY);
    await isTold();
    // A text with a record is not put into a link.
    const own = `name = "Own"\n[body.m]\nmass = 1.0\n[load.f]\non = "m"\ntable = "own.csv"\n`;
    await tab.evaluate((/** @type {string} */ own) => workbench.receive([new File([own], "own.toml"), new File(["time,force\n0,0\n1,2\n"], "own.csv")]), own);
    await tab.waitForFunction("workbench.run.machine.name === 'Own'");
    await tab.waitForFunction("location.hash === ''");
    await tab.reload(); await tab.waitForFunction(READY);
    await settled(tab);
    assert.equal(await text(tab), own);
    assert.ok(await tab.isHidden("#problems"), await tab.textContent("#problems"));
    assert.deepEqual(wrong, []);
    await close();
  },
  async "files and records are taken, tables and pictures are given"() {
    const { tab, wrong, close } = await browser.tab();
    const machine = 'name = "Own"\n[body.a]\nmass = 1.0\n[body.t]\nmotion = { table = "lift.csv" }\n[spring.s]\nbetween = ["t", "a"]\nstiffness = 100.0\n';
    await tab.setInputFiles("#files", [{ name: "own.toml", mimeType: "application/toml", buffer: Buffer.from(machine) }]);
    await tab.waitForFunction("/lift.csv is missing: drop it on this page/.test(document.querySelector('#problems').textContent)");
    await tab.setInputFiles("#files", [{ name: "lift.csv", mimeType: "text/csv", buffer: Buffer.from("0,0\n0.5,0.01\n1,0\n") }]);
    await tab.waitForFunction("workbench.run.machine.name === 'Own' && document.querySelector('#problems').hidden", null, { timeout: 10_000 }).catch(async (/** @type {Error} */ e) => { throw new Error(`${e.message}: ${await tab.textContent("#problems")}`); });
    await pick(tab, "bouncing_ball.toml");
    await whole(tab);
    for (const [what, name, check] of /** @type {[string, string, RegExp][]} */ ([["file", "BouncingBall.toml", /^#|^name/m], ["run", "run.csv", /^time,ball\.s,/], ["events", "events.csv", /^time,kind,element,value,stops,impulse\n.*impact,stop\./], ["sketch-svg", "BouncingBall-sketch.svg", /<svg.*>ball</s], ["history-svg", "BouncingBall-histories.svg", /<svg/], ["sketch-png", "BouncingBall-sketch.png", /PNG/]])) {
      const [download] = await Promise.all([tab.waitForEvent("download"), tab.click(`[data-take="${what}"]`)]);
      assert.equal(download.suggestedFilename(), name);
      await download.saveAs(join(folder, name));
      assert.match(readFileSync(join(folder, name), "latin1"), check, what);
    }
    assert.deepEqual(wrong, []);
    await close();
  },
  async "hostile files answer, and the page never freezes"() {
    const { tab, wrong, close } = await browser.tab();
    const send = (/** @type {string} */ name, /** @type {Buffer} */ buffer) => tab.evaluate(({ name, size, head, unit }) => { const text = head + unit.repeat(Math.ceil((size - head.length) / unit.length)); window.made = new File([text], name); }, { name, ...JSON.parse(buffer.toString()) });
    const made = (/** @type {string} */ head, /** @type {string} */ unit, /** @type {number} */ size) => Buffer.from(JSON.stringify({ head, unit, size }));
    let bodies = 'name = "Many"\n';
    for (let i = 0; i < 100_000; i++) bodies += `body.b${i.toString(36)}.mass=1\n`;
    let chain = 'name = "Chain"\n';
    for (let i = 0; i < 6000; i++) chain += `body.b${i} = { mass = 1 }\nspring.s${i} = { between = ["ground", "b${i}"], stiffness = 1 }\n`;
    const cases = /** @type {[string, () => Promise<any>, RegExp][]} */ ([
      ["100,000 bodies", () => tab.evaluate((/** @type {string} */ t) => { window.made = new File([t], "many.toml"); }, bodies), /longer than 4 s|there are 100000; expected/],
      ["6,000 bodies on springs", () => tab.evaluate((/** @type {string} */ t) => { window.made = new File([t], "chain.toml"); }, chain), /longer than 4 s|broke off/],
      ["deep arrays", () => send("deep.toml", made('name = "Deep"\nx = ', "[", 200_000)), /Line 2|recursion|longer than|broke off/],
      ["deep keys", () => send("keys.toml", made('name = "Deep"\na', ".a", 200_000)), /Line 2|longer than|broke off/],
      ["64 MiB", () => send("large.toml", made('name = "Large"\n', "# comment\n", 64 * 2 ** 20)), /bytes: expected/],
      ["bytes", () => send("bytes.toml", made("", "\u0000\uffff", 1000)), /Line 1/],
    ]);
    for (const [name, what, answer] of cases) {
      await what();
      const began = Date.now(), gap = Math.max(...await frames(tab, async () => { await tab.evaluate("workbench.receive([window.made])"); await settled(tab); }));
      const told = await tab.textContent("#problems");
      console.log(`    ${name}: still for ${gap.toFixed(0)} ms, answered after ${Date.now() - began} ms: ${told.slice(0, 90)}`);
      assert.match(told, answer, name);
      assert.ok(gap < FROZEN, `${name}: ${gap}`);
      await pick(tab, "bouncing_ball.toml");
      assert.ok(await tab.isHidden("#problems"), `${name}: ${await tab.textContent("#problems")}`);
    }
    assert.deepEqual(wrong, []);
    await close();
  },
  async "a diagram is drawn, its point is played, and a study is stopped by a click"() {
    const { tab, wrong, close } = await browser.tab({}, "#example=damper_with_buffer");
    await tab.selectOption("#values", "60");
    await tab.click("#compute");
    await tab.waitForFunction("/60 .*values|120 values in/.test(document.querySelector('#studyWords').textContent) && !workbench.study.running", null, { timeout: 60_000 });
    const { rising, falling } = await tab.evaluate("workbench.study.found");
    assert.equal(rising.length, 60); assert.equal(falling.length, 60);
    assert.ok(rising.filter((/** @type {any} */ f) => f.values.length && f.words).length > 50);
    const [x, y] = await tab.evaluate("(() => { const { study } = workbench, f = study.found.rising[20], [k] = workbench.shownIn(study.ofUnit, Math.max(...study.frame.y.map(Math.abs))); return [study.frame.px(workbench.valueAt(f.index) * study.factor), study.frame.py(f.values[0] * k)]; })()");
    const before = await text(tab);
    await tab.click("#diagram", { position: { x, y } });
    await tab.waitForFunction((/** @type {string} */ t) => /** @type {any} */ (document.querySelector("#text")).value !== t, before);
    await settled(tab);
    assert.match(await tab.textContent("#studyWords"), /load\.shaker\.frequency = .* Hz: \d+T|chaotic|quasi/);
    // The motion is shown, with its time counted from its start.
    const played = () => tab.evaluate("({ first: workbench.run.rows[0], last: workbench.run.rows[(workbench.run.count - 1) * workbench.run.width], events: workbench.run.events.map((e) => e.time), length: workbench.run.length, problem: workbench.run.problem })");
    await whole(tab);
    const { first, last, events, length } = await played();
    assert.equal(first, 0); assert.ok(Math.abs(last - length) < 1e-9 && events.length > 5 && events.every((/** @type {number} */ t) => t >= 0 && t <= length), `${first} ${last} ${events.slice(0, 3)}`);
    // With the keyboard, too.
    const clicked = await text(tab);
    await tab.focus("#diagram");
    for (const key of ["ArrowRight", "ArrowRight", "ArrowUp", "Enter"]) await tab.keyboard.press(key);
    await tab.waitForFunction((/** @type {string} */ t) => /** @type {any} */ (document.querySelector("#text")).value !== t, clicked);
    await settled(tab);
    await tab.selectOption("#values", "600");
    await tab.click("#compute");
    await tab.waitForFunction("workbench.study.found.rising.length > 3");
    await tab.click("#halt");
    assert.match(await tab.textContent("#studyWords"), /Stopped/);
    assert.ok(await tab.isHidden("#halt"));
    await pick(tab, "impact_pair.toml");
    await tab.click("#orbits");
    await tab.waitForFunction("!workbench.study.running && workbench.study.branches.length > 0", null, { timeout: 120_000 });
    assert.ok(await tab.evaluate("workbench.study.branches.some((b) => b.length > 3 && b.some((p) => p[2]))"));
    // Plays a point of a branch, for a machine with a prescribed body, whose start is not in the start file.
    await tab.waitForFunction("workbench.study.frame !== null");
    const [px, py] = await tab.evaluate("(() => { const { study } = workbench, b = study.branches.find((b) => b.length > 9), p = b[5], [k] = workbench.shownIn(study.ofUnit, Math.max(...study.frame.y.map(Math.abs))); return [study.frame.px(p[0] * study.factor), study.frame.py(p[1] * k)]; })()");
    await tab.click("#diagram", { position: { x: px, y: py } });
    await tab.waitForFunction("/periodic orbit, (un)?stable/.test(document.querySelector('#studyWords').textContent)");
    await settled(tab); await whole(tab);
    assert.ok(await tab.isHidden("#problems"), await tab.textContent("#problems"));
    const orbit = await played();
    assert.ok(orbit.problem === "" && orbit.events.length > 3, JSON.stringify(orbit));
    // Impulses of turning bodies are in N·m·s.
    await tab.fill("#text", `name = "Turn"\n[body.r]\ninertia = 1.0\nstart = { v = 1.0 }\n[stop.s]\nbetween = ["ground", "r"]\ngap = 0.1\nrestitution = 0.5\n`);
    await tab.waitForFunction("workbench.run.machine.name === 'Turn'");
    await settled(tab); await tab.click("#again");
    for (let i = 0; i < 20 && !/impulse/.test(await tab.textContent("#status") ?? ""); i++) await tab.click("#next");
    assert.match(await tab.textContent("#status"), /impulse [\d.e-]+ N·m·s/);
    // Another machine does not keep the picture.
    await pick(tab, "bouncing_ball.toml");
    assert.equal(await tab.evaluate("workbench.study.parameter"), "");
    assert.deepEqual(wrong, []);
    await close();
  },
  async "a search of orbits ends within its time, also where one motion takes longer"() {
    const { tab, wrong, close } = await browser.tab({}, "#example=impact_pair");
    /** Chosen time, and time limit of the page, s. */
    const [CHOSEN, MOST] = [2, 6];
    // 2e18 impacts a second between two walls one nanometre away.
    const walls = ["f", "g"].map((name) => `[stop.${name}]\nbetween = ${name === "f" ? '["ground", "a"]' : '["a", "ground"]'}\ngap = 1e-9\nrestitution = 1\n`).join("");
    await tab.fill("#text", `name = "Z"\n[body.a]\nmass = 1\nstart = { v = 1e9 }\n${walls}[load.l]\non = "a"\namplitude = 1.0\nfrequency = 1.0\n`);
    await tab.waitForFunction("workbench.run.machine.name === 'Z'", null, { timeout: 20_000 });
    await tab.evaluate((/** @type {number} */ s) => { const option = /** @type {HTMLOptionElement} */ (document.querySelector("#orbitTime option")); option.value = String(s); option.selected = true; }, CHOSEN);
    const began = Date.now();
    await tab.click("#orbits");
    await tab.waitForFunction("!workbench.study.running && /No branch was found|branches? of periodic/.test(document.querySelector('#studyWords').textContent)", null, { timeout: 60_000 });
    assert.ok(Date.now() - began < 1000 * MOST, `${Date.now() - began} ms`);
    assert.deepEqual(wrong, []);
    await close();
  },
  async "completion offers tables, keys, names and units, by keys and pointer"() {
    const { tab, wrong, close } = await browser.tab({}, "#example=bouncing_ball");
    const offers = (/** @type {string} */ wanted) => tab.waitForFunction((/** @type {string} */ w) => { const list = document.querySelector("#offers"); return !list.hidden && [...list.querySelectorAll("li")].map((li) => li.textContent).join() === w; }, wanted, { timeout: 10_000 }).catch(async () => assert.fail(`${wanted}: ${await tab.textContent("#offers")} ${await text(tab)}`));
    const type = (/** @type {string} */ keys) => tab.keyboard.type(keys, { delay: 5 });
    const own = 'name = "Own"\n[body.ball]\nmass = 1.0\n[body.bat]\nmass = 1.0\n[spring.s]\nbetween = ["ground", "ball"]\nstiffness = 1.0\n';
    await tab.fill("#text", own);
    await settled(tab);
    await tab.focus("#text");
    await tab.keyboard.press("Control+End");
    await type("[st");
    await offers("stop");
    assert.equal(await tab.getAttribute("#text", "aria-activedescendant"), "offer-0");
    await tab.keyboard.press("Tab");
    await type(".floor]");
    // Enter inserts a new line if nothing is selected.
    await tab.keyboard.press("Enter");
    await type("betw");
    await offers("between");
    await tab.keyboard.press("Tab");
    await type('["gro');
    await offers("ground");
    await tab.keyboard.press("Tab");
    await type(', "ba');
    await offers("ball,bat");
    await tab.keyboard.press("ArrowDown");
    await tab.keyboard.press("Enter");
    await type("]\nga");
    await offers("gap");
    await tab.keyboard.press("Tab");
    await tab.waitForFunction("/expected a number in m, or with a unit: m, cm/.test(document.querySelector('#offersWords').textContent)");
    await type("4 m");
    await offers("m,mm");
    await tab.click("#offers li:nth-child(2)");
    await type("\nre");
    await offers("restitution");
    await tab.keyboard.press("Escape");
    assert.ok(await tab.isHidden("#offers"));
    await type("st");
    await offers("restitution");
    await tab.evaluate(axe);
    const { violations } = await tab.evaluate("axe.run()");
    assert.deepEqual(violations.map((/** @type {any} */ v) => `${v.id}: ${v.nodes.map((/** @type {any} */ n) => n.html).slice(0, 3)}`), []);
    await tab.keyboard.press("Tab");
    await type("0.5\n");
    await settled(tab);
    assert.equal(await text(tab), `${own}[stop.floor]\nbetween = ["ground", "bat"]\ngap = "4 mm"\nrestitution = 0.5\n`);
    assert.ok(await tab.isHidden("#problems"), await tab.textContent("#problems"));
    // Requested at an empty line: keys that are not used yet; Escape closes, undo removes an accepted offer.
    await tab.keyboard.press("Control+ ");
    await offers("arms,stiffness,damping,law,exponent,dissipation");
    await tab.keyboard.press("Enter");
    assert.match(await text(tab), /\narms = $/);
    await tab.keyboard.press("Control+z");
    assert.match(await text(tab), /0\.5\n$/);
    assert.deepEqual(wrong, []);
    await close();
  },
  async "30,000 events, 134,000 rows and 72,000 dots leave the page free, and are drawn to the end"() {
    const { tab, wrong, close } = await browser.tab();
    const drawn = async () => { await whole(tab); await tab.waitForFunction("!workbench.state().growing"); };
    await isSmooth(tab, "a rattle", async () => {
      await tab.fill("#text", RATTLE.text);
      await tab.waitForFunction("workbench.run.machine.name === 'Rattle'");
      await settled(tab);
      await tab.fill("#length", RATTLE.until); await tab.press("#length", "Enter");
      await tab.waitForFunction(`workbench.run.length === ${RATTLE.until}`);
      await drawn();
      await tab.waitForTimeout(2000);
    });
    assert.ok(await tab.evaluate("workbench.run.events.length") >= RATTLE.events);
    await isSmooth(tab, "a servo", async () => { await pick(tab, "servo.toml"); await drawn(); });
    await isSmooth(tab, "its table", async () => {
      const [download] = await Promise.all([tab.waitForEvent("download"), tab.click('[data-take="run"]')]);
      await download.saveAs(join(folder, "servo.csv"));
    });
    assert.equal(readFileSync(join(folder, "servo.csv"), "utf8").split("\n").length, await tab.evaluate("workbench.run.count + 2"));
    // Another run that begins meanwhile is not mixed with this one.
    await tab.evaluate("document.querySelector('[data-take=\\'run\\']').click(); document.querySelector('#new').click()");
    await tab.waitForFunction("/Another run has begun/.test(document.querySelector('#taken').textContent)");
    await isSmooth(tab, "a diagram", async () => {
      await tab.evaluate(() => {
        const { study } = /** @type {any} */ (window).workbench, list = () => Array.from({ length: 600 }, (_, index) => ({ index, start: null, words: "", values: Array.from({ length: 60 }, (_, k) => Math.sin(index + k * k)) }));
        Object.assign(study, { parameter: "a", range: [1, 2], of: "b", count: 600, begun: study.begun + 1, shown: "diagram", found: { rising: list(), falling: list() } });
        study.changed();
      });
      await tab.waitForTimeout(2000);
      await tab.waitForFunction("!workbench.state().growing");
    });
    assert.deepEqual(wrong, []);
    await close();
  },
  async "invariant: a thinned curve has the extremes of every interval, and few points"() {
    const thin = new Thin(0, 2), points = /** @type {[number, number][]} */ ([]);
    for (let i = 0, x = 1; i < 60_000; i++) { x = (x * 48271) % 2147483647; points.push([2 * i / 60_000, x]); thin.add(...points[i]); }
    const indices = thin.indices();
    assert.ok(indices.length <= 2 * INTERVALS + 2 && indices.every((k, i) => !i || k >= indices[i - 1]), `${indices.length}`);
    assert.deepEqual([indices[0], indices[indices.length - 1]], [0, 59_999]);
    const ends = (/** @type {[number, number][]} */ some) => {
      /** @type {Map<number, [number, number]>} */
      const found = new Map();
      for (const [t, y] of some) { const k = Math.floor(t * INTERVALS / 2), [low, high] = found.get(k) ?? [y, y]; found.set(k, [Math.min(low, y), Math.max(high, y)]); }
      return [...found];
    };
    assert.deepEqual(ends(indices.map((i) => points[i])), ends(points));
    // A curve of few points is drawn as it is.
    const few = new Thin(0, 1);
    for (let i = 0; i < 1500; i++) few.add(i / 1500, i % 7);
    assert.equal(few.indices().length, 1500);
  },
  async "a plane of classes is drawn with its legend, played and stopped by a click"() {
    const { tab, wrong, close } = await browser.tab({}, "#example=damper_with_buffer");
    const computed = async (/** @type {string} */ across, /** @type {string} */ upwards) => {
      for (const [ids, name, [from, to]] of /** @type {[string[], string, string[]][]} */ ([[["parameter", "from", "to"], across, RANGES[across]], [["second", "from2", "to2"], upwards, RANGES[upwards]]])) {
        await tab.selectOption(`#${ids[0]}`, name);
        await tab.fill(`#${ids[1]}`, from); await tab.fill(`#${ids[2]}`, to);
      }
      await tab.click("#classes");
      await tab.waitForFunction("!workbench.study.running && /144 motions in/.test(document.querySelector('#studyWords').textContent)", null, { timeout: 240_000 });
      return tab.evaluate("workbench.plane");
    };
    /** @type {Record<string, string[]>} */
    const RANGES = { "load.shaker.frequency": ["6", "13"], "stop.steel.restitution": ["0.3", "0.9"] };
    await tab.selectOption("#cells", "12");
    // The plane with exchanged axes is the same plane.
    const other = await computed("stop.steel.restitution", "load.shaker.frequency");
    const { rows, frame, x, y } = await computed("load.shaker.frequency", "stop.steel.restitution");
    assert.ok(rows.length === 12 && rows.every((/** @type {any[]} */ row) => row.length === 12));
    rows.forEach((/** @type {any[]} */ row, /** @type {number} */ j) => row.forEach((cell, i) => assert.deepEqual(cell, other.rows[i][j], `${i}, ${j}`)));
    const classes = new Set(rows.flat().map((/** @type {any[]} */ cell) => cell[0]));
    console.log(`    classes: ${[...classes].join(", ")}`);
    assert.ok(classes.size >= 3 && classes.has("1T"), [...classes].join());
    const legend = await tab.textContent("#legend");
    assert.equal(/undecided/.test(legend ?? ""), classes.has("not settled"), legend);
    // The colours are those of `vibro`, whose steps of lightness a test of the command line checks.
    const source = readFileSync(new URL("../../../../crates/command-line/src/studies/isoperiodic.rs", import.meta.url), "utf8").split("const IMPACTS")[0];
    const of = new Set([...source.matchAll(/Colour\((\d+), (\d+), (\d+)\)/g)].map(([, ...parts]) => `rgb(${parts.join(", ")})`).concat("rgb(0, 0, 0)", "rgb(255, 255, 255)"));
    const colours = await tab.$$eval("#legend span", (/** @type {any[]} */ all) => all.map((span) => getComputedStyle(span).backgroundColor));
    assert.ok(colours.every((/** @type {string} */ colour) => of.has(colour)) && new Set(colours).size === colours.length, colours.join());
    const kinds = await tab.$$eval("#legend li", (/** @type {any[]} */ all) => all.map((li) => li.textContent));
    // The fractions of all classes in the legend add up to the whole plane, each rounded to a tenth.
    const shares = kinds.map((/** @type {string} */ words) => Number(words.match(/([\d.]+) %$/)?.[1]));
    assert.ok(Math.abs(shares.reduce((/** @type {number} */ a, /** @type {number} */ b) => a + b, 0) - 100) <= 0.05 * kinds.length + 1e-9, kinds.join());
    // A click writes the values of its cell into the text.
    const at = (/** @type {number} */ i, /** @type {number} */ j) => ({ x: frame.box.left + (i + 0.5) * (frame.box.right - frame.box.left) / 12, y: frame.box.bottom - (j + 0.5) * (frame.box.bottom - frame.box.top) / 12 });
    await tab.click("#diagram", { position: at(3, 8) });
    const value = (/** @type {any} */ axis, /** @type {number} */ i) => axis.range[0] + (axis.range[1] - axis.range[0]) * i / 11;
    // The machine opens again some time after the click.
    for (const [axis, i] of [[x, 3], [y, 8]]) await tab.waitForFunction(`workbench.run.machine.numbers.some((n) => n.name === "${axis.name}" && Math.abs(n.exact / ${value(axis, i)} - 1) < 1e-7)`, null, { timeout: 60_000 });
    await settled(tab);
    const numbers = await tab.evaluate("Object.fromEntries(workbench.run.machine.numbers.map((n) => [n.name, n.exact]))");
    for (const [axis, i] of [[x, 3], [y, 8]]) assert.ok(Math.abs(numbers[axis.name] / value(axis, i) - 1) < 1e-7, `${axis.name}: ${numbers[axis.name]} ${value(axis, i)}`);
    await tab.waitForFunction("/frequency = .* Hz, stop.steel.restitution = .*: /.test(document.querySelector('#studyWords').textContent)");
    await tab.focus("#diagram");
    await tab.keyboard.press("ArrowRight");
    assert.deepEqual(await tab.evaluate("workbench.plane.at"), [4, 8]);
    await tab.selectOption("#cells", "96");
    await tab.click("#classes");
    await tab.waitForFunction("workbench.plane.rows.some(Boolean)", null, { timeout: 60_000 });
    assert.match(await tab.textContent("#studyWords"), /about \d+ s left/);
    await tab.click("#halt");
    assert.match(await tab.textContent("#studyWords"), /Stopped/);
    assert.ok(await tab.isHidden("#halt"));
    await tab.selectOption("#second", await tab.inputValue("#parameter"));
    await tab.click("#classes");
    assert.match(await tab.textContent("#studyWords"), /expected two different numbers/);
    assert.deepEqual(wrong, []);
    await close();
  },
  async "a dropped record is fitted, and its numbers are taken over"() {
    const { tab, wrong, close } = await browser.tab();
    const guide = readFileSync(new URL("../../../../docs/fit.md", import.meta.url), "utf8");
    const [machine, record] = ["toml drive.toml", "csv record.csv"].map((kind) => guide.split(`\`\`\`${kind}\n`)[1].split("```")[0]);
    await tab.fill("#text", machine);
    await settled(tab);
    await tab.setInputFiles("#files", [{ name: "record.csv", mimeType: "text/csv", buffer: Buffer.from(record) }]);
    await tab.waitForFunction("/record.csv: 41 samples of slide.s, from 0 to 0.2 s/.test(document.querySelector('#fitWords').textContent)");
    assert.ok(await tab.isDisabled("#fitBegin"));
    // A table of another form is reported, and nothing is lost.
    await tab.setInputFiles("#files", [{ name: "european.csv", mimeType: "text/csv", buffer: Buffer.from("time;slide.s\n0,1;0,5\n") }]);
    await tab.waitForFunction("/european.csv: .*line 2.*0,1.* has a decimal comma; expected a decimal point/.test(document.querySelector('#fitWords').textContent)");
    await tab.setInputFiles("#files", [{ name: "picture.png", mimeType: "image/png", buffer: Buffer.from("\x89PNG") }]);
    await tab.waitForFunction("/picture.png: expected a machine/.test(document.querySelector('#status').textContent)");
    assert.equal(await text(tab), machine);
    await tab.setInputFiles("#files", [{ name: "record.csv", mimeType: "text/csv", buffer: Buffer.from(record) }]);
    await tab.waitForFunction("/record.csv: 41 samples/.test(document.querySelector('#fitWords').textContent)");
    for (const name of ["spring.mount.stiffness", "friction.guide.force"]) await tab.check(`#freeNumbers input[value='${name}']`);
    await tab.click("#free summary");
    await tab.click("#fitBegin");
    await tab.waitForFunction("workbench.fit.found", null, { timeout: 60_000 }).catch(async (/** @type {Error} */ e) => { throw new Error(`${e.message}: ${await tab.textContent("#fitWords")}`); });
    const { verdict, values, columns } = await tab.evaluate("workbench.fit.found");
    assert.equal(verdict, "fits", await tab.textContent("#fitWords"));
    // Within four standard errors of the parameters used for the record (docs/fit.md).
    for (const [i, truth] of [[0, MADE.stiffness], [1, MADE.force]]) assert.ok(Math.abs(values[i].value - truth) < 4 * values[i].error && values[i].error < 0.05 * truth, JSON.stringify(values[i]));
    assert.equal(columns[0].motion.length, 41);
    assert.match(await tab.textContent("#fitTable"), /spring\.mount\.stiffness.*kN\/m8/);
    await tab.click("#fitTake");
    await tab.waitForFunction("/2 numbers are now in the text/.test(document.querySelector('#fitWords').textContent)");
    await settled(tab);
    const own = await tab.evaluate("Object.fromEntries(workbench.run.machine.numbers.map((n) => [n.name, n.exact]))");
    for (const { name, value } of values) assert.ok(Math.abs(own[name] / value - 1) < 1e-8, name);
    assert.ok((await text(tab)).includes('mass = "1 kg"'));
    // A record of another machine is refused with a message; a click stops a fit.
    await tab.setInputFiles("#files", [{ name: "other.csv", mimeType: "text/csv", buffer: Buffer.from("time,slide.s,box.s\n0,0,0\n0.1,0,0\n") }]);
    await tab.click("#fitBegin");
    await tab.waitForFunction("/box/.test(document.querySelector('#fitWords').textContent) && !workbench.fit.helper");
    await tab.setInputFiles("#files", [{ name: "bad.csv", mimeType: "text/csv", buffer: Buffer.from("time,slide.s\n0,0\n0.1,none\n") }]);
    await tab.waitForFunction("/line 3.*`none` is not a number/.test(document.querySelector('#fitWords').textContent)");
    const long = ["time,slide.s", ...Array.from({ length: 4000 }, (_, i) => `${i / 20},${(1e-3 * Math.sin(i * i)).toFixed(7)}`)].join("\n");
    await tab.setInputFiles("#files", [{ name: "long.csv", mimeType: "text/csv", buffer: Buffer.from(long) }]);
    await tab.waitForFunction("/long.csv: 4000 samples/.test(document.querySelector('#fitWords').textContent)");
    await tab.click("#fitBegin");
    // Stopped in the page itself: the fit may end before an external click arrives.
    await tab.waitForFunction("/^\\d+ steps in/.test(document.querySelector('#fitWords').textContent) && (document.querySelector('#fitHalt').click(), true)", null, { polling: 20 });
    assert.match(await tab.textContent("#fitWords"), /Stopped/);
    assert.ok(await tab.isHidden("#fitHalt"));
    assert.deepEqual(wrong, []);
    await close();
  },
  async "the keyboard alone plays, scrubs and edits; reduced motion starts paused"() {
    const { tab, wrong, close } = await browser.tab({ reducedMotion: "reduce" });
    await whole(tab);
    assert.equal(await tab.evaluate("workbench.run.at"), 0, "paused");
    const reached = new Set();
    for (let i = 0; i < 60; i++) { await tab.keyboard.press("Tab"); reached.add(await tab.evaluate("document.activeElement.id || document.activeElement.className || document.activeElement.tagName")); }
    for (const id of ["scroll", "timeline", "play", "next", "again", "pace", "length", "sound", "example", "open", "copy", "text"]) assert.ok(reached.has(id), `${id} by Tab: ${[...reached]}`);
    await tab.focus("#timeline");
    await tab.keyboard.press("PageUp");
    assert.ok(await tab.evaluate("workbench.run.at > 0"));
    await tab.keyboard.press("Home");
    await tab.keyboard.press("n");
    await tab.waitForFunction("/at .* s/.test(document.querySelector('#status').textContent)");
    await tab.keyboard.press(" ");
    await tab.waitForFunction("workbench.run.at > 0.02");
    assert.deepEqual(wrong, []);
    await close();
  },
  async "no part of a sketch is beyond the edges of its canvas, also in motion"() {
    const { tab, wrong, close } = await browser.tab({ viewport: { width: 360, height: 780 } });
    for (const name of ["bead_column.toml", "bouncing_ball.toml", "two_blocks.toml"]) {
      await pick(tab, name);
      await whole(tab);
      for (const part of [0, 0.1, 0.3, 1]) {
        await tab.evaluate(`workbench.run.at = ${part} * workbench.run.length`);
        await tab.waitForTimeout(400);
        const ink = await tab.evaluate(() => {
          const canvas = /** @type {any} */ (document.querySelector("#sketch")), { width: w, height: h } = canvas;
          const has = (/** @type {number[]} */ ...box) => canvas.getContext("2d").getImageData(...box).data.some((/** @type {number} */ x) => x);
          return { top: has(0, 0, w, 1), bottom: has(0, h - 1, w, 1), left: has(0, 0, 1, h), right: has(w - 1, 0, 1, h), all: has(0, 0, w, h) };
        });
        assert.deepEqual(ink, { top: false, bottom: false, left: false, right: false, all: true }, `${name} at ${part}`);
      }
    }
    assert.deepEqual(wrong, []);
    await close();
  },
  async "axe finds nothing, wide, narrow and dark; pictures are taken"() {
    for (const [name, options, hash] of /** @type {[string, any, string][]} */ ([["wide", { viewport: { width: 1440, height: 1780 } }, "#example=damper_with_buffer"], ["narrow", { viewport: { width: 360, height: 780 }, hasTouch: true, isMobile: true, deviceScaleFactor: 2 }, "#example=gear_backlash"], ["dark", { viewport: { width: 1280, height: 900 }, colorScheme: "dark" }, "#example=two_blocks"]])) {
      const { tab, wrong, close } = await browser.tab(options, hash);
      await whole(tab);
      if (name === "wide") { await tab.click("#compute"); await tab.waitForFunction("workbench.study.found.rising.length === 200 && !workbench.study.running", null, { timeout: 120_000 }); }
      await tab.evaluate("workbench.run.at = 0.4 * workbench.run.length");
      await tab.waitForTimeout(700);
      await tab.screenshot({ path: join(folder, `workbench-${name}.png`) });
      assert.ok(await tab.evaluate("document.documentElement.scrollWidth <= innerWidth"), `${name}: nothing stands out to the side`);
      await tab.evaluate(axe);
      const { violations } = await tab.evaluate("axe.run()");
      assert.deepEqual(violations.map((/** @type {any} */ v) => `${v.id}: ${v.nodes.map((/** @type {any} */ n) => n.html).slice(0, 3)}`), [], name);
      assert.deepEqual(wrong, []);
      await close();
    }
  },
};

let failed = 0;
for (const [name, test] of Object.entries(tests)) {
  if (only && !name.includes(only)) continue;
  const began = Date.now();
  try { await test(); console.log(`ok   ${name} (${((Date.now() - began) / 1000).toFixed(1)} s)`); } catch (error) { failed++; console.log(`FAIL ${name}\n${/** @type {Error} */ (error).stack}`); }
}
await browser.close();
process.exit(failed ? 1 : 0);
