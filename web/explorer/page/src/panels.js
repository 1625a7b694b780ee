// Histories, phase portrait, Poincaré section, bars and amplitudes.
import { manifold, KIND, PHASE, RATE, ROW, TIME, V1, W, X1, X2, X3 } from "./core.js";
import { KEPT, motion } from "./motion.js";
import { FONT, Frame, reach, rgb, theme } from "./plot.js";
import { set, state } from "./state.js";
import { digits, lengths, parameterAxis, speeds, times, uncoupled } from "./units.js";

const smooth = new Map();
/** A range that grows at once and shrinks slowly, so that axes do not jump. @param {string} key @param {[number, number]} wanted @returns {[number, number]} */
function eased(key, wanted) {
  const old = smooth.get(key);
  const next = old ? /** @type {[number, number]} */ ([Math.min(wanted[0], old[0] + (wanted[0] - old[0]) * 0.06), Math.max(wanted[1], old[1] + (wanted[1] - old[1]) * 0.06)]) : wanted;
  smooth.set(key, next);
  return next;
}
export const forgetRanges = () => smooth.clear();

/** @param {any} g @param {number} width @param {number} height */
export function drawHistory(g, width, height) {
  const { rows, count, period, length: L } = motion, now = motion.now[TIME];
  const from = now - KEPT * period;
  let first = count - 1;
  while (first > 0 && rows[(first - 1) * ROW + TIME] >= from) first--;
  const shown = rows.subarray(first * ROW, count * ROW), begin = Math.max(from, count ? rows[0] : 0) / period, x = /** @type {[number, number]} */ ([begin, begin + KEPT + 0.25]);
  const box = { left: 44, right: width - 10, top: 20, bottom: height * 0.56 };
  let most = 0.5;
  // An uncoupled body stays at rest and is not drawn.
  const bodies = /** @type {[number, string][]} */ ([[X3, theme["drawn-secondary"]], [X1, theme.box], [X2, theme.block]]).slice(uncoupled() ? 1 : 0);
  for (let i = 0; i < shown.length; i += ROW) for (const [column] of bodies) most = Math.max(most, Math.abs(shown[i + column]) / L);
  most *= 1.08;
  const [low, high] = eased("history", [-most, most]);
  const upper = new Frame(x, [low, high], box), lower = new Frame(x, [-1.22, 1.22], { ...box, top: height * 0.66, bottom: height - 20 });
  upper.axes(g, { xTicks: false, x: { ...times(period), label: "" }, y: lengths("x"), yTicks: 4 });
  lower.axes(g, { x: times(period), y: lengths("w"), yTicks: 3 });
  const curve = (/** @type {Frame} */ frame, /** @type {number} */ column, /** @type {string} */ colour, /** @type {number} */ thick) => frame.inside(g, () => {
    g.strokeStyle = colour; g.lineWidth = thick; g.lineJoin = "round";
    g.beginPath();
    for (let i = 0; i < shown.length; i += ROW) {
      const px = frame.px(shown[i + TIME] / period), py = frame.py(shown[i + column] / L);
      if (i) g.lineTo(px, py); else g.moveTo(px, py);
    }
    g.stroke();
  });
  for (const [column, colour] of bodies) curve(upper, column, colour, 1.8);
  g.strokeStyle = theme.ink; g.lineWidth = 1.5;
  g.beginPath();
  for (const side of [-1, 1]) { g.moveTo(box.left, lower.py(side)); g.lineTo(box.right, lower.py(side)); }
  g.stroke();
  curve(lower, W, theme.relative, 1.6);
  const speed = L * set.value("drive.frequency");
  lower.inside(g, () => {
    g.fillStyle = theme.ink;
    for (const [time, side, v] of motion.impacts) {
      if (time < from) continue;
      g.beginPath(); g.arc(lower.px(time / period), lower.py(side), Math.max(1.2, Math.min(5, 1.2 + 2 * v / speed)), 0, 2 * Math.PI); g.fill();
    }
  });
  const end = shown.length - ROW;
  if (end >= 0) for (const [frame, column, colour] of /** @type {[Frame, number, string][]} */ ([...bodies.map(([column, colour]) => [upper, column, colour]), [lower, W, theme.relative]])) {
    g.fillStyle = colour;
    g.beginPath(); g.arc(frame.px(shown[end + TIME] / period), frame.py(shown[end + column] / L), 3.4, 0, 2 * Math.PI); g.fill();
  }
  return [upper, lower];
}

