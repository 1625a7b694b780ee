// The machine as in the documentation's sketch, in motion. Lengths along the axis are to scale, so that block and stop meet at an impact.
// A spring or a damper of zero is not drawn. The oscillator is left out if it is not coupled to the block.
import { FONT, rgb, theme } from "./plot.js";

/** Half width of block and oscillator, thickness of stops and walls; in units of L. */
const HALF = 0.31, STOP = 0.1, WALL = 0.13;
/** Distances from the box's middle to the stops' faces, without the gap, and to its outside. */
const INNER = 1 + HALF, OUTER = INNER + STOP + WALL;
/** Smallest length of the springs to the ground. */
const LEAST = 0.42;
/** Space above the box for the force, and below the floor for the displacements, px. */
const ABOVE = 40, BELOW = 52;

/** @typedef {{scale: number, y: number, box: number, secondary: number, left: number, right: number, half: number, wheel: number, floor: number}} Layout */
/**
 * @typedef {object} Shown
 * @property {number[]} x x1, x2, x3 in L
 * @property {number} rate v2 - v1 in L a drive period
 * @property {number} force sine of the drive's phase
 * @property {number} side the stop at which the block rests, or 0
 * @property {[number, number]} glow of the lower and the upper stop, 0 to 1
 * @property {number} held the body that is dragged or chosen, -1 for none
 * @property {number[]} extent largest displacements and largest x1 - x3
 * @property {Parts} parts
 * @property {string} gap the gap in words
 */
/** Which springs and dampers there are, by their symbols. @typedef {Record<"k1" | "c1" | "k23" | "k3" | "c3", boolean>} Parts */

/** The places of the bodies at rest. @param {number} width @param {number} height @param {number[]} extent @param {boolean} [alone] without the oscillator @returns {Layout} */
export function layout(width, height, extent, alone = false) {
  const [x1, , x3, apart] = extent;
  // The box does not reach the ground; the oscillator does not reach the box or the other ground.
  const before = OUTER + LEAST + x1, after = alone ? before : HALF + LEAST + x3;
  const between = alone ? 0 : OUTER + HALF + Math.max(0.7, 0.3 + apart);
  const total = before + between + after, margin = 18;
  const scale = (width - 2 * margin) / total, wheel = Math.max(3.5, Math.min(7, 0.085 * scale));
  const room = height - ABOVE - BELOW - 2 * wheel - 2 * WALL * scale;
  const half = Math.max(24, Math.min(room / 2, Math.max(scale * 1.3, 78)));
  const y = ABOVE + WALL * scale + half + Math.max(0, room - 2 * half) / 2;
  return { scale, y, box: margin + before * scale, secondary: margin + (before + between) * scale, left: margin, right: width - margin, half, wheel, floor: y + half + WALL * scale + 2 * wheel };
}

/** A coil spring: the turns in front strong, those behind it pale. @param {any} g @param {number} from @param {number} to @param {number} y @param {number} turns @param {number} height */
function spring(g, from, to, y, turns, height) {
  const lead = Math.min(10, Math.abs(to - from) * 0.1), first = from + Math.sign(to - from) * lead, pitch = (to - from - 2 * Math.sign(to - from) * lead) / turns;
  g.strokeStyle = theme.faint; g.lineWidth = 1.6;
  g.beginPath();
  for (let i = 0; i < turns; i++) { g.moveTo(first + (i + 0.5) * pitch, y - height); g.lineTo(first + (i + 1) * pitch, y + height * (i + 1 < turns ? 1 : 0)); }
  g.stroke();
  g.strokeStyle = theme.soft; g.lineWidth = 2.6;
  g.beginPath();
  g.moveTo(from, y); g.lineTo(first, y);
  for (let i = 0; i < turns; i++) { if (i) g.moveTo(first + i * pitch, y + height); g.lineTo(first + (i + 0.5) * pitch, y - height); }
  g.moveTo(to - Math.sign(to - from) * lead, y); g.lineTo(to, y);
  g.stroke();
}

