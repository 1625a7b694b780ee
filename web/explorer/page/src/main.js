// The page: its parts, the clock, and events of mouse, touch and keys.
import { PHASE, RATE, ROW, TIME, unpack, use, X1 } from "./core.js";
import { adoptRange, definitions, describe, makeFields, meaning, refuse, show, toldOf } from "./controls.js";
import { attractorAt, compute, diagram, drawDiagram, frameOf, startWorkers } from "./diagram.js";
import { take } from "./exports.js";
import { bodyAt, drawMachine, layout } from "./machine-view.js";
import { advance, classify, extentShown, fillSection, lookAhead, motion, presentAsStart, reparametrize, restart, skip, toNextImpact, words } from "./motion.js";
import { curves, drawBars, drawHistory, drawPortrait, drawResponse, drawSection, forgetRanges, manifoldRows } from "./panels.js";
import { readout, readTheme, Surface } from "./plot.js";
import { MOVING_BLOCK, PRESETS } from "./presets.js";
import { enable, tick } from "./sound.js";
import { assign, BY_NAME, fromHash, PARAMETERS, prepare, set, state, toHash, units, usePreset } from "./state.js";
import { range as rangeOver, uncoupled } from "./units.js";

/* global WORKER: the script of the worker, put in by the bundler */

const element = (/** @type {string} */ id) => /** @type {HTMLElement} */ (document.getElementById(id));
const input = (/** @type {string} */ id) => /** @type {HTMLInputElement} */ (document.getElementById(id));
const calm = matchMedia("(prefers-reduced-motion: reduce)");

/** @type {Record<"machine" | "bars" | "history" | "portrait" | "poincare" | "diagram" | "response", Surface>} */
let on;
let playing = true, held = -1, chosen = -1, more = false, redraw = true, idle = 0;
/** Light at the lower and the upper stop, and the zoom of the view. */
const glow = /** @type {[number, number]} */ ([0, 0]), extent = [0.5, 1.3, 1, 1.3];

/** Message in place of the page. @param {string} text */
function broken(text) {
  element("broken").hidden = false;
  element("broken").textContent = text;
  element("main").hidden = element("tour").hidden = true;
}

async function start() {
  if (typeof WebAssembly !== "object") {
    return broken("This browser has no WebAssembly, which this page computes with. All browsers since 2017 have it. The command line vibro draws the same without a browser.");
  }
  let module;
  try {
    module = await unpack();
    use(module);
  } catch (error) {
    return broken(`WebAssembly could not be started: ${/** @type {Error} */ (error).message}. The command line vibro draws the same without a browser.`);
  }
  performance.mark("core-ready");
  prepare();
  readTheme();
  on = { machine: new Surface("machine"), bars: new Surface("bars"), history: new Surface("history"), portrait: new Surface("portrait"), poincare: new Surface("poincare"), diagram: new Surface("diagram"), response: new Surface("response") };
  adoptLink();
  makeControls();
  playing = !calm.matches;
  showPlaying();
  // The machine first; its settled motion follows with the next frame.
  try { restart(); } catch (error) {
    linked = String(/** @type {Error} */ (error).message ?? error);
    state.start = [...MOVING_BLOCK];
    restart();
  }
  frame(performance.now());
  performance.mark("first-picture");
  await new Promise((resolve) => setTimeout(resolve, 0));
  begin();
  startWorkers(module, WORKER);
  diagram.changed = () => { redraw = true; };
  compute(on.diagram.width);
  listen();
}

/** @param {string} text @param {boolean} [bad] @param {string} [head] what is said first and stands out */
function say(text, bad = false, head = "") {
  const strong = document.createElement("strong");
  strong.textContent = head;
  element("status").replaceChildren(...(head ? [strong, " "] : []), text);
  element("status").classList.toggle("bad", bad);
}

/** The error of the link, until something is changed. */
let linked = "";

