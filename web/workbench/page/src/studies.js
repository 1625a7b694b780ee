// The studies' card: parameters and ranges, the displayed quantity, and the motion played by a click.
import { classify, cellAt, cellOf, drawPlane, legend, plane } from "./plane.js";
import { run } from "./run.js";
import { diagram, drawStudy, forget as forgetStudy, halt, nearest, orbits, step, study } from "./study.js";

const element = (/** @type {string} */ id) => /** @type {HTMLElement} */ (document.getElementById(id));
const input = (/** @type {string} */ id) => /** @type {HTMLInputElement} */ (document.getElementById(id));
const select = (/** @type {string} */ id) => /** @type {HTMLSelectElement} */ (document.getElementById(id));

/** The parameter, its ends and its unit: elements by name, of the first and of the second axis. */
const FIRST = { parameter: "parameter", from: "from", to: "to", unit: "studyUnit" };
const SECOND = { parameter: "second", from: "from2", to: "to2", unit: "secondUnit" };

/** @typedef {{machineFile: () => {text: string, names: string[], texts: string[]}, change: (name: string, value: string) => Promise<void>, begin: (start: string) => void, play: () => void}} Page */
/** @type {Page} */
let page;

const say = (/** @type {string} */ words) => { element("studyWords").textContent = words; };
const numberOf = (/** @type {string} */ name) => run.machine?.numbers.find((n) => n.name === name);
const exact = (/** @type {string | undefined} */ name) => (name && numberOf(name)?.exact) ?? NaN;

/** About half to one and a half of a number's value. @param {typeof FIRST} ids */
function adoptRange(ids) {
  const n = numberOf(select(ids.parameter).value);
  if (!n) return;
  const [low, high] = n.value === 0 ? [0, 1] : [n.value * 0.5, n.value * 1.5].sort((a, b) => a - b);
  const clipped = [Math.max(low, n.min ?? -Infinity), Math.min(high, n.max ?? Infinity)].map((x) => Number(x.toPrecision(4)));
  input(ids.from).value = String(clipped[0]); input(ids.to).value = String(clipped[1] > clipped[0] ? clipped[1] : clipped[0] + 1);
  element(ids.unit).textContent = n.unit;
}

/** Updates the lists of parameters for the machine. */
export function show() {
  const names = run.machine.numbers.map((n) => n.name);
  if (select("parameter").dataset.names === names.join()) return;
  select("parameter").dataset.names = names.join();
  const drive = names.find((n) => n.endsWith(".frequency")) ?? names.find((n) => !n.startsWith("body.")) ?? names[0];
  const other = names.find((n) => n !== drive && n.endsWith(".gap")) ?? names.find((n) => n !== drive && !n.startsWith("body.")) ?? names.find((n) => n !== drive);
  for (const [ids, chosen] of /** @type {const} */ ([[FIRST, drive], [SECOND, other]])) {
    select(ids.parameter).replaceChildren(...names.map((n) => new Option(n, n, false, n === chosen)));
    adoptRange(ids);
  }
}

/** The number of an axis with its ends, SI; says what is not allowed. @param {typeof FIRST} ids */
function axis(ids) {
  const n = numberOf(select(ids.parameter).value), [from, to] = [ids.from, ids.to].map((id) => Number(input(id).value));
  if (!n) return null;
  if (!(from < to)) { say(`from ${input(ids.from).value} to ${input(ids.to).value}: expected two numbers, the first less than the second.`); return null; }
  return { name: n.name, range: /** @type {[number, number]} */ ([from / n.factor, to / n.factor]), factor: n.factor, unit: n.unit };
}

/** Shows progress while a study is under way. @param {() => Promise<void>} what */
async function during(what) {
  element("halt").hidden = element("progress").hidden = false;
  element("legend").replaceChildren();
  await what();
  if (!study.running) element("halt").hidden = element("progress").hidden = true;
  study.changed();
}

/** Discards the displayed result. */
export function forget() {
  forgetStudy();
  element("halt").hidden = element("progress").hidden = true;
  say("Local maxima of settled motions, value rising and falling. Click a point to play it.");
  study.changed();
}

async function compute(/** @type {typeof diagram | typeof orbits} */ what) {
  const x = axis(FIRST), of = run.machine?.columns.find((c) => c.name === select("of").value);
  if (!x || !of) return;
  await during(() => what(page.machineFile(), { parameter: x.name, range: x.range, factor: x.factor, unit: x.unit, of: of.name, ofUnit: of.unit, count: Number(select("values").value), seconds: Number(select("orbitTime").value) }));
}

