// The workbench: its parts, the clock, and events of mouse, touch and keys.
import { readout, readTheme, Surface } from "../../../explorer/page/src/plot.js";
import { enable, tick } from "../../../explorer/page/src/sound.js";
import * as completion from "./completion.js";
import * as fits from "./fit.js";
import * as editor from "./editor.js";
import { begin as compile, Helper, Refused } from "./helper.js";
import { bytesIn } from "../../../explorer/page/src/packed.js";
import { fromHash, LONGEST, toHash } from "./link.js";
import * as numbers from "./numbers.js";
import { chosen, choose, drawEnergy, drawHistories, drawPortrait, drawTimeline, shownIn } from "./panels.js";
import { begin, columnOf, eventsBetween, isWhole, run, take, valuesAt } from "./run.js";
import { draw as drawSketch, fade, hold, isFurther, look, places, scene, sizeIn, tagOf } from "./scene.js";
import * as studies from "./studies.js";
import { plane } from "./plane.js";
import { study, valueAt } from "./study.js";
import { beginFrame, isGrowing } from "./thin.js";
import { eventsCsv, png, runCsv, save, svg } from "./take.js";

const element = (/** @type {string} */ id) => /** @type {HTMLElement} */ (document.getElementById(id));
const input = (/** @type {string} */ id) => /** @type {HTMLInputElement} */ (document.getElementById(id));
const select = (/** @type {string} */ id) => /** @type {HTMLSelectElement} */ (document.getElementById(id));
const calm = matchMedia("(prefers-reduced-motion: reduce)");
/** Time limit for reading a machine or computing a piece of motion, ms. */
const PATIENCE = 4000;
/** Units of time, s. @type {Record<string, number>} */
const TIMES = { us: 1e-6, ms: 1e-3, s: 1, min: 60, h: 3600 };
/** A time with or without a unit, in s; null for another text or a time that is not above 0. @param {string} text */
function seconds(text) {
  const [, number, unit] = text.trim().match(/^([\d.,]+(?:e[+-]?\d+)?) *([a-z]*)$/i) ?? [];
  const found = Number((number ?? "").replace(",", ".")) * (TIMES[unit || "s"] ?? NaN);
  return found > 0 && Number.isFinite(found) ? found : null;
}
/** The machine of the button New. */
const SMALL = `name = "Machine"
gravity = "9.81 m/s2"

[body.box]
mass = "1 kg"
gravity = -1.0                     # s points up; 1 lets it point down, and without it the box feels no gravity
start = { s = "50 mm" }

[stop.floor]
between = ["box", "ground"]
gap = 0.0
restitution = 0.8
`;
/** Largest text, letters: the limit of an editor in a page. */
const LARGEST = 2_000_000;

/** @type {Helper} */
let helper;
/** @type {Helper | null} */
let packer = null;
/** @type {Record<"sketch" | "timeline" | "history" | "portrait" | "energy" | "diagram" | "fitted", Surface>} */
let on;
/** @type {Map<string, string>} */
const gallery = new Map(), records = new Map();
/** @type {Uint8Array | null} */
let kit = null;
/** The user's last own text, to which the list of examples can return. */
let mine = "";
let playing = true, dirty = true, last = 0, panelsAt = 0, alive = false, start = "", length = /** @type {number | null} */ (null);
const { text } = editor;
/** Whether the address has a link that could not be read: it is then left unchanged. */
let misled = false;
/** Makes the text the user's own instead of an example. */
const becomesOwn = () => { select("example").value = ""; mine = text(); misled = false; };
const machineFile = () => ({ text: text(), names: [...records.keys()], texts: [...records.values()] });

/** @param {string} words @param {boolean} [bad] */
function say(words, bad = false) {
  element("status").textContent = words;
  element("status").classList.toggle("bad", bad);
}

/** Message in place of the page. @param {string} words */
function broken(words) {
  element("broken").hidden = false; element("broken").textContent = words; element("main").hidden = true;
}

