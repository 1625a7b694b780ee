// The displayed motion: advanced with the clock, recorded for some drive periods, and followed until it settles.
import { KIND, Machine, PHASE, RATE, ROW, TIME, W, X1, X2, X3 } from "./core.js";
import { set, startSi, units } from "./state.js";
import { reach } from "./plot.js";

/** Number of drive periods in the histories, and of recorded instants in each period. */
export const KEPT = 8;
const PER_PERIOD = 120;
/** Number of drive periods until a motion counts as settled and in its portrait, and largest number of points of its section. */
const SETTLE = 300, PORTRAIT = 24, MOST_POINTS = 100_000;

export const motion = {
  /** @type {InstanceType<typeof Machine>} */
  machine: /** @type {any} */ (null),
  period: 1,
  length: 1,
  speedUnit: 1,
  /** Rows of the last drive periods. */
  rows: new Float64Array(ROW * PER_PERIOD * 64),
  count: 0,
  /** The present: see `Machine.now`. @type {Float64Array} */
  now: new Float64Array(ROW),
  /** Last impacts: time, side, speed, impulse. @type {number[][]} */
  impacts: [],
  /** Stroboscopic points of the motion on show: w, w'. @type {number[][]} */
  strobes: [],
  /** The settled motion: rows, what it is, its largest displacements. @type {Float64Array} */
  settled: new Float64Array(0),
  /** @type {InstanceType<typeof Machine> | null} */
  ahead: null,
  /** @type {Float64Array | null} */
  class: null,
  /** Points of the section, four numbers each. */
  points: /** @type {number[]} */ ([]),
  /** Largest |x1|, |x2|, |x3| and x1 - x3, in L, of the settled motion. */
  extent: [0.5, 1.3, 1, 1.3],
  /** Amplitudes of the settled motion, in L. */
  amplitudes: [0, 0, 0],
  /** Reason why the motion stopped, in words. */
  problem: "",
};

/** Restarts from the start state. */
export function restart() {
  const machine = new Machine(set, startSi());
  motion.machine?.free();
  motion.machine = machine;
  adopt();
  motion.count = 0; motion.impacts = []; motion.strobes = []; motion.problem = "";
  motion.now = machine.now();
  keep(motion.now.subarray(0, ROW));
}

/** Continues with the present parameters. */
export function reparametrize() {
  motion.machine.set_parameters(set);
  adopt();
  motion.now = motion.machine.now();
  motion.problem = "";
}

function adopt() {
  motion.period = 2 * Math.PI / set.value("drive.frequency");
  ({ length: motion.length, speed: motion.speedUnit } = units());
}

/** @param {Float64Array} rows */
function keep(rows) {
  const room = motion.rows.length / ROW;
  let more = rows.length / ROW;
  if (more > room / 2) { rows = rows.subarray(rows.length - Math.floor(room / 2) * ROW); more = rows.length / ROW; }
  if (motion.count + more > room) {
    // Discards the older half.
    const from = Math.max(motion.count - Math.floor(room / 2), 0);
    motion.rows.copyWithin(0, from * ROW, motion.count * ROW);
    motion.count -= from;
  }
  motion.rows.set(rows, motion.count * ROW);
  for (let i = Math.max(motion.count, 1); i < motion.count + more; i++) {
    // The drive's phase passes from below to above zero.
    const a = motion.rows[(i - 1) * ROW + PHASE], b = motion.rows[i * ROW + PHASE];
    if (a < 0 && b >= 0 && b - a < 2) {
      const f = a / (a - b), at = (/** @type {number} */ k) => motion.rows[(i - 1) * ROW + k] * (1 - f) + motion.rows[i * ROW + k] * f;
      motion.strobes.push([at(W), at(RATE)]);
      if (motion.strobes.length > 40) motion.strobes.shift();
    }
  }
  motion.count += more;
}

function takeImpacts() {
  const events = motion.machine.take_events(), fresh = [];
  for (let i = 0; i < events.length; i += 5) if (events[i] === 0) fresh.push([events[i + 1], events[i + 2], events[i + 3], events[i + 4]]);
  motion.impacts.push(...fresh);
  if (motion.impacts.length > 400) motion.impacts.splice(0, motion.impacts.length - 400);
  return fresh;
}

/** Advances by so many drive periods; returns the impacts on the way. @param {number} periods */
export function advance(periods) {
  if (!(periods > 0) || motion.problem) return [];
  const end = motion.now[TIME] + periods * motion.period;
  try {
    keep(motion.machine.record(end, Math.max(1, Math.ceil(periods * PER_PERIOD))));
  } catch (error) {
    motion.problem = String(/** @type {Error} */ (error).message ?? error);
  }
  motion.now = motion.machine.now();
  return takeImpacts();
}

/** Advances to just after the next impact, at most 20 drive periods, in pieces for the histories. */
export function toNextImpact() {
  const before = motion.now[TIME];
  for (let i = 1; i <= 20 * PER_PERIOD; i++) {
    const rows = motion.machine.to_impact(before + i * motion.period / PER_PERIOD);
    motion.now = motion.machine.now();
    if (rows.length) { keep(rows); return takeImpacts(); }
    keep(motion.now.subarray(0, ROW));
  }
  return takeImpacts();
}

/** Skips the transient: the motion continues from the settled state. */
export function skip() {
  const end = motion.now[TIME] + SETTLE * motion.period;
  motion.machine.record(end, 1);
  takeImpacts();
  motion.now = motion.machine.now();
  motion.count = 0; motion.impacts = []; motion.strobes = [];
  keep(motion.now.subarray(0, ROW));
}