async function computePlane() {
  const [x, y] = [axis(FIRST), axis(SECOND)];
  if (!x || !y) return;
  if (x.name === y.name) return say(`${x.name} over ${y.name}: expected two different numbers.`);
  const count = Number(select("cells").value);
  await during(() => classify(page.machineFile(), { ...x, count }, { ...y, count }));
}

/** Draws the study on show. @param {any} g @param {number} w @param {number} h @param {boolean} [isHere] whether the present values are marked */
export function draw(g, w, h, isHere = true) {
  if (study.shown !== "plane") return drawStudy(g, w, h, isHere ? exact(study.parameter) : NaN);
  drawPlane(g, w, h, isHere ? [exact(plane.x?.name), exact(plane.y?.name)] : [NaN, NaN]);
}

/** The legend, if it has changed. */
function showLegend() {
  const kinds = study.shown === "plane" ? legend() : [], all = kinds.reduce((sum, kind) => sum + kind.count, 0);
  element("legend").replaceChildren(...kinds.map(({ words, colour, count }) => {
    const item = document.createElement("li"), swatch = document.createElement("span");
    swatch.style.background = colour;
    item.append(swatch, `${words} ${(100 * count / all).toFixed(count === all ? 0 : 1)} %`);
    return item;
  }));
}

/** Takes a click on the diagram: its value into the text, its motion into the run. @param {number} px @param {number} py */
async function playFrom(px, py) {
  if (study.shown === "plane") { const place = cellAt(px, py); return place && playCell(place); }
  const found = nearest(px, py);
  if (found) await playMotion(found);
}

/** Plays a motion of the diagram: its value into the text, its state as the run's begin. @param {import("./study.js").Played} found */
async function playMotion(found) {
  if (!numberOf(study.parameter)) return say(`The machine has no ${study.parameter}: the diagram shows another machine.`);
  page.begin(found.start ?? "");
  const value = Number((found.value * study.factor).toPrecision(17));
  await page.change(study.parameter, String(value));
  say(`${study.parameter} = ${Number(value.toPrecision(8))} ${study.unit}: ${found.words || "no motion that returns to the section"}.`);
  page.play();
}

/** Plays the machine of a cell, from its own start, as the plane does. @param {[number, number]} place */
async function playCell(place) {
  const cell = cellOf(place), { x, y } = plane;
  if (!cell || !x || !y) return;
  if (!numberOf(x.name) || !numberOf(y.name)) return say(`The machine has no ${x.name} or no ${y.name}: the plane shows another machine.`);
  plane.at = place;
  page.begin("");
  await page.change(x.name, String(cell.x));
  await page.change(y.name, String(cell.y));
  say(cell.words);
  page.play();
}

/** @param {KeyboardEvent} event */
function walk(event) {
  const { x, y } = plane, by = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowDown: [0, -1], ArrowUp: [0, 1] }[event.key];
  if (study.shown !== "plane" && by) {
    const found = step(by[0], by[1]);
    if (found) say(`${study.parameter} = ${Number((found.value * study.factor).toPrecision(8))} ${study.unit}: ${found.words}. Enter plays it.`);
    study.changed();
  } else if (study.shown !== "plane" && event.key === "Enter" && study.at) void playMotion(study.at);
  else if (study.shown !== "plane" || !x || !y) return;
  else if (by) {
    const [i, j] = plane.at ?? [Math.floor(x.count / 2), Math.floor(y.count / 2)];
    plane.at = [Math.max(0, Math.min(x.count - 1, i + by[0])), Math.max(0, Math.min(y.count - 1, j + by[1]))];
    say(cellOf(plane.at)?.words ?? "not computed yet");
    study.changed();
  } else if (event.key === "Enter" && plane.at) void playCell(plane.at);
  else return;
  event.preventDefault();
}

/** Begins to listen. @param {Page} of @param {() => void} changed */
export function listen(of, changed) {
  page = of;
  for (const ids of [FIRST, SECOND]) select(ids.parameter).addEventListener("change", () => adoptRange(ids));
  element("compute").addEventListener("click", () => void compute(diagram));
  element("orbits").addEventListener("click", () => void compute(orbits));
  element("classes").addEventListener("click", () => void computePlane());
  element("halt").addEventListener("click", () => { halt(); element("halt").hidden = element("progress").hidden = true; });
  study.changed = () => { showLegend(); changed(); };
  study.told = (part, words) => { if (Number.isFinite(part)) /** @type {HTMLProgressElement} */ (element("progress")).value = part; say(words); };
  const canvas = element("diagram");
  canvas.addEventListener("click", (event) => void playFrom(event.offsetX, event.offsetY));
  canvas.addEventListener("pointermove", (event) => { const place = study.shown === "plane" && !study.running && cellAt(event.offsetX, event.offsetY), cell = place && cellOf(place); if (cell) say(cell.words); });
  canvas.addEventListener("keydown", walk);
}