/** A dashpot whose cup stands on the ground and whose rod goes with the body; the cup takes up what the body leaves free. @param {any} g @param {number} ground @param {number} body @param {number} y @param {number} rest @param {number} free @param {number} height */
function damper(g, ground, body, y, rest, free, height) {
  const way = Math.sign(rest - ground), length = Math.abs(rest - ground);
  const cup = ground + way * free * 0.2, mouth = ground + way * Math.max(free * 0.95, Math.min(length * 0.62, 4.5 * height));
  const share = Math.max(0.1, Math.min(0.92, 0.5 + 0.42 * way * (body - rest) / Math.max(1, length - free)));
  const piston = cup + (mouth - cup) * share;
  g.fillStyle = tinted(theme.soft, 0.16);
  g.fillRect(Math.min(cup, mouth), y - height, Math.abs(mouth - cup), 2 * height);
  g.strokeStyle = theme.soft; g.lineWidth = 2;
  g.beginPath();
  g.moveTo(ground, y); g.lineTo(cup, y);
  g.moveTo(mouth, y - height); g.lineTo(cup, y - height); g.lineTo(cup, y + height); g.lineTo(mouth, y + height);
  g.moveTo(piston, y); g.lineTo(body, y);
  g.stroke();
  g.fillStyle = theme.soft;
  g.fillRect(piston - 2, y - height + 2.5, 4, 2 * height - 5);
}

const tinted = (/** @type {string} */ colour, /** @type {number} */ alpha) => { const [r, g, b] = rgb(colour); return `rgb(${r} ${g} ${b} / ${alpha.toFixed(3)})`; };

/** @param {any} g @param {number} x @param {number} y @param {number} r @param {number} strength */
function glow(g, x, y, r, strength) {
  if (strength < 0.01 || !g.createRadialGradient) return;
  const light = g.createRadialGradient(x, y, 0, x, y, r);
  light.addColorStop(0, tinted(theme.flash, 0.95 * strength));
  light.addColorStop(0.35, tinted(theme.flash, 0.42 * strength));
  light.addColorStop(1, tinted(theme.flash, 0));
  g.fillStyle = light;
  g.beginPath(); g.arc(x, y, r, 0, 2 * Math.PI); g.fill();
}

/** @param {any} g @param {string} text @param {number} x @param {number} y @param {string} colour @param {number} size @param {number} [weight] @param {string} [align] */
function label(g, text, x, y, colour, size, weight = 600, align = "center") {
  g.fillStyle = colour; g.font = `${weight} ${size.toFixed(1)}px ${FONT}`; g.textAlign = align; g.textBaseline = "middle";
  g.fillText(text, x, y);
}

/** A piece of metal: its colour, light on its upper edge, shade on its lower. @param {any} g @param {number} x @param {number} y @param {number} w @param {number} h @param {number} r @param {string} colour */
function metal(g, x, y, w, h, r, colour) {
  g.fillStyle = colour;
  g.beginPath(); g.roundRect(x, y, w, h, r); g.fill();
  const edge = Math.min(6, h * 0.12);
  g.fillStyle = "rgb(255 255 255 / 0.22)";
  g.beginPath(); g.roundRect(x, y, w, edge, Math.min(r, edge / 2)); g.fill();
  g.fillStyle = "rgb(0 0 0 / 0.16)";
  g.beginPath(); g.roundRect(x, y + h - edge, w, edge, Math.min(r, edge / 2)); g.fill();
}

/** A wheel that rolls as far as its body moves. @param {any} g @param {number} x @param {number} y @param {number} r @param {number} way */
function wheel(g, x, y, r, way) {
  g.fillStyle = theme.soft;
  g.beginPath(); g.arc(x, y, r, 0, 2 * Math.PI); g.fill();
  g.fillStyle = theme.card;
  g.beginPath(); g.arc(x + 0.5 * r * Math.cos(way / r), y + 0.5 * r * Math.sin(way / r), Math.max(0.9, 0.24 * r), 0, 2 * Math.PI); g.fill();
}

/** Ground: a strip with the strokes that stand for it in drawings. @param {any} g @param {number} x @param {number} y @param {number} w @param {number} h */
function ground(g, x, y, w, h) {
  g.save();
  g.beginPath(); g.rect(x, y, w, h); g.clip();
  g.strokeStyle = theme.line; g.lineWidth = 1.2;
  g.beginPath();
  for (let d = -h; d < w + h; d += 7) { g.moveTo(x + d, y + h); g.lineTo(x + d + h, y); }
  g.stroke();
  g.restore();
}

