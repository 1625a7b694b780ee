// Fields and sliders: one row for each parameter, the library's message beside a value that it refuses.
import { assign, BY_NAME, PARAMETERS, set, state } from "./state.js";

const element = (/** @type {string} */ id) => /** @type {HTMLElement} */ (document.getElementById(id));

/** Steps of a slider. */
const STEPS = 400;

/** @type {Map<string, {row: HTMLElement, slider: HTMLInputElement, text: HTMLInputElement, why: HTMLElement, low: number, high: number}>} */
const fields = new Map();

/** A number as a field shows it: the shortest that comes back. @param {number} x */
export const told = (x) => String(Number.parseFloat(x.toPrecision(10)));

/** What a field's text means: a number, with a comma or a minus sign as people write them. @param {string} text */
export function read(text) {
  const plain = text.trim().replace("−", "-").replace(/^(-?\d*),(\d+)$/, "$1.$2");
  return plain === "" ? NaN : Number(plain);
}

/** Makes the rows of the form that is chosen. @param {() => void} changed */
export function makeFields(changed) {
  const host = element("fields");
  host.textContent = "";
  fields.clear();
  for (const p of PARAMETERS.filter((p) => p.group === (state.form === "groups"))) {
    const value = set.value(p.name);
    let { low, high } = p;
    // A physical value may be of any size: the slider runs from nothing to thrice its value.
    if (!p.group && p.unit !== "rad" && p.name !== "stop.restitution") [low, high] = [0, 3 * Math.abs(value) || 1];
    const row = document.createElement("div");
    row.className = "field";
    const id = `field-${p.name.replace(".", "-")}`;
    row.innerHTML = `<label class="sym" for="${id}"></label><input type="range" min="0" max="${STEPS}" step="1" tabindex="0"><input type="text" id="${id}" inputmode="decimal" autocomplete="off" spellcheck="false"><span class="unit"></span><span class="what"></span>`;
    const [slider, text] = /** @type {NodeListOf<HTMLInputElement>} */ (row.querySelectorAll("input"));
    /** @type {HTMLElement} */ (row.querySelector(".sym")).textContent = p.symbol;
    /** @type {HTMLElement} */ (row.querySelector(".unit")).textContent = p.unit === "1" ? "" : p.unit.replace(".", "·");
    /** @type {HTMLElement} */ (row.querySelector(".what")).textContent = p.meaning;
    row.title = `${p.meaning}; ${p.allowed}`;
    slider.setAttribute("aria-label", `${p.symbol}, ${p.meaning}`);
    const why = document.createElement("span");
    why.className = "why";
    why.id = `${id}-why`;
    why.hidden = true;
    why.setAttribute("role", "alert");
    row.append(why);
    text.setAttribute("aria-describedby", why.id);
    const field = { row, slider, text, why, low, high };
    fields.set(p.name, field);
    slider.addEventListener("input", () => apply(p.name, low + (high - low) * Number(slider.value) / STEPS, changed, slider));
    text.addEventListener("input", () => apply(p.name, read(text.value), changed, text));
    text.addEventListener("blur", () => { if (why.hidden) show(); });
    host.append(row);
  }
  show();
}

/** @param {string} name @param {number} value @param {() => void} changed @param {HTMLElement} by */
function apply(name, value, changed, by) {
  const field = fields.get(name);
  if (!field) return;
  try {
    // Sliders give round numbers.
    assign(name, by === field.slider ? Number(value.toPrecision(4)) : value);
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
  field.why.textContent = words;
  field.why.hidden = words === "";
  field.row.classList.toggle("bad", words !== "");
  field.text.setAttribute("aria-invalid", String(words !== ""));
}

/** Brings all fields up to date but the one that is being written in. @param {HTMLElement} [by] */
export function show(by) {
  for (const [name, { slider, text, low, high }] of fields) {
    const value = set.value(name);
    if (text !== by && document.activeElement !== text) { text.value = told(value); if (by) refuse(name, ""); }
    else if (text !== by && by) text.value = told(value);
    if (slider !== by) slider.value = String(Math.round(STEPS * (value - low) / (high - low)));
    slider.setAttribute("aria-valuetext", told(value));
  }
}

/** The parameter set in words. @param {import("./presets.js").Preset[]} presets */
export function describe(presets) {
  const preset = presets.find((p) => p.id === state.preset);
  const base = state.strong ? "the strongly coupled set (chosen for this program)" : "the default set";
  const changes = state.set.filter(([name]) => BY_NAME.has(name)).map(([name, value]) => `${BY_NAME.get(name)?.symbol} = ${told(value)}`);
  const list = changes.length > 6 ? "own values in SI" : changes.join(", ");
  return `Shown: ${preset ? `${preset.name} – ` : ""}${base}${list ? ` with ${list}` : ""}.`;
}