/** The present state as a start: x in L, v in L ω10. */
export function presentAsStart() {
  return Array.from(motion.now.subarray(X1, X1 + 6), (x, i) => x / (i < 3 ? motion.length : motion.speedUnit));
}

/** Computes the settled motion and its portrait; its section is filled later. */
export function lookAhead() {
  motion.ahead?.free();
  motion.ahead = null;
  motion.points = [];
  motion.class = null;
  try {
    const ahead = motion.machine.settled(SETTLE);
    const end = ahead.now()[TIME] + PORTRAIT * motion.period;
    const copy = ahead.copy();
    motion.settled = copy.record(end, PORTRAIT * 64);
    copy.free();
    motion.ahead = ahead;
    const rows = motion.settled, L = motion.length;
    const most = [0, 0, 0, 0];
    for (let i = 0; i < rows.length; i += ROW) {
      for (let b = 0; b < 3; b++) most[b] = Math.max(most[b], Math.abs(rows[i + X1 + b]) / L);
      most[3] = Math.max(most[3], (rows[i + X1] - rows[i + X3]) / L);
    }
    motion.extent = most;
    motion.amplitudes = most.slice(0, 3);
  } catch (error) {
    motion.settled = new Float64Array(0);
    motion.problem = String(/** @type {Error} */ (error).message ?? error);
  }
}

/** The largest displayed displacements: of the settled motion, and of the last drive periods. */
export function extentShown() {
  const most = [...motion.extent], { rows, length: L } = motion;
  for (let i = Math.max(0, motion.count - 6 * PER_PERIOD); i < motion.count; i++) {
    for (let b = 0; b < 3; b++) most[b] = Math.max(most[b], Math.abs(rows[i * ROW + X1 + b]) / L);
    most[3] = Math.max(most[3], (rows[i * ROW + X1] - rows[i * ROW + X3]) / L);
  }
  return most;
}

/** Local maxima of a displacement in the settled motion, in L, where it has a period: its places in the diagram. @param {string} ordinate */
export function tops(ordinate) {
  const column = { x1: X1, x2: X2, x3: X3, w: W }[ordinate], { settled, length } = motion, found = /** @type {number[]} */ ([]);
  if (column === undefined || !motion.class?.[0]) return found;
  for (let i = ROW + column; i + ROW < settled.length; i += ROW) {
    const at = settled[i] / length;
    // Positions just before and just after an impact are equal: the nearest row in time is used.
    let next = i + ROW;
    while (next + ROW < settled.length && settled[next - column + TIME] === settled[i - column + TIME]) next += ROW;
    if (settled[i - ROW] < settled[i] && settled[i] >= settled[next] && !found.some((other) => Math.abs(other - at) < 0.005)) found.push(at);
  }
  return found;
}

/** Adds points to the section, at most for so many milliseconds; true while there are more to come. @param {string} kind @param {number} time */
export function fillSection(kind, time) {
  if (!motion.ahead || motion.points.length >= 4 * MOST_POINTS) return false;
  const until = performance.now() + time;
  // A periodic motion has few points, which are soon complete.
  const most = motion.class && motion.class[0] > 0 ? 4 * 512 : 4 * MOST_POINTS;
  while (performance.now() < until && motion.points.length < most) {
    try {
      const found = kind === "strobe" ? motion.ahead.strobe(128) : motion.ahead.impacts(64);
      if (kind === "strobe") motion.ahead.record(motion.ahead.now()[TIME] + motion.period * 0.5, 1);
      if (!found.length) return false;
      motion.points.push(...found);
    } catch { return false; }
  }
  return motion.points.length < most;
}

/** The class of the settled motion; computed when there is time. */
export function classify() {
  if (motion.class || !motion.ahead) return;
  try { motion.class = motion.ahead.class(); } catch { motion.class = new Float64Array(6); }
}

/** The settled motion in words: its class, and details. */
export function words() {
  if (motion.problem) return { head: "", rest: motion.problem };
  const c = motion.class;
  if (!c) return { head: "", rest: "" };
  const [period, up, low, symmetric, rests, settling, chaotic, exponent, undecided] = c;
  const head = undecided ? "It has not settled:" : settling ? "It is still settling:" : period === 1 ? "It repeats in every drive period:" : period ? `It repeats after ${period} drive periods:` : chaotic ? "Chaos, it never repeats:" : "Two frequencies, it never repeats:";
  // A periodic motion has a whole number of impacts; otherwise a mean is shown.
  const span = period || 1, number = (/** @type {number} */ n) => (Math.abs(n - Math.round(n)) < 1e-9 ? String(Math.round(n)) : n.toFixed(2)), [right, left] = [number(up * span), number(low * span)];
  const impacts = (/** @type {string} */ n) => (n === "1" ? "one impact" : `${n} impacts`);
  const hits = up + low === 0 ? "the block never touches the stops" : right === left ? `${impacts(right)} at each stop` : `${impacts(right)} at the right stop, ${left} at the left`;
  const parts = [period || up + low === 0 ? hits : `on average ${hits} a period`, period && symmetric && up + low > 0 && "half a period later it is its own mirror image", rests && "the block rests at a stop", chaotic && `largest Lyapunov exponent ${exponent.toFixed(2)}`];
  return { head, rest: `${parts.filter(Boolean).join("; ")}.` };
}

export { KIND, PHASE, RATE, ROW, TIME, W, X1, X2, X3, reach };
