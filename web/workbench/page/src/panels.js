// Time line, histories, portrait and energies of the run.
import { FONT, Frame, reach, rgb, theme } from "../../../explorer/page/src/plot.js";
import { columnOf, curveOf, DAMPED, extent, INPUT, isWhole, KINETIC, LOST, RUBBED, run, STORED, valuesAt } from "./run.js";
import { Growing, stepped, stroke } from "./thin.js";

/** Names of the displayed quantities. */
export const chosen = { histories: /** @type {string[]} */ ([]), across: "", along: "" };

/** Colours of curves, in order. */
const colours = () => [theme.box, theme.block, theme.secondary, theme.relative, theme.falling, theme.here];

/** Chooses the quantities that a machine shows at first; keeps earlier ones that it still has. */
export function choose() {
  const { columns, bodies, elements } = run.machine, has = (/** @type {string} */ name) => columns.some((c) => c.name === name);
  chosen.histories = chosen.histories.filter(has);
  if (!chosen.histories.length) {
    const moving = bodies.filter((b) => !b.prescribed && has(`${b.name}.s`)), all = bodies.filter((b) => has(`${b.name}.s`));
    chosen.histories = (moving.length ? moving : all).slice(0, 3).map((b) => `${b.name}.s`);
    // Forces of rigid stops are impulses except during rest; a contact with a force already shows it.
    const contact = elements.find((e) => ["stop", "friction", "freewheel"].includes(e.section) && has(`${e.name}.f`) && extent(columnOf(`${e.name}.f`)).some((f) => f !== 0));
    if (contact) chosen.histories.push(`${contact.name}.f`);
  }
  if (!has(chosen.across) || !has(chosen.along)) {
    const first = chosen.histories[0]?.replace(/\.\w+$/, "") ?? "";
    [chosen.across, chosen.along] = has(`${first}.v`) ? [`${first}.s`, `${first}.v`] : [columns[0]?.name ?? "", columns[1]?.name ?? ""];
  }
}

/** A factor and a symbol in which numbers of a unit are easy to read. @param {string} unit @param {number} size @returns {[number, string]} */
export function shownIn(unit, size) {
  const si = unit === "1" ? "" : unit.replaceAll(".", "·").replace("s2", "s²");
  if (unit === "m" && size > 0) return size < 1e-4 ? [1e6, "µm"] : size < 0.1 ? [1e3, "mm"] : [1, "m"];
  if (unit === "N" && size >= 1e4) return [1e-3, "kN"];
  return [1, si];
}

const unitOf = (/** @type {string} */ name) => run.machine.columns.find((c) => c.name === name)?.unit ?? "1";

/** The curve of a column over time. @param {any} g @param {Frame} frame @param {number} place @param {number} factor */
function curve(g, frame, place, factor) {
  const { rows, width } = run;
  stroke(g, curveOf(place), (i) => frame.px(rows[i * width]), (i) => frame.py(rows[i * width + place] * factor));
}

/** @param {any} g @param {number} w @param {number} h */
export function drawHistories(g, w, h) {
  /** @type {Map<string, string[]>} */
  const groups = new Map();
  for (const name of chosen.histories) { const unit = unitOf(name); groups.set(unit, [...groups.get(unit) ?? [], name]); }
  const list = [...groups].slice(0, 4), each = (h - 24) / Math.max(1, list.length), frames = /** @type {Frame[]} */ ([]);
  list.forEach(([unit, names], k) => {
    const places = names.map(columnOf).filter((p) => p >= 0), ends = places.flatMap((p) => extent(p));
    const [factor, symbol] = shownIn(unit, Math.max(...ends.map(Math.abs)));
    const frame = new Frame([0, run.length], reach(ends.map((x) => x * factor)), { left: 52, right: w - 10, top: k * each + 20, bottom: (k + 1) * each - 2 });
    const last = k === list.length - 1;
    frame.axes(g, { x: last ? "t in s" : "", y: symbol, xTicks: last });
    frame.inside(g, () => {
      g.lineWidth = 1.5; g.lineJoin = "bevel";
      names.forEach((name) => { g.strokeStyle = colours()[chosen.histories.indexOf(name) % 6]; const place = columnOf(name); if (place >= 0) curve(g, frame, place, factor); });
      head(g, frame);
    });
    // Names next to the unit, each in its colour.
    let x = 52 + 26;
    g.font = `600 11px ${FONT}`; g.textAlign = "left"; g.textBaseline = "middle";
    for (const name of names) { g.fillStyle = colours()[chosen.histories.indexOf(name) % 6]; g.fillText(name, x, k * each + 10); x += g.measureText(name).width + 12; }
    frames.push(frame);
  });
  return frames;
}