async function boot() {
  if (typeof WebAssembly !== "object" || typeof CompressionStream !== "function") {
    return broken("This browser has no WebAssembly (or no CompressionStream), which this page computes with. Browsers since 2023 have both: Chrome 103, Firefox 113, Safari 16.4. The command line vibro does the same without a browser.");
  }
  try { await compile(); } catch (error) {
    return broken(`WebAssembly could not be started: ${/** @type {Error} */ (error).message}. The command line vibro does the same without a browser.`);
  }
  helper = new Helper();
  theme();
  on = { sketch: new Surface("sketch"), timeline: new Surface("timeline"), history: new Surface("history"), portrait: new Surface("portrait"), energy: new Surface("energy"), diagram: new Surface("diagram"), fitted: new Surface("fitted") };
  for (const [name, content] of await helper.ask("examples")) gallery.set(name, content);
  const title = (/** @type {string} */ name) => name.replace(/\.toml$/, "").replaceAll("_", " ");
  select("example").replaceChildren(new Option("own machine", ""), ...[...gallery.keys()].filter((n) => n.endsWith(".toml")).map((n) => new Option(title(n), n)));
  playing = !calm.matches;
  showPlaying(); showPace();
  const packed = bytesIn("kit");
  if (packed.length) kit = packed;
  showKit();
  listen();
  await adoptLink();
  requestAnimationFrame(frame);
  performance.mark("first-picture");
  // The packing worker is started only if there is something to pack.
  if (kit) setTimeout(() => { packer ??= new Helper(); }, 1000);
}

const theme = () => readTheme(["body", "spark-text", "error"]);