/** @param {any} g @param {Layout} at */
function drawGround(g, at) {
  const top = at.y - at.half - 8, { left, right, floor } = at;
  ground(g, left - 10, floor, right - left + 20, 7);
  ground(g, left - 10, top, 8, floor - top);
  ground(g, right + 2, top, 8, floor - top);
  g.strokeStyle = theme.faint; g.lineWidth = 2;
  g.beginPath(); g.moveTo(left - 2, top); g.lineTo(left - 2, floor); g.lineTo(right + 2, floor); g.lineTo(right + 2, top); g.stroke();
}

/** How far each body is from its place at rest, with ticks at whole L. @param {any} g @param {Layout} at @param {Shown} shown @param {number} width */
function drawDisplacements(g, at, { x, parts, gap }, width) {
  const first = at.floor + 20;
  for (const [rest, rows] of [[at.box, 2], [at.secondary, 1]].slice(0, parts.k23 ? 2 : 1)) {
    g.strokeStyle = theme.faint; g.lineWidth = 1;
    g.beginPath(); g.moveTo(rest, first - 8); g.lineTo(rest, first + 13 * rows - 6); g.stroke();
    g.strokeStyle = theme.line;
    g.beginPath();
    for (const n of [-1, 1]) { g.moveTo(rest + n * at.scale, first - 4); g.lineTo(rest + n * at.scale, first + 13 * rows - 9); }
    g.stroke();
  }
  for (const [rest, row, colour, name, by] of /** @type {const} */ ([[at.box, 0, theme.box, "x₁", x[0]], [at.box, 1, theme.block, "x₂", x[1]], [at.secondary, 0, theme.secondary, "x₃", x[2]]]).slice(0, parts.k23 ? 3 : 2)) {
    const y = first + 13 * row, tip = rest + by * at.scale, way = by < 0 ? -1 : 1;
    g.strokeStyle = colour; g.lineWidth = 3;
    g.beginPath(); g.moveTo(rest, y); g.lineTo(tip, y); g.stroke();
    label(g, name, tip + way * 5, y, colour, 11, 600, way > 0 ? "left" : "right");
  }
  label(g, `ticks at ±${gap}`, width - 8, first + 13, theme.soft, 11, 400, "right");
}

/** The box without what is in it: frame with an opening for the coupling spring if there is one, stops, wheels. @param {any} g @param {Layout} at @param {number} box @param {Shown} shown */
function drawBox(g, at, box, shown) {
  const { scale, y, half, floor } = at, wall = WALL * scale, inner = INNER * scale, outer = OUTER * scale, top = y - half - wall, slot = shown.parts.k23 ? Math.max(9, half * 0.17) : 0;
  g.fillStyle = tinted(theme.ink, 0.06);
  g.beginPath(); g.roundRect(box - outer, floor - 2, 2 * outer, 4, 2); g.fill();
  for (const d of [-0.72, 0.72]) wheel(g, box + d * outer, floor - at.wheel, at.wheel, shown.x[0] * scale);
  g.fillStyle = tinted(theme.box, 0.07);
  g.fillRect(box - outer + wall, y - half, 2 * (outer - wall), 2 * half);
  for (const side of [-1, 1]) glow(g, box + side * (inner + 0.5 * STOP * scale), y + 0.1 * half, Math.min(1.15 * half, HALF * scale * 3.6), shown.glow[side < 0 ? 0 : 1]);
  g.fillStyle = theme.box;
  g.fillRect(box - outer, top + wall / 2, wall, 2 * half + wall);
  g.fillRect(box + outer - wall, top + wall / 2, wall, half - slot + wall / 2);
  g.fillRect(box + outer - wall, y + slot, wall, half - slot + wall / 2);
  metal(g, box - outer, top, 2 * outer, wall, Math.min(4, wall / 2), theme.box);
  metal(g, box - outer, y + half, 2 * outer, wall, Math.min(4, wall / 2), theme.box);
  // The stops light up at impacts, and stay lit while the block rests at them.
  for (const side of [-1, 1]) {
    const hot = shown.side === side ? 1 : Math.min(1, shown.glow[side < 0 ? 0 : 1] * 1.4);
    const [a, b] = [rgb(theme.stop), rgb(theme.flash)], thick = STOP * scale;
    for (const [from, to] of [[-0.66, -0.3], [0.3, 0.66]]) {
      g.fillStyle = `rgb(${a.map((c, i) => Math.round(c + (b[i] - c) * hot)).join(" ")})`;
      g.beginPath(); g.roundRect(side < 0 ? box - inner - thick : box + inner, y + half * from, thick, half * (to - from), Math.min(2.5, thick / 3)); g.fill();
    }
  }
}

