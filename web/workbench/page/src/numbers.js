// Every parameter of the file as a field and a slider; a change is written into the text.

/** @typedef {{name: string, meaning: string, unit: string, si: string, value: number, exact: number, factor: number, min: number | null, max: number | null, allowed: string, line: number}} Written */

const element = (/** @type {string} */ id) => /** @type {HTMLElement} */ (document.getElementById(id));

/** @type {Map<string, {row: HTMLElement, field: HTMLInputElement, slider: HTMLInputElement, why: HTMLElement, number: Written}>} */
const fields = new Map();
let names = "";

/** Ends of a number's slider, in its own unit: about twice the value, within what is allowed. @param {Written} n @returns {[number, number]} */
export function ends({ value, min, max, unit }) {
  const size = Math.abs(value) || (max !== null && max <= 1 ? max : 1);
  let low = value < 0 || (min ?? -1) < 0 && value === 0 ? -2 * size : 0, high = value < 0 ? 0 : 2 * size;
  if (max !== null && (unit === "" || max < high)) high = Math.min(max, Math.max(high, max <= 1 ? max : high));
  if (min !== null) low = Math.max(low, min);
  return [low, high];
}

/** Shows the numbers; rows stay where the names are the same, so that a slider is not lost under the finger. @param {Written[]} all @param {(name: string, value: string) => void} change @param {(line: number) => void} goTo */
export function show(all, change, goTo) {
  const now = all.map((n) => n.name).join("\n");
  if (now !== names) { names = now; make(all, change, goTo); }
  for (const n of all) {
    const own = fields.get(n.name);
    if (!own) continue;
    const before = own.number;
    own.number = n;
    own.row.classList.remove("bad"); own.why.hidden = true;
    if (document.activeElement !== own.field) own.field.value = String(n.value);
    if (document.activeElement !== own.slider || n.value < +own.slider.min || n.value > +own.slider.max || before.unit !== n.unit) range(own.slider, n);
    else own.slider.value = String(n.value);
    part(own.slider);
  }
}

/** @param {HTMLInputElement} slider @param {Written} n */
function range(slider, n) {
  const [low, high] = ends(n);
  Object.assign(slider, { min: String(low), max: String(high), step: "any" });
  slider.value = String(n.value);
}

const part = (/** @type {HTMLInputElement} */ slider) => slider.style.setProperty("--part", `${(100 * (+slider.value - +slider.min) / (+slider.max - +slider.min || 1)).toFixed(1)}%`);

/** @param {Written[]} all @param {(name: string, value: string) => void} change @param {(line: number) => void} goTo */
function make(all, change, goTo) {
  fields.clear();
  const rows = all.map((n) => {
    const row = document.createElement("div"), make = (/** @type {string} */ tag, /** @type {object} */ as) => Object.assign(document.createElement(tag), as);
    row.className = "field";
    const name = make("button", { className: "sym", type: "button", textContent: n.name, title: `${n.meaning}; ${n.allowed}. Go to line ${n.line}` });
    const field = /** @type {HTMLInputElement} */ (make("input", { type: "text", autocomplete: "off", spellcheck: false, id: `n-${n.name}` }));
    const unit = make("span", { className: "unit", textContent: n.unit });
    const slider = /** @type {HTMLInputElement} */ (make("input", { type: "range" }));
    const why = make("span", { className: "why", hidden: true });
    field.setAttribute("aria-label", `${n.name}, ${n.unit || "number"}`);
    slider.setAttribute("aria-label", `${n.name}, slider`);
    name.addEventListener("click", () => goTo(/** @type {any} */ (fields.get(n.name)).number.line));
    field.addEventListener("change", () => change(n.name, field.value));
    slider.addEventListener("input", () => {
      const digits = Number(Number(slider.value).toPrecision(3));
      field.value = String(digits);
      part(slider);
      change(n.name, String(digits));
    });
    row.append(name, slider, field, unit, why);
    const own = { row, field, slider, why, number: n };
    fields.set(n.name, own);
    range(slider, n);
    return row;
  });
  element("fields").replaceChildren(...rows);
}

/** Says beside a field why its value is refused. @param {string} name @param {string} words */
export function refuse(name, words) {
  const own = fields.get(name);
  if (!own) return;
  own.row.classList.add("bad");
  own.why.textContent = words; own.why.hidden = false;
}