/** The playhead. @param {any} g @param {Frame} frame */
function head(g, frame) {
  g.strokeStyle = theme.here; g.lineWidth = 1;
  g.beginPath(); g.moveTo(frame.px(run.at), frame.box.top); g.lineTo(frame.px(run.at), frame.box.bottom); g.stroke();
}

/** The portrait's curve, and the ranges on which it is drawn. */
const portrait = { picture: new Growing(), of: "", x: /** @type {[number, number]} */ ([0, 0]), y: /** @type {[number, number]} */ ([0, 0]) };

/** Ranges of the portrait. @param {[number, number]} x @param {[number, number]} y */
function portraitRanges(x, y) {
  const of = `${run.begun} ${chosen.across} ${chosen.along}`;
  if (portrait.of !== of) Object.assign(portrait, { of, x: [NaN, NaN], y: [NaN, NaN] });
  portrait.x = stepped(portrait.x, x, isWhole());
  portrait.y = stepped(portrait.y, y, isWhole());
  return portrait;
}

/** Two colours mixed. @param {string} one @param {string} other @param {number} part of the first */
function mixed(one, other, part) {
  const [a, b] = [rgb(one), rgb(other)];
  return `rgb(${a.map((x, i) => Math.round(part * x + (1 - part) * b[i])).join(" ")})`;
}

/** @param {any} g @param {number} w @param {number} h */
export function drawPortrait(g, w, h) {
  const [a, b] = [columnOf(chosen.across), columnOf(chosen.along)];
  if (a < 0 || b < 0) return [];
  const [ea, eb] = [extent(a), extent(b)], [fa, ua] = shownIn(unitOf(chosen.across), Math.max(...ea.map(Math.abs))), [fb, ub] = shownIn(unitOf(chosen.along), Math.max(...eb.map(Math.abs)));
  const scaled = (/** @type {[number, number]} */ [low, high], /** @type {number} */ factor) => /** @type {[number, number]} */ ([low * factor, high * factor]), { x, y } = portraitRanges(ea, eb);
  const frame = new Frame(scaled(x, fa), scaled(y, fb), { left: 52, right: w - 10, top: 20, bottom: h - 22 });
  frame.axes(g, { x: `${chosen.across}${ua && ` in ${ua}`}`, y: `${chosen.along}${ub && ` in ${ub}`}` });
  const { rows, width, count } = run;
  const line = (/** @type {any} */ own, /** @type {number} */ from, /** @type {number} */ to) => frame.inside(own, () => {
    // The later half of the run is darker than the earlier one.
    own.strokeStyle = rows[from * width] < run.length / 2 ? mixed(theme.box, theme.card, 0.35) : theme.box; own.lineWidth = 1.2;
    own.beginPath();
    for (let i = Math.max(0, from - 1); i < to; i++) { const x = frame.px(rows[i * width + a] * fa), y = frame.py(rows[i * width + b] * fb); if (i > from - 1) own.lineTo(x, y); else own.moveTo(x, y); }
    own.stroke();
  });
  portrait.picture.draw(g, `${portrait.of} ${x} ${y} ${theme.box} ${theme.card}`, count, line);
  frame.inside(g, () => {
    const now = valuesAt(run.at);
    g.fillStyle = theme.here;
    g.beginPath(); g.arc(frame.px(now[a] * fa), frame.py(now[b] * fb), 4, 0, 2 * Math.PI); g.fill();
  });
  return [frame];
}