/** Columns of a displacement and its rate, with symbols and colour. @type {Record<string, [number, number, string, string, string]>} */
const PLANES = { w: [W, RATE, "w", "w′", "relative"], x1: [X1, V1, "x₁", "v₁", "box"], x2: [X2, V1 + 1, "x₂", "v₂", "block"], x3: [X3, V1 + 2, "x₃", "v₃", "drawn-secondary"] };

/** The frame of portrait and stroboscopic section: a displacement over L, its rate over L ω10. @param {number} width @param {number} height @param {string} plane */
function phaseFrame(width, height, plane) {
  const L = motion.length, V = motion.speedUnit, [place, rate] = PLANES[plane];
  let [far, fast] = [0.4, 0.4];
  const see = (/** @type {Float64Array} */ rows, /** @type {number} */ i) => { far = Math.max(far, Math.abs(rows[i + place]) / L); fast = Math.max(fast, Math.abs(rows[i + rate]) / V); };
  for (let i = 0; i < motion.settled.length; i += ROW) see(motion.settled, i);
  for (let i = Math.max(0, motion.count - 300); i < motion.count; i++) see(motion.rows, i * ROW);
  const x = plane === "w" ? /** @type {[number, number]} */ ([-1.15, 1.15]) : eased(`far ${plane}`, [-far * 1.1, far * 1.1]), y = eased(`fast ${plane}`, [-fast * 1.1, fast * 1.1]);
  return { frame: new Frame(x, y, { left: 44, right: width - 10, top: 20, bottom: height - 22 }), L, V };
}

/** @param {any} g @param {Frame} frame */
function stops(g, frame) {
  g.fillStyle = theme.grid;
  for (const [a, b] of [[frame.x[0], -1], [1, frame.x[1]]]) g.fillRect(frame.px(a), frame.box.top, frame.px(b) - frame.px(a), frame.box.bottom - frame.box.top);
  g.strokeStyle = theme.ink; g.lineWidth = 1.5;
  g.beginPath();
  for (const side of [-1, 1]) { g.moveTo(frame.px(side), frame.box.top); g.lineTo(frame.px(side), frame.box.bottom); }
  g.stroke();
}

/** @param {any} g @param {number} width @param {number} height */
export function drawPortrait(g, width, height) {
  const { frame, L, V } = phaseFrame(width, height, state.plane), [place, rate, across, up, colour] = PLANES[state.plane];
  if (state.plane === "w") stops(g, frame);
  frame.axes(g, { x: lengths(across), y: speeds(up, V, "Lω₁₀") });
  const line = (/** @type {Float64Array} */ rows, /** @type {number} */ from, /** @type {number} */ to) => {
    g.beginPath();
    for (let i = from; i < to; i++) {
      const px = frame.px(rows[i * ROW + place] / L), py = frame.py(rows[i * ROW + rate] / V);
      if (i > from) g.lineTo(px, py); else g.moveTo(px, py);
    }
    g.stroke();
  };
  frame.inside(g, () => {
    g.lineJoin = "round"; g.strokeStyle = theme[colour];
    const many = motion.class && motion.class[0] === 0;
    g.globalAlpha = many ? 0.2 : 0.38; g.lineWidth = many ? 0.8 : 1.4;
    line(motion.settled, 0, motion.settled.length / ROW);
    // The trail of the last drive period and a half, fading.
    const trail = 180, pieces = 12, first = Math.max(0, motion.count - trail);
    g.lineWidth = 2.2;
    for (let k = 0; k < pieces; k++) {
      g.globalAlpha = ((k + 1) / pieces) ** 1.6;
      const a = first + Math.floor((motion.count - first) * k / pieces), b = first + Math.floor((motion.count - first) * (k + 1) / pieces);
      line(motion.rows, Math.max(a - 1, first), b);
    }
    g.globalAlpha = 1;
  });
  if (motion.count) {
    g.fillStyle = theme[colour];
    g.beginPath(); g.arc(frame.px(motion.now[place] / L), frame.py(motion.now[rate] / V), 4.5, 0, 2 * Math.PI); g.fill();
  }
  return [frame];
}

