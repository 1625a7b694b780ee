// A fit of the machine to a dropped record: free parameters, progress, verdict, values with their
// errors, the drawn record and motion, and the accepted values.
import { Frame, reach, theme } from "../../../explorer/page/src/plot.js";
import { Helper } from "./helper.js";
import { shownIn } from "./panels.js";
import { run } from "./run.js";
import { stroke, Thin } from "./thin.js";

/** @typedef {{name: string, value: number, error: number | null, unit: string}} Value */
/** @typedef {{name: string, unit: string, record: number[], motion: number[]}} Column */
/** @typedef {{verdict: "fits" | "misses" | "undecided", words: string, values: Value[], undetermined: string[], remarks: string[], times: number[], columns: Column[], simulations: number, segments: number, nearUntil: number}} Fitted */
/** @typedef {{machineFile: () => {text: string, names: string[], texts: string[]}, change: (name: string, value: string) => Promise<void>, ask: (kind: string, what: any) => Promise<any>}} Page */

const element = (/** @type {string} */ id) => /** @type {HTMLElement} */ (document.getElementById(id));
const select = (/** @type {string} */ id) => /** @type {HTMLSelectElement} */ (document.getElementById(id));

export const fit = {
  /** The record, and the name of its file. */ table: "", name: "", columns: /** @type {string[]} */ ([]),
  found: /** @type {Fitted | null} */ (null),
  helper: /** @type {Helper | null} */ (null),
};
/** @type {Page} */
let page;
let changed = () => {};
const say = (/** @type {string} */ words) => { element("fitWords").textContent = words; };
const numberOf = (/** @type {string} */ name) => run.machine?.numbers.find((n) => n.name === name);