/** The block, with a trail that grows with its speed. @param {any} g @param {Layout} at @param {number} block @param {number} box @param {Shown} shown @param {number} size */
function drawBlock(g, at, block, box, shown, size) {
  const { scale, y, half } = at, w = HALF * scale, roller = Math.max(2, 0.04 * scale), tall = half * TALL, height = tall + half - 2 * roller;
  const trail = Math.min(0.9 * scale, Math.abs(shown.rate) * 0.045 * scale), away = -Math.sign(shown.rate), steps = 12;
  // The trail never leaves the box.
  const room = Math.max(0, away > 0 ? box + INNER * scale - block - w : block - w - box + INNER * scale), long = Math.min(trail, room);
  g.fillStyle = tinted(theme.block, 0.05);
  for (let i = 1; i <= steps && long > 2; i++) { const part = long * i / steps; g.fillRect(away > 0 ? block + w - 4 : block - w - part, y - tall + 2, part + 4, height - 2); }
  for (const d of [-0.55, 0.55]) wheel(g, block + d * w, y + half - roller, roller, (shown.x[1] - shown.x[0]) * scale);
  metal(g, block - w, y - tall, 2 * w, height, Math.min(5, w * 0.2), theme.block);
  label(g, "m₂", block, y - 0.35 * size, theme["on-body"], size);
  label(g, "block", block, y + 0.75 * size, theme["on-body"], Math.min(0.8 * size, 0.62 * w), 500);
  grip(g, block, y + half * 0.62);
}

/** Mark of a body that can be dragged. @param {any} g @param {number} x @param {number} y */
function grip(g, x, y) {
  g.strokeStyle = tinted(theme["on-body"], 0.6); g.lineWidth = 1.5;
  g.beginPath();
  for (const d of [-4, 0, 4]) { g.moveTo(x + d, y - 5); g.lineTo(x + d, y + 5); }
  g.stroke();
}

/** Sparks at the corner where a strike meets the stop, longer for a stronger one. @param {any} g @param {number} x @param {number} y @param {number} side @param {number} strength @param {number} unit */
function sparks(g, x, y, side, strength, unit) {
  if (strength < 0.04) return;
  g.strokeStyle = tinted(theme.spark, Math.min(1, 1.3 * strength)); g.lineWidth = 2.2; g.lineCap = "round";
  g.beginPath();
  for (const [angle, part] of [[0.2, 1], [0.66, 0.8], [1.15, 0.6]]) {
    const c = -side * Math.cos(angle), s = -Math.sin(angle), from = 0.3 * unit, to = from + unit * part * strength;
    g.moveTo(x + c * from, y + s * from); g.lineTo(x + c * to, y + s * to);
  }
  g.stroke();
}

/** The force on the box, on its lid. @param {any} g @param {number} box @param {number} top @param {number} inner @param {number} force */
function drawForce(g, box, top, inner, force) {
  const y = top - 17, most = Math.min(inner * 0.8, 92), tip = box + most * force, way = Math.sign(force);
  g.strokeStyle = theme.line; g.lineWidth = 1.5;
  g.beginPath(); g.moveTo(box - most, y); g.lineTo(box + most, y); g.stroke();
  g.strokeStyle = g.fillStyle = theme.ink; g.lineWidth = 4; g.lineCap = "butt";
  g.beginPath(); g.moveTo(box, top); g.lineTo(box, y); g.stroke();
  if (Math.abs(tip - box) > 9) { g.beginPath(); g.moveTo(box - 2 * way, y); g.lineTo(tip - way * 8, y); g.stroke(); }
  const head = Math.min(9, Math.abs(tip - box));
  g.beginPath(); g.moveTo(tip, y); g.lineTo(tip - way * head, y - 0.75 * head); g.lineTo(tip - way * head, y + 0.75 * head); g.closePath(); g.fill();
  label(g, "F₁₀ sin θ", box + most + 10, y, theme.soft, 12, 400, "left");
}