/** Applies the link. If it has no range for the diagram, the range is chosen around the machine's own value. */
function adoptLink() {
  linked = fromHash(location.hash);
  if (!/[#&]over=/.test(location.hash)) holdCursor();
}

/** Shows the class of the settled motion. */
function tell() {
  const { head, rest } = words();
  if (linked) say(`The link could not be read in full: ${linked}. ${head} ${rest}`, true);
  else say(rest, motion.problem !== "", head);
}

/** Restarts everything from the start state. */
function begin() {
  try { restart(); } catch (error) {
    return say(String(/** @type {Error} */ (error).message ?? error), true);
  }
  forgetRanges();
  glow.fill(0);
  ahead();
}

/** Computes the settled motion; it is classified when there is time. */
function ahead() {
  lookAhead();
  more = true;
  idle = 0;
  redraw = true;
  element("shown").textContent = describe();
  for (const id of ["keyOscillator", "portraitOfOscillator", "maximaOfOscillator"]) element(id).hidden = uncoupled();
  element("story").textContent = PRESETS.find((p) => p.id === state.preset)?.story ?? "Your own numbers. The steps above, the presets and the browser’s back lead to others.";
  for (const link of element("tour").querySelectorAll("a")) {
    if (link.hash === `#preset=${state.preset}`) link.setAttribute("aria-current", "step"); else link.removeAttribute("aria-current");
  }
  tell();
}

let later = 0, written = 0;
/** After a parameter has changed: the motion goes on, all pictures follow. @param {boolean} [diagramToo] */
function changed(diagramToo = true) {
  const before = performance.now();
  linked = "";
  try { reparametrize(); } catch { begin(); }
  ahead();
  if (diagramToo) holdCursor();
  write();
  /** @type {HTMLSelectElement} */ (element("preset")).value = state.preset;
  if (diagramToo) { clearTimeout(later); later = window.setTimeout(() => compute(on.diagram.width), 120); }
  lastChange = performance.now() - before;
}
/** Chooses another range for the diagram if the machine's own value is outside. */
function holdCursor() {
  const here = set.value(state.along), p = BY_NAME.get(state.along);
  if (!p || (here >= state.range[0] && here <= state.range[1])) return;
  [state.range, state.band] = [rangeOver(p), null];
  adoptRange();
}

/** Duration of the last change, ms, for the measurements. */
export let lastChange = 0;

/** Writes the view into the link. @param {boolean} [step] whether the browser's back returns to what was before */
function write(step = false) {
  clearTimeout(written);
  const hash = `#${toHash()}`;
  if (step) history.pushState(null, "", hash);
  else written = window.setTimeout(() => history.replaceState(null, "", hash), 150);
}

function showPlaying() {
  /** @type {HTMLElement} */ (element("play").querySelector("span")).textContent = playing ? "Pause" : "Play";
  element("play").setAttribute("aria-pressed", String(playing));
}

function showPace() {
  const periods = 10 ** state.pace, seconds = periods * motion.period, { min, max } = input("pace");
  input("pace").style.setProperty("--part", `${(100 * (state.pace - Number(min)) / (Number(max) - Number(min))).toFixed(0)}%`);
  element("paceText").textContent = Math.abs(seconds - 1) < 0.03 ? "real time" : `${periods < 0.1 ? periods.toFixed(2) : periods.toFixed(1)} periods/s`;
}

function makeControls() {
  const preset = /** @type {HTMLSelectElement} */ (element("preset"));
  preset.innerHTML = `<option value="">own values</option>${PRESETS.map((p) => `<option value="${p.id}">${p.name}</option>`).join("")}`;
  const along = /** @type {HTMLSelectElement} */ (element("along"));
  const option = (/** @type {import("./core.js").Parameter} */ p) => `<option value="${p.name}">${p.symbol}, ${meaning(p)[0].replace(/^[A-Z](?=[a-z])/, (c) => c.toLowerCase())}</option>`;
  along.innerHTML = `<optgroup label="dimensionless">${PARAMETERS.filter((p) => p.group).map(option).join("")}</optgroup><optgroup label="SI">${PARAMETERS.filter((p) => !p.group && p.name !== "drive.phase").map(option).join("")}</optgroup>`;
  element("groups").replaceChildren(...definitions().map((text) => Object.assign(document.createElement("span"), { textContent: text })));
  showAll();
}

/** Updates all controls from the state. */
function showAll() {
  /** @type {HTMLSelectElement} */ (element("preset")).value = state.preset;
  /** @type {HTMLSelectElement} */ (element("along")).value = state.along;
  /** @type {HTMLSelectElement} */ (element("shownOrdinate")).value = state.ordinate;
  /** @type {HTMLSelectElement} */ (element("section")).value = state.section;
  /** @type {HTMLSelectElement} */ (element("plane")).value = state.plane;
  /** @type {HTMLSelectElement} */ (element("theory")).value = state.theory;
  element("theoryKey").textContent = theoryKey();
  input("orbits").checked = state.orbits;
  input("pace").value = String(state.pace);
  for (const radio of /** @type {NodeListOf<HTMLInputElement>} */ (document.querySelectorAll("input[name=form]"))) radio.checked = radio.value === state.form;
  makeFields(changed);
  showPace();
}

/** Explanation of the strokes of the closed forms. */
const theoryKey = () => (state.theory === "manifold" ? "strong: fixed points there pass all tests; P₁, P₂: those of this force, full where they pass" : `thick: exact orbit with two impacts a period, thin: ${state.strong ? "strong coupling" : "multiple scales"}; dashed: unstable; dots: this motion`);

/** Light and sound of impacts. @param {number[][]} impacts */
function strike(impacts) {
  const unit = 2.5 * set.value("block.m") * motion.length * set.value("drive.frequency");
  for (const [, side, , impulse] of impacts) {
    const part = Math.min(1, impulse / unit), which = side > 0 ? 1 : 0;
    glow[which] = Math.max(glow[which], 0.25 + 0.75 * part);
    tick(part, side);
  }
}

/** The springs and dampers that there are. @returns {import("./machine-view.js").Parts} */
const parts = () => ({ k1: set.value("box.k") > 0, c1: set.value("box.c") > 0, k23: !uncoupled(), k3: set.value("secondary.k") > 0, c3: set.value("secondary.c") > 0 });

/** Area in which the machine is drawn. */
const placed = () => layout(on.machine.width, on.machine.height, extent, uncoupled());

/** What the machine's picture shows. @returns {import("./machine-view.js").Shown} */
function shown() {
  return { x: [0, 1, 2].map((b) => motion.now[X1 + b] / motion.length), rate: motion.now[RATE] / motion.length * motion.period, force: Math.sin(motion.now[PHASE]), side: motion.now[ROW], glow: /** @type {[number, number]} */ ([...glow]), held: held >= 0 ? held : document.activeElement === on.machine.canvas ? chosen : -1, extent, parts: parts(), gap: state.form === "si" ? toldOf("stop.gap", motion.length) : "L" };
}

/** The panel under the pointer. @type {{surface: Surface, x: number, y: number} | null} */
let pointed = null;

let last = 0;
/** @param {number} time */
function frame(time) {
  const passed = Math.min(0.05, Math.max(0, (time - last) / 1000));
  last = time;
  let sized = false;
  for (const surface of Object.values(on)) sized = surface.fit() || sized;
  if (sized) { diagram.dirty = true; redraw = true; }
  if (playing && held < 0) { strike(advance(passed * 10 ** state.pace)); redraw = true; if (motion.problem) say(motion.problem, true); }
  if (glow[0] > 0.005 || glow[1] > 0.005) {
    // Light fades at the speed of the motion and stays while it is paused; with reduced motion it disappears at once.
    const slow = Math.max(0.09, Math.min(0.4, 0.07 / 10 ** state.pace)), fade = !playing ? 1 : calm.matches ? 0 : Math.exp(-passed / slow);
    if (fade < 1) redraw = true;
    glow[0] *= fade; glow[1] *= fade;
  }
  const wide = held >= 0 ? extent : extentShown();
  for (let i = 0; i < 4; i++) {
    const wanted = wide[i], step = wanted - extent[i];
    if (Math.abs(step) > 0.004) { extent[i] += step * (calm.matches || last === 0 ? 1 : Math.min(1, passed * 4)); redraw = true; }
  }
  // In the remaining time: the class of the motion, and more points of its section.
  idle++;
  if (idle === 6 && !motion.class) { classify(); if (!motion.problem) tell(); redraw = true; }
  if (more && idle > 1) { more = fillSection(state.section, 3) || !motion.class; redraw = true; }
  if (redraw || diagram.dirty) draw();
  redraw = false;
  requestAnimationFrame(frame);
}

function draw() {
  const { machine, bars, history, portrait, poincare, response } = on;
  if (machine.width) drawMachine(machine.begin(), machine.width, machine.height, placed(), shown());
  if (bars.width) drawBars(bars.begin(), bars.width);
  for (const [surface, panel] of /** @type {const} */ ([[history, drawHistory], [portrait, drawPortrait], [poincare, drawSection], [on.diagram, drawDiagram], [response, drawResponse]])) {
    if (!surface.width) continue;
    const frames = panel(surface.begin(), surface.width, surface.height, surface.ratio);
    if (pointed?.surface === surface && !diagram.drawn) readout(surface.context, frames, pointed.x, pointed.y);
  }
  const canvas = on.diagram.canvas, here = set.value(state.along);
  canvas.setAttribute("aria-valuemin", String(state.range[0])); canvas.setAttribute("aria-valuemax", String(state.range[1]));
  canvas.setAttribute("aria-valuenow", String(here)); canvas.setAttribute("aria-valuetext", `${BY_NAME.get(state.along)?.symbol} = ${toldOf(state.along, Number(here.toPrecision(5)))}`);
}

/** Sets the parameter of the diagram; its picture stays as it is. @param {number} value */
function along(value) {
  try { assign(state.along, Number(value.toPrecision(8))); } catch (error) {
    refuse(state.along, String(/** @type {Error} */ (error).message ?? error));
    return false;
  }
  show();
  return true;
}

/** Plays the attractor of the diagram that is nearest to a place. @param {number} value @param {number} ordinate */
function playAt(value, ordinate) {
  const found = attractorAt(value, ordinate);
  if (!along(found?.value ?? value)) return;
  if (found) {
    const { length, speed } = units();
    state.start = found.end.map((x, i) => (i < 3 ? x : x * length / speed));
    begin();
  } else changed(false);
  write();
  /** @type {HTMLSelectElement} */ (element("preset")).value = state.preset;
}

/** Looks at another part of the diagram; the browser's back returns. @param {[number, number]} range @param {[number, number] | null} band */
function zoom(range, band) {
  const p = BY_NAME.get(state.along);
  if (!(range[1] - range[0] > 1e-9 * Math.max(1, Math.abs(range[0])))) return;
  for (const end of range) try { set.with(state.along, end).free(); } catch (error) { return say(String(/** @type {Error} */ (error).message ?? error), true); }
  state.range = /** @type {[number, number]} */ (range.map((x) => Number(x.toPrecision(7))));
  state.band = band && /** @type {[number, number]} */ (band.map((x) => Number(x.toPrecision(6))));
  write(true);
  adoptRange();
  say(`Diagram over ${p?.symbol} from ${toldOf(state.along, state.range[0])} to ${toldOf(state.along, state.range[1])}.`);
  compute(on.diagram.width);
}

function whole() {
  const p = BY_NAME.get(state.along), preset = PRESETS.find((q) => q.id === state.preset && q.along === state.along);
  const range = preset?.range ?? (p ? rangeOver(p) : state.range);
  zoom([range[0], range[1]], null);
}

/** The bodies' places as the start, all at rest. @param {number} body @param {number} place in L */
function hold(body, place) {
  const x = [0, 1, 2].map((b) => motion.now[X1 + b] / motion.length);
  // The box moves the block along; the block stays in the box.
  if (body === 0) { x[1] = Math.min(place + 1, Math.max(place - 1, x[1])); x[0] = place; }
  if (body === 1) x[1] = Math.min(x[0] + 1, Math.max(x[0] - 1, place));
  if (body === 2) x[2] = place;
  if (Math.abs(x[1] - x[0]) > 1 - 1e-12) x[1] = x[0] + Math.sign(x[1] - x[0]) * (1 - 1e-12);
  state.start = [...x, 0, 0, 0];
  begin();
  write();
}

function listen() {
  const machine = on.machine.canvas;
  let offset = 0;
  const place = (/** @type {PointerEvent} */ e) => { const r = machine.getBoundingClientRect(); return [e.clientX - r.left, e.clientY - r.top]; };
  machine.addEventListener("pointerdown", (e) => {
    const [px, py] = place(e), at = placed(), { x } = shown();
    held = chosen = bodyAt(at, shown(), px, py);
    if (held < 0) return;
    machine.setPointerCapture(e.pointerId);
    machine.classList.add("held");
    offset = px - [at.box, at.box, at.secondary][held] - x[held] * at.scale;
    hold(held, x[held]);
  });
  machine.addEventListener("pointermove", (e) => {
    const [px, py] = place(e);
    if (held < 0) { machine.classList.toggle("over", bodyAt(placed(), shown(), px, py) >= 0); return; }
    const at = placed();
    hold(held, Math.max(-4, Math.min(4, (px - offset - [at.box, at.box, at.secondary][held]) / at.scale)));
  });
  for (const type of ["pointerup", "pointercancel"]) machine.addEventListener(type, () => { held = -1; machine.classList.remove("held"); redraw = true; });
  machine.addEventListener("keydown", (e) => {
    if (["1", "2", "3"].slice(0, uncoupled() ? 2 : 3).includes(e.key)) { chosen = Number(e.key) - 1; redraw = true; e.preventDefault(); }
    const way = { ArrowRight: 1, ArrowUp: 1, ArrowLeft: -1, ArrowDown: -1 }[e.key];
    if (way && chosen >= 0) { playing = false; showPlaying(); hold(chosen, shown().x[chosen] + way * (e.shiftKey ? 0.2 : 0.05)); e.preventDefault(); }
  });
  for (const type of ["focus", "blur"]) machine.addEventListener(type, () => { redraw = true; });
  listenToDiagram();
  for (const surface of [on.history, on.portrait, on.poincare, on.diagram, on.response]) {
    surface.canvas.addEventListener("pointermove", (e) => { if (e.pointerType === "mouse") { const r = surface.canvas.getBoundingClientRect(); pointed = { surface, x: e.clientX - r.left, y: e.clientY - r.top }; redraw = true; } });
    surface.canvas.addEventListener("pointerleave", () => { pointed = null; redraw = true; });
  }
  const act = {
    play: () => { playing = !playing; showPlaying(); redraw = true; },
    impact: () => { playing = false; showPlaying(); glow.fill(0); strike(toNextImpact()); redraw = true; },
    settle: () => { try { skip(); ahead(); } catch (error) { say(String(/** @type {Error} */ (error).message ?? error), true); } },
    again: () => begin(),
    sharper: () => { diagram.sharp = Math.min(16, diagram.sharp * 4); compute(on.diagram.width); },
    whole,
  };
  for (const [id, action] of Object.entries(act)) element(id).addEventListener("click", action);
  input("pace").addEventListener("input", () => { state.pace = Number(input("pace").value); showPace(); write(); });
  input("sound").addEventListener("change", () => enable(input("sound").checked));
  element("preset").addEventListener("change", () => {
    const preset = PRESETS.find((p) => p.id === /** @type {HTMLSelectElement} */ (element("preset")).value);
    if (!preset) return;
    usePreset(preset);
    diagram.sharp = 1;
    write(true);
    adoptState();
  });
  for (const radio of /** @type {NodeListOf<HTMLInputElement>} */ (document.querySelectorAll("input[name=form]"))) radio.addEventListener("change", () => { state.form = radio.value; makeFields(changed); forgetRanges(); diagram.dirty = redraw = true; write(); });
  element("along").addEventListener("change", () => { state.along = /** @type {HTMLSelectElement} */ (element("along")).value; whole(); });
  element("shownOrdinate").addEventListener("change", () => { state.ordinate = /** @type {HTMLSelectElement} */ (element("shownOrdinate")).value; state.band = null; write(); compute(on.diagram.width); });
  element("plane").addEventListener("change", () => { state.plane = /** @type {HTMLSelectElement} */ (element("plane")).value; redraw = true; write(); });
  element("theory").addEventListener("change", () => { state.theory = /** @type {HTMLSelectElement} */ (element("theory")).value; element("theoryKey").textContent = theoryKey(); redraw = true; write(); });
  element("section").addEventListener("change", () => { state.section = /** @type {HTMLSelectElement} */ (element("section")).value; forgetRanges(); ahead(); write(); });
  input("orbits").addEventListener("change", () => { state.orbits = input("orbits").checked; write(); compute(on.diagram.width); });
  for (const button of /** @type {NodeListOf<HTMLElement>} */ (document.querySelectorAll("[data-export]"))) button.addEventListener("click", async () => {
    const figure = /** @type {HTMLSelectElement} */ (element("figure")).value, surface = on[/** @type {keyof typeof on} */ (figure)];
    element("exported").textContent = await take(button.dataset.export ?? "", figure, surface, shown());
  });
  addEventListener("popstate", () => { adoptLink(); adoptState(); });
  addEventListener("keydown", (e) => {
    const target = /** @type {HTMLElement} */ (e.target);
    if (e.ctrlKey || e.metaKey || e.altKey || /^(INPUT|SELECT|TEXTAREA|BUTTON)$/.test(target.tagName)) return;
    const key = { " ": act.play, n: act.impact, s: act.settle, r: act.again }[e.key.toLowerCase()];
    if (key) { key(); e.preventDefault(); }
  });
  for (const query of ["(prefers-color-scheme: dark)", "(prefers-reduced-motion: reduce)"]) matchMedia(query).addEventListener("change", () => { readTheme(); diagram.dirty = true; redraw = true; });
}

/** Updates everything after the state has been replaced as a whole. */
function adoptState() {
  showAll();
  begin();
  compute(on.diagram.width);
}

function listenToDiagram() {
  const canvas = on.diagram.canvas;
  const place = (/** @type {PointerEvent} */ e) => { const r = canvas.getBoundingClientRect(); return [e.clientX - r.left, e.clientY - r.top]; };
  canvas.addEventListener("pointerdown", (e) => { const [x, y] = place(e); diagram.drawn = [x, y, x, y]; canvas.setPointerCapture(e.pointerId); });
  canvas.addEventListener("pointermove", (e) => { if (diagram.drawn) { [diagram.drawn[2], diagram.drawn[3]] = place(e); redraw = true; } });
  canvas.addEventListener("pointercancel", () => { diagram.drawn = null; redraw = true; });
  canvas.addEventListener("pointerup", () => {
    if (!diagram.drawn) return;
    const [x0, y0, x1, y1] = diagram.drawn, frame = frameOf(on.diagram.width, on.diagram.height);
    diagram.drawn = null;
    redraw = true;
    const clamp = (/** @type {number} */ x) => Math.min(frame.box.right, Math.max(frame.box.left, x));
    if (Math.abs(x1 - x0) < 6 && Math.abs(y1 - y0) < 6) return playAt(frame.ux(clamp(x1)), frame.uy(y1));
    if (Math.abs(x1 - x0) < 6) return;
    const xs = [x0, x1].map(clamp).map((x) => frame.ux(x)).sort((a, b) => a - b), ys = [y0, y1].map((y) => frame.uy(Math.min(frame.box.bottom, Math.max(frame.box.top, y)))).sort((a, b) => a - b);
    zoom([xs[0], xs[1]], Math.abs(y1 - y0) < 12 ? null : [ys[0], ys[1]]);
  });
  canvas.addEventListener("keydown", (e) => {
    const [from, to] = state.range, here = Math.min(to, Math.max(from, set.value(state.along))), step = (to - from) / (e.shiftKey ? 20 : 200);
    const way = { ArrowRight: 1, ArrowUp: 1, ArrowLeft: -1, ArrowDown: -1 }[e.key];
    if (way) { if (along(Math.min(to, Math.max(from, here + way * step)))) changed(false); }
    else if (e.key === "Home" || e.key === "End") { if (along(e.key === "Home" ? from : to)) changed(false); }
    else if (e.key === "+" || e.key === "=") zoom([here - (here - from) / 2, here + (to - here) / 2], null);
    else if (e.key === "-") zoom([here - 2 * (here - from), here + 2 * (to - here)], null);
    else if (e.key === "Enter") playAt(here, (diagram.band[0] + diagram.band[1]) / 2);
    else if (e.key === "Backspace") history.back();
    else return;
    e.preventDefault();
  });
}

/** For the tests and measurements of the page. */
Object.assign(window, { explorer: { state, motion, diagram, curves, manifoldRows, presentAsStart, toHash, changes: () => lastChange, TIME } });

start().catch((error) => broken(`The page could not be started: ${error.message ?? error}`));
