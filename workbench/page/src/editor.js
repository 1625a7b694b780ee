// The text of the machine, its line numbers, and what is wrong at which line.

const element = (/** @type {string} */ id) => /** @type {HTMLElement} */ (document.getElementById(id));
const area = () => /** @type {HTMLTextAreaElement} */ (document.getElementById("text"));
/** Largest text that the editor shows, letters: a browser lays out no more at once. */
const SHOWN = 200_000;
/** A text that is too large to be shown, or nothing. @type {string | null} */
let held = null;

/** The whole text. */
export const text = () => held ?? area().value;

let lines = 0;
/** @type {Set<number>} */
let marked = new Set();

/** Line numbers, those with a problem marked. */
function gutter() {
  const box = element("gutter"), parts = [];
  let plain = "";
  for (let i = 1; i <= lines; i++) {
    if (!marked.has(i)) { plain += `${i}\n`; continue; }
    parts.push(plain, Object.assign(document.createElement("b"), { textContent: `${i}\n` }));
    plain = "";
  }
  box.replaceChildren(...parts, plain);
  follow();
}

const follow = () => { element("gutter").scrollTop = area().scrollTop; };

/** Begins to listen; `changed` is called after each change. @param {() => void} changed */
export function listen(changed) {
  area().addEventListener("input", () => { count(); changed(); });
  area().addEventListener("scroll", follow);
}

function count() {
  const now = area().value.split("\n").length;
  if (now !== lines) { lines = now; gutter(); }
}

/** Puts a text into the editor; the cursor and the scroll stay. @param {string} text */
export function put(text) {
  const box = area(), { selectionStart, selectionEnd, scrollTop } = box;
  held = text.length > SHOWN ? text : null;
  box.readOnly = held !== null;
  const shown = held === null ? text : `${text.slice(0, 2000)}\n# … and ${text.length - 2000} letters more, which are too many for this editor`;
  if (box.value === shown) return;
  box.value = shown;
  if (document.activeElement === box) box.setSelectionRange(selectionStart, selectionEnd);
  box.scrollTop = scrollTop;
  count();
}

/** Goes to a line. @param {number} line */
export function goTo(line) {
  const box = area(), all = box.value.split("\n");
  const start = all.slice(0, line - 1).reduce((sum, text) => sum + text.length + 1, 0);
  box.focus();
  box.setSelectionRange(start, start + (all[line - 1] ?? "").length);
  box.scrollTop = Math.max(0, (line - 4) * parseFloat(getComputedStyle(box).lineHeight));
}

/** Shows the problems, each with its line. @param {{line: number | null, words: string}[]} problems */
export function showProblems(problems) {
  marked = new Set(problems.flatMap((p) => (p.line ? [p.line] : [])));
  gutter();
  const shown = problems.slice(0, 50).map(({ line, words }) => {
    const item = document.createElement("li");
    if (line) {
      const button = Object.assign(document.createElement("button"), { textContent: `Line ${line}`, type: "button" });
      button.addEventListener("click", () => goTo(line));
      item.append(button, " ");
    }
    item.append(words);
    return item;
  });
  if (problems.length > 50) shown.push(Object.assign(document.createElement("li"), { textContent: `and ${problems.length - 50} more` }));
  element("problems").replaceChildren(...shown);
  element("problems").hidden = !problems.length;
  area().setAttribute("aria-invalid", String(problems.length > 0));
}