/** The machine in the address: a file or an example. Throws if it is damaged. */
async function linked() {
  const { hash } = location;
  if (!hash || hash === "#" || document.getElementById(hash.slice(1))) return null;
  const example = hash.match(/^#example=([\w.%-]+)$/)?.[1];
  if (example === undefined) {
    const found = await fromHash(hash);
    if (found === null) throw new Error("it is neither a machine nor an example");
    return found;
  }
  const found = gallery.get(`${decodeURIComponent(example).replace(/\.toml$/, "")}.toml`);
  if (found === undefined) throw new Error(`there is no example ${decodeURIComponent(example)}`);
  return found;
}

/** Applies the machine in the address. For a damaged link the page shows an error: the present text stays, or the first example is shown at the start. */
async function adoptLink() {
  const isFirst = !run.machine && !text(), first = gallery.get("damper_with_buffer.toml") ?? "", was = isFirst ? kept() : null;
  if (was) {
    for (const [name, content] of was.records) records.set(name, content);
    return adopt(was.text);
  }
  try {
    const found = await linked();
    if (found === null && !isFirst) return;
    if (!isFirst && isOwn() && !inAddress && !confirm("The link holds another machine, and no link holds your text. Replace your text?")) return write();
    await adopt(found ?? first);
  } catch (error) {
    if (isFirst) await adopt(first);
    misled = true;
    say(`The link is incomplete or changed (${/** @type {Error} */ (error).message}). ${isFirst ? "An example is shown instead." : "The previous text is kept."}`, true);
  }
}

const isOwn = () => !select("example").value && text() !== "";
/** Name under which the user's own text survives a reload. */
const KEPT = "vibro-workbench";

/** Keeps one's own text and records over a reload; where they do not fit, the browser asks before it leaves. @param {Event} event */
function keep(event) {
  try {
    sessionStorage.removeItem(KEPT);
    if (isOwn()) sessionStorage.setItem(KEPT, JSON.stringify({ hash: location.hash, text: text(), records: [...records] }));
  } catch { if (isOwn() && !inAddress) event.preventDefault(); }
}

/** What was kept at this address. @returns {{text: string, records: [string, string][]} | null} */
function kept() {
  try {
    const found = JSON.parse(sessionStorage.getItem(KEPT) ?? "null");
    return found?.hash === location.hash ? found : null;
  } catch { return null; }
}

/** A whole new text. @param {string} content */
async function adopt(content) {
  if (content.length > LARGEST) {
    const words = `The text has ${content.length} letters; this page takes at most ${LARGEST}. The command line vibro reads files up to 64 MiB.`;
    return editor.showProblems([{ line: null, words }]);
  }
  // Records of the gallery are in the same folder as its files.
  for (const name of gallery.keys()) if (!name.endsWith(".toml") && content.includes(`"${name}"`) && !records.has(name)) records.set(name, gallery.get(name) ?? "");
  select("example").value = [...gallery].find(([, own]) => own === content)?.[0] ?? "";
  length = null; start = ""; run.at = 0; misled = false;
  if (!select("example").value) mine = content;
  studies.forget();
  editor.put(content);
  showRecords();
  await changed();
}

let opening = false, again = false;
/** Reads the text, and shows its machine or its problems; text typed meanwhile is read next. */
async function changed() {
  if (opening) { again = true; return; }
  opening = true;
  do { again = false; await read(); } while (again);
  opening = false;
  write();
  void extend();
}

async function read() {
  const began = performance.now();
  try {
    const { machine, words, now, marks } = await helper.ask("open", { ...machineFile(), start }, PATIENCE);
    alive = true;
    begin(machine, now, length);
    take({ rows: new Float64Array(0), events: "", time: now[0], problem: "" });
    scene.words = words; scene.marks = marks; scene.glow.clear();
    take(await helper.ask("run", { to: run.length, step: run.step, time: 8, most: 400_000 }, PATIENCE));
    editor.showProblems([]);
    show();
    look();
    dirty = true;
    say(start ? "The motion begins on the attractor that was clicked, at time 0; Restart returns to the start of the file." : "");
    workbench.edit = performance.now() - began;
  } catch (error) {
    const { problems, message } = /** @type {Refused} */ (error);
    editor.showProblems(problems ?? [{ line: null, words: message }]);
    alive &&= !/ended|broke off/.test(message);
    if (run.machine) say("The picture shows the last text without a problem.", true);
    else if (!problems) say(message, true);
  }
}

let extending = false;
/** Computes the rest of the run, in slices, so that a newer text never waits. */
async function extend() {
  if (extending) return;
  extending = true;
  while (alive && !opening && !isWhole()) {
    const of = run.machine;
    try {
      const more = await helper.ask("run", { to: run.length, step: run.step, time: 14, most: 400_000 }, PATIENCE);
      // Earlier questions concern the previous text, and are answered before a newer one is opened.
      if (run.machine !== of) break;
      take(more);
    } catch (error) { run.problem = /** @type {Error} */ (error).message; alive = false; }
    if (isFurther()) look();
    dirty = true;
  }
  if (run.problem) say(run.problem, true);
  extending = false;
}

/** Updates fields and lists for the machine. */
function show() {
  const { machine } = run;
  numbers.show(machine.numbers, change, editor.goTo);
  choose();
  const options = (/** @type {string[]} */ names, /** @type {string} */ value) => names.map((n) => new Option(n, n, false, n === value));
  const names = machine.columns.map((c) => c.name), known = select("across").dataset.names;
  if (known !== names.join()) {
    select("across").dataset.names = names.join();
    select("across").replaceChildren(...options(names, chosen.across));
    select("along").replaceChildren(...options(names, chosen.along));
    const first = chosen.histories[0] ?? names[0];
    select("of").replaceChildren(...options(names, first));
    element("columns").replaceChildren(...names.slice(0, 300).map((n) => {
      const label = document.createElement("label"), box = Object.assign(document.createElement("input"), { type: "checkbox", checked: chosen.histories.includes(n) });
      box.addEventListener("change", () => { chosen.histories = box.checked ? [...chosen.histories, n] : chosen.histories.filter((x) => x !== n); dirty = true; });
      label.append(box, n);
      return label;
    }));
  }
  studies.show();
  fits.show();
  input("length").value = String(run.length);
  showPace();
  element("timeline").setAttribute("aria-valuemax", String(run.length));
  document.title = `${machine.name}: workbench`;
}

let editing = false;
/** @type {[string, string] | null} */
let next = null;
/** Another value of a number, written into the text. @param {string} name @param {string} value */
async function change(name, value) {
  next = [name, value];
  if (editing) return;
  editing = true;
  while (next) {
    const [which, what] = next;
    next = null;
    try {
      editor.put(await helper.ask("edit", { ...machineFile(), name: which, value: what }, PATIENCE), which);
      becomesOwn();
      await changed();
    } catch (error) {
      const broken = document.querySelector("#problems button")?.textContent;
      numbers.refuse(which, broken ? `The text has a problem (${broken.toLowerCase()}), which comes first.` : /** @type {Error} */ (error).message);
    }
  }
  editing = false;
}

let written = 0;
/** Whether the address contains the present text. */
let inAddress = false;
/** Writes the file into the address, if it fits. */
function write() {
  clearTimeout(written);
  inAddress = false;
  written = window.setTimeout(async () => {
    if (misled) return;
    const own = text(), hash = records.size ? "" : await toHash(own);
    inAddress = hash !== "" && own === text();
    history.replaceState(null, "", hash ? `#${hash}` : location.pathname + location.search);
  }, 300);
}

async function copyLink() {
  if (records.size) return say(`A link cannot contain records (${[...records.keys()].join(", ")}): download the machine's file and send both.`);
  const hash = await toHash(text());
  if (!hash) return say(`The file is too long for a link (at most ${LONGEST} letters compressed): download it and send the file.`);
  const link = `${location.href.split("#")[0]}#${hash}`;
  try { await navigator.clipboard.writeText(link); say("The link is copied; it contains the whole file."); } catch { say(link); }
}

const note = (/** @type {string} */ id, /** @type {string} */ words) => { element(id).textContent = words; };

function showRecords() {
  const used = [...records.keys()].filter((name) => text().includes(`"${name}"`));
  for (const name of records.keys()) if (!used.includes(name)) records.delete(name);
  note("records", used.length ? `Records beside it: ${used.join(", ")}` : "");
}

function showKit() {
  for (const button of /** @type {NodeListOf<HTMLButtonElement>} */ (document.querySelectorAll(".fmu"))) button.title = kit ? "Packed here with compiled libraries" : "This page has no compiled libraries: drop a kit (machine-kit.zip), or open the page with libraries";
}

/** Files that were dropped or chosen. @param {Iterable<File>} files */
async function receive(files) {
  let main = null;
  /** @type {[string, string][]} */
  const tables = [];
  for (const file of files) {
    if (file.size > 64 * 2 ** 20) { editor.showProblems([{ line: null, words: `${file.name} has ${file.size} bytes: expected at most ${64 * 2 ** 20}` }]); continue; }
    if (/\.zip$/i.test(file.name)) {
      const bytes = new Uint8Array(await file.arrayBuffer());
      try { packer ??= new Helper(); const tuples = await packer.ask("platforms", { kit: bytes }, PATIENCE); kit = bytes; showKit(); note("taken", `A kit with libraries for ${tuples}.`); } catch (error) { note("taken", `${file.name}: ${/** @type {Error} */ (error).message}`); }
    } else if (!/\.(csv|mtx|toml|txt)$/i.test(file.name)) say(`${file.name}: expected a machine (.toml, .txt), a record (.csv, .mtx) or a kit (.zip).`, true);
    else if (/\.(csv|mtx)$/i.test(file.name)) tables.push([file.name, await file.text()]);
    else if (file.size > LARGEST) editor.showProblems([{ line: null, words: `${file.name} has ${file.size} bytes; this page takes at most ${LARGEST}. The command line vibro reads files up to 64 MiB.` }]);
    else main = await file.text();
  }
  // A record that the machine does not use is one to fit to.
  const reads = main ?? text(), measured = tables.filter(([name, own]) => !reads.includes(`"${name}"`) && fits.isRecord(own)), beside = tables.filter((own) => !measured.includes(own));
  const idle = beside.find(([name]) => /\.csv$/i.test(name) && !reads.includes(`"${name}"`));
  if (idle) fits.refuse(...idle);
  for (const [name, own] of beside) records.set(name, own);
  if (main !== null) await adopt(main); else if (beside.length) { showRecords(); await changed(); }
  for (const [name, own] of measured) await fits.receive(name, own);
}

const showPlaying = () => {
  /** @type {HTMLElement} */ (element("play").querySelector("span")).textContent = playing ? "Pause" : "Play";
  element("play").setAttribute("aria-pressed", String(playing));
};

/** Machine time per second, s. */
const pace = () => (run.length / 15) * 10 ** Number(input("pace").value);
function showPace() {
  const x = pace(), own = input("pace");
  own.style.setProperty("--part", `${(100 * (+own.value - +own.min) / (+own.max - +own.min)).toFixed(0)}%`);
  element("paceText").textContent = x >= 0.995 ? `${Number(x.toPrecision(2))} × real time` : `1/${Number((1 / x).toPrecision(2))} real time`;
}

/** @param {number} time */
function goTo(time) { run.at = Math.max(0, Math.min(run.length, time)); dirty = true; }

/** @param {string} name name of an element */
const unitOfImpulse = (name) => (run.machine.elements.find((e) => e.name === name)?.rotates ? "N·m·s" : "N·s");

/** Light and sound of what happens between two times. @param {number} from @param {number} to */
function strike(from, to) {
  let loudest = 0;
  for (const met of eventsBetween(from, to).slice(-40)) {
    const tag = tagOf(met.element);
    if (tag < 0) continue;
    const part = met.impulse > 0 ? met.impulse / (run.largestImpulse || 1) : 0;
    const light = met.kind === "impact" ? 0.35 + 0.65 * part : ["press", "close", "stick"].includes(met.kind) ? 0.4 : 0.2;
    const words = met.impulse > 0 ? `${Number(met.impulse.toPrecision(2))} ${unitOfImpulse(met.element)}` : ["stick", "slip"].includes(met.kind) ? met.kind : "";
    if (light >= (scene.glow.get(tag)?.light ?? 0)) scene.glow.set(tag, { light, words });
    if (met.kind === "impact" || met.kind === "press") loudest = Math.max(loudest, met.kind === "press" ? 0.2 : part);
  }
  if (loudest > 0) tick(loudest, 0);
}

let drawing = false;
/** Requests the sketch at the present instant. */
async function redraw() {
  if (drawing || !alive || opening) return;
  drawing = true;
  const values = valuesAt(run.at), { shifts, openings } = places(values), of = run.machine;
  try {
    const marks = await helper.ask("sketch", { shifts, openings }, PATIENCE);
    if (of === run.machine) { scene.marks = marks; hold(values); paintSketch(); }
  } catch { alive = false; }
  drawing = false;
}

function paintSketch() {
  const { clientWidth } = element("scroll"), canvas = on.sketch.canvas, least = parseFloat(getComputedStyle(canvas).minHeight);
  const { scale, wide, high } = sizeIn(clientWidth, least);
  canvas.style.width = wide > clientWidth ? `${wide}px` : "100%";
  canvas.style.height = `${high}px`;
  on.sketch.fit();
  drawSketch(on.sketch.begin(), on.sketch.width, on.sketch.height, scale);
  workbench.pictures++;
}

/** The panel under the pointer. @type {{surface: Surface, x: number, y: number} | null} */
let pointed = null;

/** @param {boolean} all */
function paint(all) {
  const { timeline, history, portrait, energy } = on;
  drawTimeline(timeline.begin(), timeline.width, timeline.height);
  element("timeline").setAttribute("aria-valuenow", run.at.toPrecision(5));
  element("timeline").setAttribute("aria-valuetext", `${Number(run.at.toPrecision(4))} s of ${run.length} s`);
  if (!all) return;
  for (const [surface, panel] of /** @type {[Surface, (g: any, w: number, h: number) => any][]} */ ([[history, drawHistories], [portrait, drawPortrait]])) {
    const frames = panel(surface.begin(), surface.width, surface.height);
    if (pointed?.surface === surface) readout(surface.context, frames, pointed.x, pointed.y);
  }
  drawEnergy(energy.begin(), energy.width);
  if (fits.fit.found) fits.drawFit(on.fitted.begin(), on.fitted.width, on.fitted.height);
  studies.draw(on.diagram.begin(), on.diagram.width, on.diagram.height);
}

/** @param {number} time */
function frame(time) {
  const passed = Math.min(0.1, Math.max(0, (time - last) / 1000));
  last = time;
  requestAnimationFrame(frame);
  if (!run.machine || !run.count) return;
  for (const surface of Object.values(on)) if (surface.fit()) dirty = true;
  if (playing && !opening) {
    const from = run.at, to = Math.min(from + passed * pace(), run.reached);
    if (to > from) { strike(from, to); run.at = to; dirty = true; }
    if (run.at >= run.length * (1 - 1e-12) || (run.problem && run.at >= run.reached)) { run.at = 0; }
  }
  if (fade(playing ? passed : 0, calm.matches)) dirty = true;
  if (!dirty) return;
  // Curves are redrawn twenty times a second while only the time changes.
  const all = !playing || isGrowing() || time - panelsAt > 50;
  if (all) panelsAt = time;
  beginFrame();
  paint(all);
  void redraw();
  dirty = isGrowing() || (playing && !all);
  workbench.frames++;
}

function toNextEvent() {
  playing = false; showPlaying();
  const met = run.events.find((m) => m.time > run.at * (1 + 1e-12) + 1e-12);
  if (!met) return say("No further event in this run.");
  const from = run.at;
  goTo(met.time);
  strike(Math.max(from, met.time * (1 - 1e-12) - 1e-12), met.time);
  say(`${met.kind} of ${met.element || "a signal"} at ${Number(met.time.toPrecision(6))} s${Number.isFinite(met.impulse) ? `, impulse ${Number(met.impulse.toPrecision(4))} ${unitOfImpulse(met.element)}` : ""}.`);
}

/** @param {string} what */
async function takeAlong(what) {
  const name = run.machine?.name ?? "machine", size = (/** @type {Surface} */ s) => /** @type {[number, number]} */ ([s.width, s.height]);
  if (what === "file") save(`${name}.toml`, new Blob([text()], { type: "application/toml" }));
  if (!run.machine) return;
  const sketch = (/** @type {any} */ g) => drawSketch(g, on.sketch.width, on.sketch.height, sizeIn(on.sketch.width, on.sketch.height).scale);
  if (what === "run") {
    const table = await runCsv();
    if (!table) return note("taken", "Another run has begun: run.csv was not saved.");
    save("run.csv", table);
  } else if (what === "events") save("events.csv", new Blob([eventsCsv()], { type: "text/csv" }));
  else if (what === "sketch-svg") save(`${name}-sketch.svg`, svg(...size(on.sketch), sketch));
  else if (what === "sketch-png") save(`${name}-sketch.png`, await png(...size(on.sketch), sketch));
  else if (what === "history-svg") save(`${name}-histories.svg`, svg(...size(on.history), (g) => drawHistories(g, ...size(on.history))));
  else if (what === "diagram-svg") save(`${name}-diagram.svg`, svg(...size(on.diagram), (g) => studies.draw(g, ...size(on.diagram), false)));
  else if (what.startsWith("fmu")) return pack(what === "fmu2" ? 2 : 3);
  note("taken", "Saved.");
}

/** @param {number} version */
async function pack(version) {
  if (!kit) return note("taken", "This page holds no compiled libraries: drop a kit (machine-kit.zip of `fmu-build --kit`) here, or open the full page, which holds them.");
  note("taken", "Packing…");
  packer ??= new Helper();
  const began = performance.now();
  try {
    const bytes = await packer.ask("pack", { ...machineFile(), version, kit }, 30_000);
    workbench.packed = performance.now() - began;
    const name = `${run.machine.name}${version === 3 ? "-FMI3" : ""}.fmu`; // as vibro_pack::file_name
    save(name, new Blob([bytes], { type: "application/octet-stream" }));
    note("taken", `${name} of FMI ${version}.0, ${(bytes.length / 1e6).toFixed(2)} MB, packed here in ${(workbench.packed / 1000).toFixed(2)} s.`);
  } catch (error) { note("taken", /** @type {Error} */ (error).message); }
}

function listen() {
  editor.listen(() => { becomesOwn(); start = ""; showRecords(); if (text().length <= LARGEST) void changed(); });
  // If a worker took too long, the motion is lost until the next text.
  completion.listen((head, tail) => helper.ask("completion", { head, tail }, PATIENCE).catch((error) => { alive &&= !/ended|broke off/.test(error.message); throw error; }));
  select("example").addEventListener("change", () => { const name = select("example").value, own = name ? gallery.get(name) : mine; if (own) void adopt(own); });
  element("new").addEventListener("click", () => void adopt(SMALL));
  element("open").addEventListener("click", () => input("files").click());
  input("files").addEventListener("change", () => { void receive([...(input("files").files ?? [])]); input("files").value = ""; });
  element("copy").addEventListener("click", () => void copyLink());
  element("play").addEventListener("click", () => { playing = !playing; showPlaying(); dirty = true; });
  element("next").addEventListener("click", toNextEvent);
  element("again").addEventListener("click", () => { run.at = 0; dirty = true; if (start) { start = ""; void changed(); } });
  input("pace").addEventListener("input", showPace);
  input("sound").addEventListener("change", () => enable(input("sound").checked));
  input("length").addEventListener("change", () => {
    const said = input("length").value, wanted = seconds(said);
    if (wanted === null) { input("length").value = String(run.length); return say(`Run to “${said}”: expected a time above 0, in s or with one of the units ${Object.keys(TIMES).join(", ")}.`, true); }
    length = wanted;
    void changed();
  });
  for (const [id, key] of /** @type {const} */ ([["across", "across"], ["along", "along"]])) select(id).addEventListener("change", () => { chosen[key] = select(id).value; dirty = true; });
  fits.listen({ machineFile, change, ask: (kind, what) => helper.ask(kind, what, PATIENCE) }, () => { dirty = true; });
  studies.listen({ machineFile, change, begin: (from) => { start = from; }, play: () => { playing = !calm.matches; showPlaying(); } }, () => { dirty = true; });
  for (const fold of document.querySelectorAll(".fold")) fold.addEventListener("toggle", () => { dirty = true; });
  for (const button of document.querySelectorAll("[data-take]")) button.addEventListener("click", () => void takeAlong(/** @type {HTMLElement} */ (button).dataset.take ?? ""));
  const line = on.timeline.canvas, scrub = (/** @type {PointerEvent} */ e) => goTo(run.length * (e.offsetX - 8) / Math.max(1, line.clientWidth - 16));
  line.addEventListener("pointerdown", (e) => { line.setPointerCapture(e.pointerId); playing = false; showPlaying(); scrub(e); });
  line.addEventListener("pointermove", (e) => { if (e.buttons) scrub(e); });
  line.addEventListener("keydown", (e) => {
    const by = { ArrowLeft: -0.005, ArrowRight: 0.005, PageDown: -0.05, PageUp: 0.05 }[e.key];
    if (by !== undefined) goTo(run.at + by * run.length);
    else if (e.key === "Home") goTo(0); else if (e.key === "End") goTo(run.reached); else return;
    e.preventDefault();
  });
  for (const name of /** @type {const} */ (["history", "portrait"])) {
    const surface = on[name];
    surface.canvas.addEventListener("pointermove", (e) => { pointed = { surface, x: e.offsetX, y: e.offsetY }; dirty = true; });
    surface.canvas.addEventListener("pointerleave", () => { pointed = null; dirty = true; });
  }
  addEventListener("keydown", (e) => {
    const target = /** @type {HTMLElement} */ (e.target);
    if (e.ctrlKey || e.metaKey || e.altKey || /^(INPUT|TEXTAREA|SELECT)$/.test(target.tagName) || (e.key === " " && target.closest("button, summary"))) return;
    if (e.key === " ") element("play").click(); else if (e.key === "n" || e.key === "N") toNextEvent(); else if (e.key === "r" || e.key === "R") element("again").click(); else return;
    e.preventDefault();
  });
  addEventListener("dragover", (e) => { e.preventDefault(); document.body.classList.add("dropping"); });
  addEventListener("dragleave", (e) => { if (!e.relatedTarget) document.body.classList.remove("dropping"); });
  addEventListener("drop", (e) => { e.preventDefault(); document.body.classList.remove("dropping"); void receive([...(e.dataTransfer?.files ?? [])]); });
  addEventListener("hashchange", () => void adoptLink());
  for (const leaving of ["beforeunload", "pagehide"]) addEventListener(leaving, keep);
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => { theme(); dirty = true; });
  calm.addEventListener("change", () => { if (calm.matches) { playing = false; showPlaying(); } });
}

/** For the tests and measurements. */
const workbench = { run, study, plane, fit: fits.fit, scene, frames: 0, pictures: 0, edit: 0, packed: 0, receive, columnOf, valueAt, valuesAt, shownIn, state: () => ({ opening, alive, extending, growing: isGrowing(), whole: run.machine ? isWhole() : false }) };
/** @type {any} */ (window).workbench = workbench;

void boot();
