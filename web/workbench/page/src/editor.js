// The text of the machine, its line numbers, and its problems by line.

const element = (/** @type {string} */ id) => /** @type {HTMLElement} */ (document.getElementById(id));
const area = () => /** @type {HTMLTextAreaElement} */ (document.getElementById("text"));
/** Largest text in the editor, letters: a browser cannot lay out more at once. */
const SHOWN = 200_000;
/** A text that is too large to be shown, or nothing. @type {string | null} */
let held = null;

/** The whole text. */
export const text = () => held ?? area().value;

let lines = 0;
/** @type {Set<number>} */
let marked = new Set();

/** Line numbers; lines with a problem are marked. */
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

/** Milliseconds within which changes of one kind are undone as one. */
const AT_ONCE = 700;
/** Largest number of stored states, and of letters in all of them. */
const STATES = 200, LETTERS = 20_000_000;
/** Texts before the present one, and those that were undone, each with the cursor's place. @type {{text: string, at: number}[]} */
const before = [];
/** @type {{text: string, at: number}[]} */
const undone = [];
let shownLast = { text: "", at: 0 }, lastKind = "", lastAt = 0;

/** Keeps the text that stood here before a change: browsers forget what they could undo where a page sets a text. @param {string} kind */
function remember(kind) {
  const now = performance.now(), isOne = kind === lastKind && kind !== "whole" && now - lastAt < AT_ONCE;
  [lastKind, lastAt] = [kind, now];
  if (area().value === shownLast.text) return;
  if (!isOne) before.push(shownLast);
  undone.length = 0;
  while (before.length > STATES || before.reduce((sum, own) => sum + own.text.length, 0) > LETTERS) before.shift();
  shownLast = { text: area().value, at: area().selectionStart };
}

/** Goes back to the text before the last change, or forth again. @param {boolean} forth @param {() => void} changed */
function undo(forth, changed) {
  const [from, to] = forth ? [undone, before] : [before, undone], found = from.pop();
  if (!found || held !== null) return;
  to.push({ text: area().value, at: area().selectionStart });
  area().value = found.text;
  area().setSelectionRange(found.at, found.at);
  [shownLast, lastKind] = [found, ""];
  count();
  changed();
}

/** Begins to listen; `changed` is called after each change. @param {() => void} changed */
export function listen(changed) {
  area().addEventListener("input", (event) => {
    // Pasted or completed text is undone separately.
    remember(/** @type {InputEvent} */ (event).data?.length === 1 ? "typed" : "whole");
    count();
    changed();
  });
  area().addEventListener("scroll", follow);
  area().addEventListener("keydown", (event) => {
    const key = event.key.toLowerCase();
    if (!(event.ctrlKey || event.metaKey) || event.altKey || (key !== "z" && key !== "y")) return;
    event.preventDefault();
    undo(key === "y" || event.shiftKey, changed);
  });
  // From the browser's menus.
  area().addEventListener("beforeinput", (event) => {
    if (event.inputType !== "historyUndo" && event.inputType !== "historyRedo") return;
    event.preventDefault();
    undo(event.inputType === "historyRedo", changed);
  });
}

function count() {
  const now = area().value.split("\n").length;
  if (now !== lines) { lines = now; gutter(); }
}

/** Puts a text into the editor; the cursor and the scroll stay. @param {string} text @param {string} [kind] changes of one kind in a row are undone as one */
export function put(text, kind = "whole") {
  const box = area(), { selectionStart, selectionEnd, scrollTop } = box;
  held = text.length > SHOWN ? text : null;
  box.readOnly = held !== null;
  const shown = held === null ? text : `${text.slice(0, 2000)}\n# … and ${text.length - 2000} letters more, which are too many for this editor`;
  if (box.value === shown) return;
  box.value = shown;
  if (document.activeElement === box) box.setSelectionRange(selectionStart, selectionEnd);
  box.scrollTop = scrollTop;
  if (held === null) remember(kind);
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