/** The points of the section, drawn as they arrive. */
const section = { canvas: typeof document === "undefined" ? null : document.createElement("canvas"), drawn: 0, key: "" };

/** @param {any} g @param {number} width @param {number} height @param {number} ratio */
export function drawSection(g, width, height, ratio) {
  const strobe = state.section === "strobe";
  let frame, L, V;
  if (strobe) ({ frame, L, V } = phaseFrame(width, height, "w"));
  else {
    V = motion.length * set.value("drive.frequency"); L = Math.PI;
    let most = 0.4;
    for (let i = 1; i < motion.points.length; i += 4) most = Math.max(most, Math.abs(motion.points[i]) / V);
    const [low, high] = eased("impacts", [-most * 1.1, most * 1.1]);
    frame = new Frame([-1, 1], [low, high], { left: 44, right: width - 10, top: 20, bottom: height - 22 });
  }
  if (strobe) stops(g, frame);
  frame.axes(g, strobe ? { x: lengths("w"), y: speeds("w′", V, "Lω₁₀") } : { x: "θ/π", y: speeds("±v", V, "Lω₁") });
  const canvas = /** @type {HTMLCanvasElement} */ (section.canvas), points = motion.points;
  const key = `${width},${height},${ratio},${frame.y.map((v) => v.toFixed(3))},${state.section},${theme.relative}`;
  if (section.key !== key || section.drawn > points.length) {
    canvas.width = width * ratio; canvas.height = height * ratio;
    section.key = key; section.drawn = 0;
  }
  const into = /** @type {CanvasRenderingContext2D} */ (canvas.getContext("2d"));
  into.setTransform(ratio, 0, 0, ratio, 0, 0);
  into.fillStyle = theme.relative;
  const many = points.length > 4000, size = many ? 1 / ratio : 1.6;
  into.globalAlpha = many ? 0.75 : 0.9;
  for (let i = section.drawn; i < points.length; i += 4) into.fillRect(frame.px(points[i] / L) - size / 2, frame.py(points[i + 1] / V) - size / 2, size, size);
  section.drawn = points.length;
  frame.inside(g, () => {
    g.drawImage(canvas, 0, 0, width, height);
    if (motion.class && motion.class[0] > 0) {
      g.fillStyle = theme.relative;
      for (let i = Math.max(0, points.length - 4 * 64); i < points.length; i += 4) { g.beginPath(); g.arc(frame.px(points[i] / L), frame.py(points[i + 1] / V), 2.6, 0, 2 * Math.PI); g.fill(); }
    }
    g.strokeStyle = theme.ink; g.lineWidth = 1.5;
    const last = strobe ? motion.strobes.slice(-1) : motion.impacts.slice(-1).map(([time, side, v]) => [((set.value("drive.frequency") * time + set.value("drive.phase") + Math.PI) % (2 * Math.PI)) - Math.PI, side * v]);
    for (const [a, b] of last) { g.beginPath(); g.arc(frame.px(a / L), frame.py(b / V), 4.5, 0, 2 * Math.PI); g.stroke(); }
  });
  return [frame];
}

