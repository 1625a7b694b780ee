// Fields and sliders: one row for each parameter, with the library's message next to a refused value.
import { assign, BY_NAME, PARAMETERS, set, state } from "./state.js";
import { chooseUnits, ends as endsOf, unitOf } from "./units.js";

const element = (/** @type {string} */ id) => /** @type {HTMLElement} */ (document.getElementById(id));

/** Number of steps of a slider. */
const STEPS = 400;

/** A slider's ends are in SI. @type {Map<string, {row: HTMLElement, slider: HTMLInputElement, text: HTMLInputElement, unit: HTMLElement, why: HTMLElement, ends: [number, number]}>} */
const fields = new Map();

/** A number as a field shows it: the shortest that comes back. @param {number} x */
export const told = (x) => String(Number.parseFloat(x.toPrecision(10)));

/** What is written in a field as the library reads it: a comma or a minus sign as people write them. @param {string} text */
export const plain = (text) => text.trim().replace("−", "-").replace(/^(-?\d*),(\d+)/, "$1.$2");

/** A value with its unit. @param {string} name @param {number} value */
export function toldOf(name, value) {
  const { symbol, factor } = unitOf(name);
  return symbol ? `${told(value * factor)} ${symbol}` : told(value);
}

/** The groups in display order: those changed most often come first. */
const ORDER = ["f10", "sigma1", "kappa", "epsilon", "gamma1", "gamma3", "alpha23", "beta2", "sigma30", "mu13"];

const BELOW = "₀₁₂₃₄₅₆₇₈₉";
/** A formula of the library's texts as it is printed. @param {string} text */
export const printed = (text) => text.replace(/epsilon/g, "ε").replace(/omega(?=\d)/g, "ω").replace(/sigma(?=\d)/g, "σ̂").replace(/alpha(?=\d)/g, "α̂").replace(/\^2/g, "²").replace(/>=/g, "≥").replace(/<=/g, "≤")
  .replace(/([\p{L}\u0302])(\d+)/gu, (_, letter, digits) => letter + [...digits].map((d) => BELOW[Number(d)]).join(""));

/** What fits beside the slider of a physical parameter; the library's words show over it. @type {Record<string, string>} */
const SHORT = {
  "box.m": "box mass", "box.k": "box spring", "box.c": "box damper", "block.m": "block mass", "secondary.m": "oscillator mass", "secondary.k": "oscillator spring", "secondary.c": "oscillator damper",
  "coupling.k": "coupling spring", "stop.gap": "gap", "stop.restitution": "restitution", "drive.amplitude": "force amplitude", "drive.frequency": "force frequency", "drive.phase": "force phase",
};