/** The oscillator, on wheels. @param {any} g @param {Layout} at @param {number} secondary @param {number} x3 @param {number} size */
function drawOscillator(g, at, secondary, x3, size) {
  const { scale, y, half, floor } = at, body = HALF * scale, tall = half * TALL;
  g.fillStyle = tinted(theme.ink, 0.06);
  g.beginPath(); g.roundRect(secondary - body, floor - 2, 2 * body, 4, 2); g.fill();
  for (const d of [-0.58, 0.58]) wheel(g, secondary + d * body, floor - at.wheel, at.wheel, x3 * scale);
  metal(g, secondary - body, y - tall, 2 * body, tall + half + WALL * scale, Math.min(5, body * 0.2), theme["drawn-secondary"]);
  label(g, "m₃", secondary, y, theme["on-body"], size);
  grip(g, secondary, y + half * 0.62);
  label(g, "oscillator", secondary, y - tall - 0.7 * size, theme.secondary, 0.86 * size);
}

/** Height of block and oscillator above their middle, as a fraction of half the box's height. */
const TALL = 0.72;

/** @param {any} g @param {number} width @param {number} height @param {Layout} at @param {Shown} shown */
export function drawMachine(g, width, height, at, shown) {
  const { scale, y, half, floor } = at, [x1, x2, x3] = shown.x;
  const box = at.box + x1 * scale, block = at.box + x2 * scale, secondary = at.secondary + x3 * scale;
  const inner = INNER * scale, outer = OUTER * scale, wall = WALL * scale, body = HALF * scale, tall = half * TALL;
  const size = Math.max(11, Math.min(17, scale * 0.2));
  g.lineCap = "round"; g.lineJoin = "round";
  drawGround(g, at);
  drawDisplacements(g, at, shown, width);
  const { k1, c1, k23, k3, c3 } = shown.parts;
  if (k1) spring(g, at.left - 2, box - outer, y - half * 0.42, 7, Math.min(12, half * 0.16));
  if (c1) damper(g, at.left - 2, box - outer, y + half * 0.48, at.box - outer, LEAST * scale, Math.min(11, half * 0.15));
  if (k23 && k3) spring(g, at.right + 2, secondary + body, y - half * 0.3, 7, Math.min(11, half * 0.15));
  if (k23 && c3) damper(g, at.right + 2, secondary + body, y + half * 0.48, at.secondary + body, LEAST * scale, Math.min(10, half * 0.14));
  drawBox(g, at, box, shown);
  if (k23) spring(g, block + body, secondary - body, y, 10, Math.min(8, half * 0.12));
  drawBlock(g, at, block, box, shown, size);
  if (k23) drawOscillator(g, at, secondary, x3, size);
  label(g, "m₁ box", box, y - half + size * 0.85, theme.box, 0.86 * size);
  // Light at the contact itself, over the bodies.
  for (const side of [-1, 1]) {
    const hot = shown.glow[side < 0 ? 0 : 1];
    if (hot > 0.02) { g.fillStyle = tinted(theme.flash, Math.min(1, hot * 1.2)); g.fillRect(box + side * inner - (side > 0 ? 3 : 0), y - tall, 3, tall + half * 0.9); }
    sparks(g, box + side * inner, y - tall - 1, side, hot, half * 0.24);
  }
  if (shown.held >= 0) {
    const [x, w, from, to] = [[box, outer, half + wall, half + wall], [block, body, tall, half], [secondary, body, tall, half + wall]][shown.held];
    g.strokeStyle = theme.here; g.lineWidth = 2; g.setLineDash([5, 4]);
    g.beginPath(); g.roundRect(x - w - 4, y - from - 4, 2 * w + 8, from + to + 8, 7); g.stroke();
    g.setLineDash([]);
  }
  drawForce(g, box, y - half - wall, inner, shown.force);
}

/** The body at a place: 0 box, 1 block, 2 oscillator, -1 none. @param {Layout} at @param {Shown} shown @param {number} px @param {number} py */
export function bodyAt(at, { x, parts }, px, py) {
  const { scale, half } = at, reach = HALF * scale + 8;
  if (Math.abs(py - at.y) > half + WALL * scale + 14) return -1;
  const near = py > at.y - half * TALL - 8;
  if (near && Math.abs(px - at.box - x[1] * scale) < reach) return 1;
  if (parts.k23 && near && Math.abs(px - at.secondary - x[2] * scale) < reach) return 2;
  return Math.abs(px - at.box - x[0] * scale) < OUTER * scale + 6 ? 0 : -1;
}