/** The impulse of the last impact, towards its stop; and where the energy that came in is. @param {any} g @param {number} width */
export function drawBars(g, width) {
  const [mechanical, , damped, lost] = motion.now.subarray(ROW + 2, ROW + 6);
  const last = motion.impacts.at(-1), unit = set.value("block.m") * motion.length * set.value("drive.frequency");
  const left = 66, right = width - 10, middle = (left + right) / 2;
  g.font = `12px ${FONT}`; g.textBaseline = "middle"; g.textAlign = "left"; g.fillStyle = theme.soft;
  g.fillText("impulse", 10, 11); g.fillText("energy", 10, 34);
  g.fillStyle = theme.grid; g.beginPath(); g.roundRect(left, 6, right - left, 10, 2); g.fill();
  if (last) {
    const [time, side, , impulse] = last, part = Math.min(1, impulse / unit / 5), age = (motion.now[TIME] - time) / motion.period;
    g.globalAlpha = Math.max(0.35, 1 - age); g.fillStyle = theme.spark;
    g.fillRect(side > 0 ? middle : middle - part * (middle - left), 6, part * (middle - left), 10);
    g.globalAlpha = 1;
    g.fillStyle = theme.soft; g.textAlign = side > 0 ? "right" : "left"; g.font = `11px ${FONT}`;
    g.fillText(motion.now[ROW] ? "at rest" : state.form === "si" ? `${digits(impulse, 3)} N·s` : `${(impulse / unit).toFixed(2)} m₂Lω₁`, side > 0 ? middle - 8 : middle + 8, 11.5);
  }
  g.strokeStyle = theme.soft; g.lineWidth = 1; g.beginPath(); g.moveTo(middle, 3); g.lineTo(middle, 19); g.stroke();
  const all = Math.max(mechanical + damped + lost, 1e-300), wide = right - left;
  const parts = /** @type {const} */ ([[mechanical, theme.ink, "machine"], [damped, theme.faint, "dampers"], [lost, theme.spark, "impacts"]]);
  let x = left;
  g.font = `11px ${FONT}`; g.textAlign = "left";
  // The words keep their positions when the fractions change.
  const widest = parts.map(([, , name]) => g.measureText(`${name} 100 %`).width + (width < 420 ? 20 : 30));
  parts.forEach(([value, colour, name], i) => {
    const w = wide * Math.max(0, value) / all, at = (width < 420 ? 10 : left) + widest.slice(0, i).reduce((a, b) => a + b, 0);
    g.fillStyle = colour; g.fillRect(x, 29, Math.max(0, w - 1), 10);
    g.beginPath(); g.roundRect(at, 49, 8, 8, 2); g.fill();
    g.fillStyle = theme.soft; g.fillText(`${name} ${(100 * value / all).toFixed(0)} %`, at + 12, 53.5);
    x += w;
  });
}

/** Curves of the closed forms, from the worker: rows of value, A1, A2, A3, stable. */
export const curves = { /** @type {Float64Array} */ exact: new Float64Array(0), /** @type {Float64Array} */ scales: new Float64Array(0), /** @type {Float64Array} */ strong: new Float64Array(0), problem: "" };

/** Rows of the manifold, see `manifold` in the core, of the set for which they were computed. @type {{of: object | null, rows: Float64Array, problem: string}} */
const slow = { of: null, rows: new Float64Array(0), problem: "" };

/** Figure 9 of the paper: the slow invariant manifold and its fixed points. */
export function manifoldRows() {
  if (slow.of !== set) {
    slow.of = set;
    try { [slow.rows, slow.problem] = [manifold(set, 160), ""]; } catch (error) { [slow.rows, slow.problem] = [new Float64Array(0), String(/** @type {Error} */ (error).message ?? error)]; }
  }
  return slow;
}

/** @param {any} g @param {number} width @param {number} height */
function drawManifold(g, width, height) {
  const { rows, problem } = manifoldRows(), curve = /** @type {Float64Array[]} */ ([]), points = /** @type {Float64Array[]} */ ([]);
  for (let i = 0; i < rows.length; i += 4) (rows[i + 3] ? points : curve).push(rows.subarray(i, i + 4));
  const most = Math.max(1, ...curve.map((p) => p[1])) * 1.06, ends = /** @type {[number, number]} */ (curve.length ? [curve[0][0], curve[curve.length - 1][0]] : [0, 1]);
  const frame = new Frame(ends, [0, most], { left: 44, right: width - 10, top: 20, bottom: height - 22 });
  frame.axes(g, { x: lengths("C"), y: lengths("B") });
  const at = (/** @type {ArrayLike<number>} */ p) => /** @type {const} */ ([frame.px(p[0]), frame.py(p[1])]);
  frame.inside(g, () => {
    g.lineJoin = "round"; g.strokeStyle = theme.relative;
    for (const strong of [false, true]) {
      g.lineWidth = strong ? 4.5 : 1.4;
      g.beginPath();
      for (let i = 1; i < curve.length; i++) if (!strong || (curve[i - 1][2] && curve[i][2])) { g.moveTo(...at(curve[i - 1])); g.lineTo(...at(curve[i])); }
      g.stroke();
    }
    for (const point of points) {
      g.fillStyle = point[2] ? theme.here : theme.card; g.strokeStyle = theme.here; g.lineWidth = 2;
      g.beginPath(); g.arc(...at(point), 5, 0, 2 * Math.PI); g.fill(); g.stroke();
      g.fillStyle = theme.ink; g.font = `600 12px ${FONT}`; g.textAlign = "left"; g.textBaseline = "middle";
      g.fillText(point[3] === 1 ? "P₁" : "P₂", at(point)[0] + (point[3] === 1 ? 9 : -22), at(point)[1] - 12);
    }
  });
  const words = problem || (points.length ? "" : "no fixed point: this force is too weak for the motion");
  if (words) { g.fillStyle = theme.soft; g.font = `12px ${FONT}`; g.textAlign = "left"; g.textBaseline = "top"; g.fillText(words, frame.box.left + 8, frame.box.top + 6); }
  return [frame];
}