/** The first line of a table that is not empty or a comment. @param {string} text */
const heading = (text) => text.slice(0, 5000).replace(/["\uFEFF\r]/g, "").split("\n").find((line) => line.trim() && !line.trim().startsWith("#")) ?? "";

/** Whether a table's heading is the heading of a record: `time` and names of quantities, or `element`, with or without units. @param {string} text */
export const isRecord = (text) => {
  const names = heading(text).split(/[,;]/).map((cell) => cell.replace(/[[(/].*/, "").trim());
  return names.includes("time") && names.some((name) => name === "element" || /^\S+\.\w+$/.test(name));
};

/** Says why a table is no record, which no line of the machine reads either. @param {string} name @param {string} table */
export function refuse(name, table) {
  say(`${name} is not a record to fit to: its first line is “${heading(table).slice(0, 200)}”; expected names of time and of quantities such as box.s, separated by commas or semicolons.`);
  element("fit").scrollIntoView({ block: "nearest" });
}

/** Takes a record that was dropped. @param {string} name @param {string} table */
export async function receive(name, table) {
  stop("");
  /** @type {HTMLDetailsElement} */ (element("fitFold")).open = true;
  Object.assign(fit, { name, table, columns: [], found: null });
  try {
    const { samples, columns, contacts, from, to } = await page.ask("recorded", { table });
    fit.columns = columns;
    const what = columns.length ? columns.join(", ") : `contacts of ${contacts.join(", ")}`;
    say(`${name}: ${samples} samples of ${what}, from ${Number(from.toPrecision(4))} to ${Number(to.toPrecision(4))} s. Choose the numbers to fit.`);
    /** @type {HTMLDetailsElement} */ (element("free")).open = true;
  } catch (error) { fit.table = ""; say(`${name}: ${/** @type {Error} */ (error).message}`); }
  show();
  element("fit").scrollIntoView({ block: "nearest" });
}

/** The names of the free parameters. */
const free = () => [.../** @type {NodeListOf<HTMLInputElement>} */ (document.querySelectorAll("#freeNumbers input:checked"))].map((box) => box.value);

/** Updates list and buttons for machine, record and result. */
export function show() {
  const names = [...(run.machine?.numbers.map((n) => n.name) ?? []), "record.shift", ...fit.columns.map((column) => `record.offset.${column}`)], list = element("freeNumbers");
  if (list.dataset.names !== names.join()) {
    const before = free();
    list.dataset.names = names.join();
    list.replaceChildren(...names.map((name) => {
      const label = document.createElement("label"), box = Object.assign(document.createElement("input"), { type: "checkbox", value: name, checked: before.includes(name) });
      box.addEventListener("change", show);
      label.append(box, name);
      if (name === "record.shift") label.title = "Time of the motion at time 0 of the record";
      else if (name.startsWith("record.offset.")) label.title = "Difference of the column from the quantity";
      return label;
    }));
  }
  const { found } = fit, count = free().length;
  /** @type {HTMLButtonElement} */ (element("fitBegin")).disabled = !fit.table || !count;
  element("freeCount").textContent = count ? `${count} chosen` : "none chosen";
  element("fitBegin").hidden = fit.helper !== null;
  element("fitHalt").hidden = element("fitProgress").hidden = fit.helper === null;
  element("fitted").hidden = element("fitColumn").hidden = !found?.columns.length;
  element("fitTable").hidden = element("fitTake").hidden = !found;
  changed();
}

/** @param {string} words */
function stop(words) {
  fit.helper?.stop();
  fit.helper = null;
  if (words) say(words);
}

async function begin() {
  /** @type {HTMLDetailsElement} */ (element("free")).open = false;
  const names = free(), seconds = Number(select("fitTime").value), begun = performance.now(), helper = new Helper();
  Object.assign(fit, { found: null, helper });
  const progress = /** @type {HTMLProgressElement} */ (element("fitProgress"));
  progress.value = 0;
  say("Started.");
  show();
  try {
    const told = (/** @type {{steps: number}} */ { steps }) => { const passed = (performance.now() - begun) / 1000; progress.value = Math.min(1, passed / seconds); say(`${steps} steps in ${passed.toFixed(0)} s; ends after about ${seconds} s at the latest.`); };
    fit.found = await helper.ask("fit", { ...page.machineFile(), table: fit.table, free: names, seconds }, 0, told);
    tell((performance.now() - begun) / 1000);
  } catch (error) { if (fit.helper === helper) say(/** @type {Error} */ (error).message); }
  if (fit.helper === helper) stop("");
  show();
}

/** A value in the unit in which the file writes it, with as many digits as its error leaves. @param {Value} own */
function shown({ name, value, error, unit }) {
  const n = numberOf(name), factor = n?.factor ?? 1, symbol = n?.unit ?? (unit === "1" ? "" : unit), v = value * factor, e = (error ?? 0) * factor;
  const digits = e > 0 && v !== 0 ? Math.max(1, Math.min(12, Math.ceil(Math.log10(Math.abs(v) / e)) + 2)) : 6;
  return { value: String(Number(v.toPrecision(digits))), error: error === null ? "not determined" : String(Number(e.toPrecision(2))), unit: symbol, before: n ? String(n.value) : "" };
}

/** Says and lists what was found. @param {number} seconds */
function tell(seconds) {
  const { found } = fit;
  if (!found) return;
  const verdict = { fits: "It fits", misses: `It does not fit: ${found.words}`, undecided: `Undecided: ${found.words}` }[found.verdict];
  const more = [found.verdict === "fits" ? "" : "No errors: they would hold for another motion than the record's.", ...found.undetermined.map((words) => `Not determined, in parts of the values: ${words}.`), found.segments ? `In ${found.segments + 1} segments.` : "", ...found.remarks.map((words) => `${words}; finite differences are used instead.`)];
  say([`${verdict}. ${found.simulations} simulations in ${seconds.toFixed(1)} s.`, ...more].filter(Boolean).join(" "));
  const row = (/** @type {string} */ tag, /** @type {string[]} */ cells) => { const line = document.createElement("tr"); line.append(...cells.map((words, i) => { const cell = Object.assign(document.createElement(i ? tag : "th"), { textContent: words }); if (tag === "th") cell.setAttribute("scope", "col"); else if (!i) cell.setAttribute("scope", "row"); return cell; })); return line; };
  element("fitTable").replaceChildren(row("th", ["number", "fitted", "error", "unit", "before"]), ...found.values.map((own) => { const { value, error, unit, before } = shown(own); return row("td", [own.name, value, found.verdict === "fits" ? error : "", unit, before]); }));
  select("fitColumn").replaceChildren(...found.columns.map((column, i) => new Option(column.name, String(i))));
}

/** Writes the fitted values into the text. */
async function takeOver() {
  const own = (fit.found?.values ?? []).filter(({ name }) => numberOf(name));
  for (const one of own) {
    const n = numberOf(one.name);
    await page.change(one.name, String(Number((one.value * n.factor).toPrecision(9))));
  }
  say(own.length === 1 ? "The number is now in the text." : `${own.length} numbers are now in the text.`);
}

/** Record and fitted motion above, their difference below. @param {any} g @param {number} w @param {number} h */
export function drawFit(g, w, h) {
  const { found } = fit, column = found?.columns[Number(select("fitColumn").value) || 0];
  if (!found || !column) return;
  const { times } = found, { name, unit, record, motion } = column, residual = motion.map((x, i) => x - record[i]);
  const ends = /** @type {[number, number]} */ ([times[0], times[times.length - 1]]), floor = Math.round(0.62 * h);
  const part = (/** @type {number[]} */ all, /** @type {number} */ top, /** @type {number} */ bottom, /** @type {string} */ x, /** @type {string} */ words) => {
    const [f, u] = shownIn(unit, all.reduce((most, y) => Math.max(most, Math.abs(y)), 0));
    const frame = new Frame(ends, reach(all.map((y) => y * f)), { left: 56, right: w - 10, top, bottom });
    frame.axes(g, { x, y: `${words}${u && ` in ${u}`}`, xTicks: x !== "" });
    return { frame, f };
  };
  const line = (/** @type {Frame} */ frame, /** @type {number[]} */ all, /** @type {number} */ f, /** @type {string} */ colour) => frame.inside(g, () => {
    const thin = new Thin(...ends);
    all.forEach((y, i) => thin.add(times[i], y));
    g.strokeStyle = colour; g.lineWidth = 1.5;
    stroke(g, thin.indices(), (i) => frame.px(times[i]), (i) => frame.py(all[i] * f));
  });
  const above = part([...record, ...motion], 22, floor - 12, "", `${name}: record (dots) and motion`);
  above.frame.inside(g, () => { g.fillStyle = theme.soft; const every = Math.max(1, Math.ceil(record.length / 4000)); for (let i = 0; i < record.length; i += every) g.fillRect(above.frame.px(times[i]) - 1.5, above.frame.py(record[i] * above.f) - 1.5, 3, 3); });
  line(above.frame, motion, above.f, theme.box);
  const below = part(residual, floor + 18, h - 22, "t in s", "motion less record");
  line(below.frame, residual, below.f, theme.block);
}

/** Begins to listen. @param {Page} of @param {() => void} told */
export function listen(of, told) {
  page = of; changed = told;
  element("free").addEventListener("keydown", (event) => { if (event.key === "Escape") /** @type {HTMLDetailsElement} */ (element("free")).open = false; });
  element("fitBegin").addEventListener("click", () => void begin());
  element("fitHalt").addEventListener("click", () => { stop("Stopped; the numbers are as they were."); show(); });
  element("fitTake").addEventListener("click", () => void takeOver());
  select("fitColumn").addEventListener("change", changed);
}