/** Where the energy is, and where it went. @param {any} g @param {number} w */
export function drawEnergy(g, w) {
  const now = valuesAt(run.at);
  const flows = Math.max(1e-300, ...[INPUT, DAMPED, RUBBED, LOST].map((p) => Math.max(...extent(p).map(Math.abs)))), held = Math.max(1e-300, extent(KINETIC)[1] + extent(STORED)[1]);
  const bars = /** @type {[string, [number, string][]][]} */ ([
    ["in motion and springs", [[now[KINETIC], theme.box], [Math.max(0, now[STORED]), theme.falling]]],
    ["put in", [[Math.abs(now[INPUT]), now[INPUT] < 0 ? theme.soft : theme.secondary]]],
    ["lost: dashpots, friction, impacts", [[now[DAMPED], theme.relative], [now[RUBBED], theme.block], [now[LOST], theme.spark]]],
  ]);
  const left = 8, span = w - 16;
  g.font = `11px ${FONT}`; g.textBaseline = "middle";
  bars.forEach(([words, parts], i) => {
    const y = 14 + 26 * i;
    g.fillStyle = theme.soft; g.textAlign = "left"; g.fillText(words, left, y - 7);
    g.textAlign = "right"; g.fillText(energy(parts.reduce((sum, [x]) => sum + x, 0) * (i === 1 && now[INPUT] < 0 ? -1 : 1)), left + span, y - 7);
    g.fillStyle = theme.grid; g.fillRect(left, y, span, 7);
    let x = left;
    for (const [value, colour] of parts) { const wide = Math.min(left + span - x, span * Math.max(0, value) / (i ? flows : held)); g.fillStyle = colour; g.fillRect(x, y, wide, 7); x += wide; }
  });
}

const energy = (/** @type {number} */ x) => { const a = Math.abs(x), [f, u] = a >= 1e3 ? [1e-3, "kJ"] : a >= 1 || a === 0 ? [1, "J"] : a >= 1e-3 ? [1e3, "mJ"] : [1e6, "µJ"]; return `${(x * Number(f)).toPrecision(3)} ${u}`; };

/** Colour of an event's tick. @param {string} kind */
const colourOf = (kind) => (["impact", "press", "close"].includes(kind) ? theme.spark : ["stick", "slip"].includes(kind) ? theme.secondary : theme.faint);

/** The events' ticks on the time line, and their places. */
const events = new Growing(), ticked = new Set();

/** The time line: events as ticks, impacts higher by their impulse, and the playhead. @param {any} g @param {number} w @param {number} h */
export function drawTimeline(g, w, h) {
  const left = 8, right = w - 8, x = (/** @type {number} */ t) => left + (right - left) * t / run.length, floor = h - 14;
  g.fillStyle = theme.grid; g.fillRect(left, floor - 3, right - left, 3);
  g.fillStyle = theme.faint; g.fillRect(left, floor - 3, Math.max(0, x(Math.min(run.reached, run.length)) - left), 3);
  events.draw(g, `${run.begun} ${run.length} ${run.largestImpulse} ${theme.spark}`, run.events.length, (own, from, to) => {
    if (!from) ticked.clear();
    own.lineWidth = 1.5;
    for (const met of run.events.slice(from, to)) {
      const high = met.impulse > 0 ? 6 + 16 * Math.min(1, met.impulse / (run.largestImpulse || 1)) : 6;
      const place = `${Math.round(2 * x(met.time))} ${Math.round(high)} ${met.kind}`;
      if (ticked.has(place)) continue;
      ticked.add(place);
      own.strokeStyle = colourOf(met.kind);
      own.beginPath(); own.moveTo(x(met.time), floor - 4); own.lineTo(x(met.time), floor - 4 - high); own.stroke();
    }
  });
  const at = x(run.at);
  g.strokeStyle = theme.here; g.lineWidth = 2; g.beginPath(); g.moveTo(at, 2); g.lineTo(at, floor); g.stroke();
  g.fillStyle = theme.here; g.beginPath(); g.arc(at, floor - 1.5, 6, 0, 2 * Math.PI); g.fill();
  g.fillStyle = theme.soft; g.font = `11px ${FONT}`; g.textBaseline = "alphabetic"; g.textAlign = "left"; g.fillText("0 s", left, h - 1);
  g.textAlign = "right"; g.fillText(`${Number(run.length.toPrecision(3))} s`, right, h - 1);
}