/** @param {any} g @param {number} width @param {number} height */
export function drawResponse(g, width, height) {
  if (state.theory === "manifold") return drawManifold(g, width, height);
  const bodies = [theme.box, theme.block, theme["drawn-secondary"]].slice(0, uncoupled() ? 2 : 3), amplitudes = motion.amplitudes.slice(0, bodies.length);
  const tops = [0, ...amplitudes];
  for (const rows of [curves.exact, curves.scales]) for (let i = 0; i < rows.length; i += 5) for (let b = 1; b <= bodies.length; b++) if (rows[i + b] < 8) tops.push(rows[i + b]);
  const [, high] = reach(tops);
  const frame = new Frame(state.range, [0, Math.min(high, 6)], { left: 44, right: width - 10, top: 20, bottom: height - 22 });
  // Over the gap, amplitudes are in units of each column's own gap.
  frame.axes(g, { x: parameterAxis(state.along), y: state.along === "stop.gap" ? "A/L" : lengths("A") });
  frame.inside(g, () => {
    const theories = state.strong ? /** @type {const} */ ([[curves.strong, 1], [curves.exact, 2.2]]) : /** @type {const} */ ([[curves.scales, 1], [curves.exact, 2.2]]);
    for (const [rows, thick] of theories) for (let b = 0; b < bodies.length; b++) {
      g.strokeStyle = bodies[b]; g.lineWidth = thick; g.lineJoin = "round";
      for (const stable of [1, 0]) {
        g.setLineDash(stable ? [] : [5, 4]); g.globalAlpha = stable ? 1 : 0.7;
        g.beginPath();
        let pen = false;
        for (let i = 0; i < rows.length - 5; i += 5) {
          const here = rows[i], next = rows[i + 5];
          if (rows[i + 4] !== stable || !(here === here) || !(next === next)) { pen = false; continue; }
          if (!pen) g.moveTo(frame.px(here), frame.py(rows[i + 1 + b]));
          g.lineTo(frame.px(next), frame.py(rows[i + 6 + b]));
          pen = true;
        }
        g.stroke();
      }
      g.setLineDash([]); g.globalAlpha = 1;
    }
    const here = set.value(state.along);
    g.strokeStyle = theme.here; g.lineWidth = 1; g.globalAlpha = 0.7;
    g.beginPath(); g.moveTo(frame.px(here), frame.box.top); g.lineTo(frame.px(here), frame.box.bottom); g.stroke();
    g.globalAlpha = 1;
    amplitudes.forEach((a, b) => {
      g.fillStyle = bodies[b]; g.strokeStyle = theme.card; g.lineWidth = 1.5;
      g.beginPath(); g.arc(frame.px(here), frame.py(a), 4.5, 0, 2 * Math.PI); g.fill(); g.stroke();
    });
  });
  if (curves.problem) { g.fillStyle = theme.soft; g.font = `12px ${FONT}`; g.textAlign = "left"; g.textBaseline = "top"; g.fillText(curves.problem, frame.box.left + 8, frame.box.top + 6); }
  return [frame];
}

export { KIND, PHASE, V1, rgb };
