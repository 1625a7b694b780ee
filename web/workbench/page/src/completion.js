// Completion in the editor: what the file's reader permits at the cursor, in a list below it. The
// list opens while typing, or with Ctrl+Space; arrows select an offer, Tab accepts it, Enter
// accepts a selected or requested one, Escape closes the list.

/** @typedef {{before: number, after: number, offers: [string, string][], allowed: string}} Found */

const element = (/** @type {string} */ id) => /** @type {HTMLElement} */ (document.getElementById(id));
const area = () => /** @type {HTMLTextAreaElement} */ (document.getElementById("text"));
const isOpen = () => !element("offers").hidden;

/** The open list, the index of its selected offer, and whether Enter accepts it. */
let found = /** @type {(Found & {at: number}) | null} */ (null), marked = 0, isChosen = false;
/** Number of the last question: an answer to an older one is dropped. */
let asked = 0;
/** @type {(head: string, tail: string) => Promise<Found>} */
let ask;

function close() {
  asked++;
  element("offers").hidden = true;
  area().removeAttribute("aria-activedescendant");
}

/** @param {number} place */
function mark(place) {
  const all = [...element("offersList").children];
  marked = (place + all.length) % all.length;
  all.forEach((item, i) => item.setAttribute("aria-selected", String(i === marked)));
  all[marked].scrollIntoView({ block: "nearest" });
  area().setAttribute("aria-activedescendant", all[marked].id);
}

/** Positions the list at the cursor. */
function put() {
  const box = area(), style = getComputedStyle(box), lines = box.value.slice(0, box.selectionStart).split("\n");
  const letters = /** @type {CanvasRenderingContext2D} */ (document.createElement("canvas").getContext("2d"));
  letters.font = style.font;
  const before = lines[lines.length - 1].slice(0, -(found?.before ?? 0) || undefined).replaceAll("\t", "    ");
  const { left, top } = box.getBoundingClientRect(), line = parseFloat(style.lineHeight), pad = parseFloat(style.paddingTop);
  const x = left + pad + letters.measureText(before).width - box.scrollLeft, y = top + pad + lines.length * line - box.scrollTop + 2;
  const list = element("offers");
  list.hidden = false;
  const below = y + list.offsetHeight <= innerHeight;
  list.style.left = `${Math.max(4, Math.min(x, innerWidth - list.offsetWidth - 4))}px`;
  list.style.top = `${below ? y : Math.max(4, y - line - 4 - list.offsetHeight)}px`;
}

/** Asks what may stand at the cursor, and shows it. @param {boolean} chosen */
async function open(chosen) {
  const box = area(), at = box.selectionStart, text = box.value, own = ++asked;
  if (box.readOnly || at !== box.selectionEnd) return close();
  const answer = await ask(text.slice(0, at), text.slice(at)).catch(() => null);
  if (own !== asked) return;
  if (!answer || box.value !== text || box.selectionStart !== at || document.activeElement !== box || !(answer.offers.length || answer.allowed)) return close();
  found = { ...answer, at }; isChosen = chosen;
  element("offersList").replaceChildren(...answer.offers.map(([name], i) => {
    const item = Object.assign(document.createElement("li"), { id: `offer-${i}`, textContent: name });
    item.setAttribute("role", "option");
    item.addEventListener("pointerdown", (event) => { event.preventDefault(); take(i); });
    return item;
  }));
  element("offersList").hidden = !answer.offers.length;
  element("offersWords").textContent = answer.allowed || "Tab inserts the marked completion; Escape closes.";
  put();
  element("offered").textContent = answer.offers.length ? `${answer.offers.length} completions: ${answer.offers.slice(0, 5).map((offer) => offer[0]).join(", ")}` : answer.allowed;
  if (answer.offers.length) mark(0); else area().removeAttribute("aria-activedescendant");
}

/** Takes an offer into the text; undone like what is typed. @param {number} place */
function take(place) {
  if (!found) return;
  const box = area(), at = box.selectionStart, [name, text] = found.offers[place], typed = at - found.at, before = found.before + typed;
  // Letters may have been typed that the list does not contain yet.
  const own = box.value.slice(at - Math.max(0, before), at);
  if (typed !== 0 && !(before >= 0 && (name.startsWith(own) || text.startsWith(own)))) return void open(true);
  box.focus();
  box.setSelectionRange(at - before, at + found.after);
  if (!document.execCommand("insertText", false, text)) {
    box.setRangeText(text, box.selectionStart, box.selectionEnd, "end");
    box.dispatchEvent(new Event("input"));
  }
  close();
  // A key is followed by its value.
  if (text.endsWith("= ")) void open(false);
}

/** Begins to listen. @param {(head: string, tail: string) => Promise<Found>} answer */
export function listen(answer) {
  ask = answer;
  const box = area();
  box.addEventListener("input", (event) => {
    const { inputType, data } = /** @type {InputEvent} */ (event);
    const isTyped = inputType === "insertText" && data !== null && /^[\w"'[.{]$/.test(data);
    if (isTyped || (isOpen() && inputType === "deleteContentBackward")) void open(false); else close();
  });
  box.addEventListener("keydown", (event) => {
    if (event.key === " " && event.ctrlKey) void open(true);
    else if (!isOpen()) return;
    else if (event.key === "Escape") close();
    else if (["ArrowLeft", "ArrowRight", "Home", "End", "PageUp", "PageDown"].includes(event.key)) return close();
    else if (!found?.offers.length) return;
    else if (event.key === "ArrowDown" || event.key === "ArrowUp") { isChosen = true; mark(marked + (event.key === "ArrowDown" ? 1 : -1)); }
    else if ((event.key === "Tab" && !event.shiftKey) || (event.key === "Enter" && isChosen)) take(marked);
    else return;
    event.preventDefault();
  });
  for (const kind of ["blur", "scroll", "pointerdown"]) box.addEventListener(kind, close);
  addEventListener("scroll", close);
  addEventListener("resize", close);
}