/** A parameter's meaning: words, and the formula if there is one. @param {import("./core.js").Parameter} p @returns {[string, string]} */
export function meaning(p) {
  if (!p.group) return [SHORT[p.name] ?? p.meaning, ""];
  const [, words, formula] = p.meaning.match(/^(.*?),? ?((?:[a-zA-Z]+\d+)[/( ].*)?$/) ?? ["", p.meaning, ""];
  return [words.replace(" of the ", " of ").replace("secondary ", ""), printed(formula ?? "")];
}

/** Makes the rows of the form that is chosen. @param {() => void} changed */
export function makeFields(changed) {
  const host = element("fields");
  host.textContent = "";
  fields.clear();
  chooseUnits();
  const shown = PARAMETERS.filter((p) => p.group === (state.form === "groups")), place = (/** @type {string} */ name) => ORDER.indexOf(name);
  for (const p of shown[0].group ? shown.sort((a, b) => place(a.name) - place(b.name)) : shown) {
    const row = document.createElement("div");
    row.className = "field";
    const id = `field-${p.name.replace(".", "-")}`, [words, formula] = meaning(p);
    row.innerHTML = `<label class="sym" for="${id}"></label><span class="what"></span><input type="text" id="${id}" inputmode="decimal" autocomplete="off" spellcheck="false"><span class="unit"></span><input type="range" min="0" max="${STEPS}" step="1" tabindex="0">`;
    const [text, slider] = /** @type {NodeListOf<HTMLInputElement>} */ (row.querySelectorAll("input"));
    /** @type {HTMLElement} */ (row.querySelector(".sym")).textContent = p.symbol;
    const unit = /** @type {HTMLElement} */ (row.querySelector(".unit"));
    /** @type {HTMLElement} */ (row.querySelector(".what")).textContent = words;
    row.title = `${p.group ? words : p.meaning}${formula ? `: ${formula}` : ""}; ${printed(p.allowed)}`;
    slider.setAttribute("aria-label", `${p.symbol}, ${words}`);
    const why = document.createElement("span");
    why.className = "why";
    why.id = `${id}-why`;
    why.hidden = true;
    why.setAttribute("role", "alert");
    row.append(why);
    text.setAttribute("aria-describedby", why.id);
    const field = { row, slider, text, unit, why, ends: span(p) };
    fields.set(p.name, field);
    slider.addEventListener("input", () => {
      // Sliders set round numbers in the displayed unit.
      const [low, high] = field.ends, { factor } = unitOf(p.name), value = low + (high - low) * Number(slider.value) / STEPS;
      apply(p.name, () => Number((value * factor).toPrecision(4)) / factor, changed, slider);
    });
    text.addEventListener("input", () => apply(p.name, () => set.read(p.name, plain(text.value), unitOf(p.name).plain), changed, text));
    text.addEventListener("blur", () => { if (why.hidden) { chooseUnits(); adoptRange(); } });
    host.append(row);
  }
  adoptRange();
}

/** The values at a slider's ends: those of the diagram for its parameter. @param {import("./core.js").Parameter} p @returns {[number, number]} */
const span = (p) => (p.name === state.along ? [...state.range] : endsOf(p));

/** After the diagram shows another parameter or range: this parameter's slider is the diagram's cursor. */
export function adoptRange() {
  for (const [name, field] of fields) {
    field.row.classList.toggle("along", name === state.along);
    const p = BY_NAME.get(name);
    if (p && (name === state.along || p.group || !fits(field.ends, set.value(name)))) field.ends = span(p);
  }
  show();
}

/** Whether a slider shows a value well: not beyond its ends, nor crowded at the lower one. @param {[number, number]} ends @param {number} value */
const fits = ([low, high], value) => value >= low && value <= high && (value === 0 || low !== 0 || value >= 0.1 * high);

/** @param {string} name @param {() => number} value @param {() => void} changed @param {HTMLElement} by */
function apply(name, value, changed, by) {
  const field = fields.get(name);
  if (!field) return;
  try {
    assign(name, value());
    if (by === field.text) {
      const unit = set.typed(name, plain(field.text.value));
      if (unit) state.units[name] = unit;
      if (unit) chooseUnits();
    }
    refuse(name, "");
    show(by);
    changed();
  } catch (error) {
    refuse(name, String(/** @type {Error} */ (error).message ?? error));
  }
}

/** Shows why a value is refused beside its field, or takes the message away. @param {string} name @param {string} words */
export function refuse(name, words) {
  const field = fields.get(name);
  if (!field) return;
  field.why.textContent = words.replaceAll("<=", "≤").replaceAll(">=", "≥");
  field.why.hidden = words === "";
  field.row.classList.toggle("bad", words !== "");
  field.text.setAttribute("aria-invalid", String(words !== ""));
}

/** Brings all fields up to date but the one that is being written in. @param {HTMLElement} [by] */
export function show(by) {
  for (const [name, field] of fields) {
    const value = set.value(name), { slider, text } = field, { symbol, factor } = unitOf(name), p = BY_NAME.get(name);
    // Another machine must not put a slider at its end.
    if (p && slider !== by && name !== state.along && !(value >= field.ends[0] && value <= field.ends[1])) field.ends = span(p);
    const [low, high] = field.ends, words = told(value * factor);
    field.unit.textContent = symbol;
    if (text !== by && document.activeElement !== text) { text.value = words; if (by) refuse(name, ""); }
    else if (text !== by && by) text.value = words;
    if (slider !== by) slider.value = String(Math.round(STEPS * (value - low) / (high - low)));
    slider.style.setProperty("--part", `${Math.max(0, Math.min(100, 100 * (value - low) / (high - low))).toFixed(1)}%`);
    slider.setAttribute("aria-valuetext", toldOf(name, value));
  }
}

/** The parameter set in words. */
export function describe() {
  if (PARAMETERS.every((p) => p.group || p.name === "drive.phase" || state.set.some(([name]) => name === p.name))) return "Shown: the machine with the values above in SI.";
  const base = state.strong ? "the strongly coupled set (chosen for this program)" : "the default set";
  const changes = state.set.filter(([name]) => BY_NAME.has(name)).map(([name, value]) => `${BY_NAME.get(name)?.symbol} = ${toldOf(name, value)}`);
  const list = changes.join(", ");
  return `Shown: ${base}${list ? ` with ${list}` : ""}.`;
}

/** The definitions of the groups, in order. */
export const definitions = () => PARAMETERS.filter((p) => p.group).map((p) => [p, meaning(p)[1]]).map(([p, formula]) => (/** @type {string} */ (formula).includes("= 1 +") ? formula : `${/** @type {any} */ (p).symbol} = ${formula || "restitution coefficient"}`));
