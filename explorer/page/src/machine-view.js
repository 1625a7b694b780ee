// The machine as in the documentation's sketch, in motion: lengths along the axis are to scale, so that the block really meets the stop.
import { FONT, rgb, theme } from "./plot.js";

/** Half the block's and the oscillator's width, the walls' thickness; in units of L, as in the sketch. */
const HALF = 0.31, WALL = 0.125;
/** The least length of the springs to the ground. */
const LEAST = 0.42;

/** @typedef {{scale: number, y: number, box: number, secondary: number, left: number, right: number, half: number}} Layout */
/**
 * @typedef {object} Shown
 * @property {number[]} x x1, x2, x3 in L
 * @property {number} force sine of the drive's phase
 * @property {number} side the stop at which the block rests, or 0
 * @property {[number, number]} glow of the lower and the upper stop, 0 to 1
 * @property {number} held the body that is dragged or chosen, -1 for none
 * @property {number[]} extent largest displacements and largest x1 - x3
 */

/** The places of the bodies at rest. @param {number} width @param {number} height @param {number[]} extent @returns {Layout} */
export function layout(width, height, extent) {
  const [x1, , x3, apart] = extent;
  // The box swings clear of the ground, the oscillator of the box and of the other ground.
  const before = 1 + HALF + WALL + LEAST + x1, after = HALF + LEAST + x3;
  const between = 1 + 2 * HALF + WALL + Math.max(0.7, 0.3 + apart);
  const total = before + between + after, margin = 16;
  const scale = (width - 2 * margin) / total;
  const half = Math.min((height - 96) / 2 - WALL * scale, Math.max(scale * 1.25, 78));
  return { scale, y: 52 + (height - 96) / 2, box: margin + before * scale, secondary: margin + (before + between) * scale, left: margin, right: width - margin, half };
}

/** @param {any} g @param {number} from @param {number} to @param {number} y @param {number} turns @param {number} height */
function spring(g, from, to, y, turns, height) {
  const lead = Math.min(12, Math.abs(to - from) * 0.14), length = to - from - 2 * lead;
  g.beginPath();
  g.moveTo(from, y);
  g.lineTo(from + lead, y);
  const steps = turns * 16;
  for (let i = 1; i < steps; i++) {
    const s = i / steps, fade = Math.min(1, 8 * s, 8 * (1 - s));
    g.lineTo(from + lead + length * s, y - height * fade * Math.sin(2 * Math.PI * turns * s));
  }
  g.lineTo(to - lead, y);
  g.lineTo(to, y);
  g.stroke();
}

/** A dashpot whose cup stands on the ground and whose rod goes with the body; the cup takes up what the body leaves free. @param {any} g @param {number} ground @param {number} body @param {number} y @param {number} rest @param {number} free @param {number} height */
function damper(g, ground, body, y, rest, free, height) {
  const way = Math.sign(rest - ground), length = Math.abs(rest - ground);
  const cup = ground + way * free * 0.16, mouth = ground + way * Math.min(free * 0.86, length * 0.7);
  const share = Math.max(0.06, Math.min(0.94, 0.5 + 0.44 * way * (body - rest) / Math.max(1, length - free)));
  const piston = cup + (mouth - cup) * share;
  g.beginPath();
  g.moveTo(ground, y); g.lineTo(cup, y);
  g.moveTo(mouth, y - height); g.lineTo(cup, y - height); g.lineTo(cup, y + height); g.lineTo(mouth, y + height);
  g.moveTo(piston, y - height + 2.5); g.lineTo(piston, y + height - 2.5);
  g.moveTo(piston, y); g.lineTo(body, y);
  g.stroke();
}

const tinted = (/** @type {string} */ colour, /** @type {number} */ alpha) => { const [r, g, b] = rgb(colour); return `rgb(${r} ${g} ${b} / ${alpha.toFixed(3)})`; };

/** @param {any} g @param {number} x @param {number} y @param {number} r @param {number} strength */
function glow(g, x, y, r, strength) {
  if (strength < 0.01 || !g.createRadialGradient) return;
  const light = g.createRadialGradient(x, y, 0, x, y, r);
  light.addColorStop(0, tinted(theme.flash, 0.95 * strength));
  light.addColorStop(0.35, tinted(theme.flash, 0.45 * strength));
  light.addColorStop(1, tinted(theme.flash, 0));
  g.fillStyle = light;
  g.beginPath(); g.arc(x, y, r, 0, 2 * Math.PI); g.fill();
}

/** @param {any} g @param {string} text @param {number} x @param {number} y @param {string} colour @param {number} size */
function label(g, text, x, y, colour, size) {
  g.fillStyle = colour; g.font = `600 ${size.toFixed(1)}px ${FONT}`; g.textAlign = "center"; g.textBaseline = "middle";
  g.fillText(text, x, y);
}

/** @param {any} g @param {number} width @param {number} height @param {Layout} at @param {Shown} shown */
export function drawMachine(g, width, height, at, shown) {
  const { scale, y, half } = at, [x1, x2, x3] = shown.x;
  const box = at.box + x1 * scale, block = at.box + x2 * scale, secondary = at.secondary + x3 * scale;
  const inner = (1 + HALF) * scale, wall = WALL * scale, body = HALF * scale;
  const floor = y + half + wall + 12, size = Math.max(11, Math.min(17, scale * 0.2));
  g.lineCap = "round"; g.lineJoin = "round";
  // The ground: floor and two walls.
  g.fillStyle = theme.line;
  g.fillRect(at.left - 10, y - half - wall - 6, 8, floor - (y - half - wall - 6));
  g.fillRect(at.right + 2, y - half - wall - 6, 8, floor - (y - half - wall - 6));
  g.fillRect(at.left - 10, floor, at.right - at.left + 20, 3);
  // Places at rest, and how far each body is from its own.
  for (const [rest, now, colour] of /** @type {const} */ ([[at.box, box, theme.box], [at.box, block, theme.block], [at.secondary, secondary, theme["drawn-secondary"]]])) {
    const row = floor + (now === block ? 19 : 11);
    g.strokeStyle = theme.faint; g.lineWidth = 1;
    g.beginPath(); g.moveTo(rest, floor + 6); g.lineTo(rest, floor + 24); g.stroke();
    g.strokeStyle = colour; g.lineWidth = 3;
    g.beginPath(); g.moveTo(rest, row); g.lineTo(now, row); g.stroke();
  }
  // Springs and dampers to the ground.
  g.strokeStyle = theme.soft; g.lineWidth = 2;
  const left = box - inner - wall;
  spring(g, at.left - 2, left, y - half * 0.45, 5, Math.min(11, half * 0.16));
  damper(g, at.left - 2, left, y + half * 0.5, at.box - inner - wall, LEAST * scale, Math.min(13, half * 0.17));
  spring(g, secondary + body, at.right + 2, y - half * 0.3, 5, Math.min(11, half * 0.16));
  damper(g, at.right + 2, secondary + body, y + half * 0.32, at.secondary + body, LEAST * scale, Math.min(12, half * 0.15));
  // Shadows on the floor.
  for (const [x, w] of [[box, inner + wall], [secondary, body]]) {
    g.fillStyle = tinted(theme.ink, 0.07);
    g.beginPath(); g.roundRect(x - w, floor - 3, 2 * w, 4, 2); g.fill();
  }
  // The glow of the stops, behind the bodies.
  const contact = y;
  glow(g, box - inner, contact, body * 2.6, shown.glow[0]);
  glow(g, box + inner, contact, body * 2.6, shown.glow[1]);
  // The box, with an opening for the coupling spring.
  g.fillStyle = theme.box;
  const top = y - half - wall, slot = half * 0.2;
  g.beginPath(); g.roundRect(left, top, 2 * (inner + wall), wall, Math.min(4, wall / 2)); g.fill();
  g.beginPath(); g.roundRect(left, y + half, 2 * (inner + wall), wall, Math.min(4, wall / 2)); g.fill();
  g.fillRect(left, top + wall / 2, wall, 2 * half + wall);
  g.fillRect(box + inner, top + wall / 2, wall, half - slot + wall / 2);
  g.fillRect(box + inner, y + slot, wall, half - slot + wall / 2);
  // The stops themselves.
  for (const side of [-1, 1]) {
    const hot = shown.glow[side < 0 ? 0 : 1], rests = shown.side === side;
    const [a, b] = [rgb(theme.soft), rgb(theme.flash)], mix = Math.min(1, hot * 1.5);
    g.fillStyle = rests ? theme.flash : `rgb(${a.map((c, i) => Math.round(c + (b[i] - c) * mix)).join(" ")})`;
    const thick = Math.max(3, wall * 0.42), x = side < 0 ? box - inner - thick : box + inner;
    for (const at of [-0.62, 0.34]) g.fillRect(x, y + half * at, thick, half * 0.28);
  }
  // The wheels on which the box runs.
  g.fillStyle = theme.soft;
  for (const x of [box - inner * 0.7, box + inner * 0.7, secondary - body * 0.55, secondary + body * 0.55]) {
    const r = Math.max(2.5, (floor - y - half - wall) / 2);
    g.beginPath(); g.arc(x, floor - r, r, 0, 2 * Math.PI); g.fill();
  }
  // The rail of the block.
  g.strokeStyle = tinted(theme.ink, 0.13); g.lineWidth = 1.5;
  g.beginPath(); g.moveTo(box - inner, y + half * 0.72); g.lineTo(box + inner, y + half * 0.72); g.stroke();
  // The coupling spring, through the opening.
  g.strokeStyle = theme.soft; g.lineWidth = 2;
  spring(g, block + body, secondary - body, y, 8, Math.min(9, half * 0.13));
  // Block and oscillator.
  const tall = half * 0.7;
  g.fillStyle = theme.block;
  g.beginPath(); g.roundRect(block - body, y - tall, 2 * body, 2 * tall, Math.min(5, body * 0.2)); g.fill();
  g.fillStyle = theme["drawn-secondary"];
  g.beginPath(); g.roundRect(secondary - body, y - tall, 2 * body, 2 * tall, Math.min(5, body * 0.2)); g.fill();
  g.fillRect(secondary - body * 0.75, y + tall - 2, body * 1.5, floor - y - tall - 4);
  // Light at the contact itself, over the bodies.
  for (const side of [-1, 1]) {
    const hot = shown.glow[side < 0 ? 0 : 1];
    if (hot > 0.02) { g.fillStyle = tinted(theme.flash, Math.min(1, hot * 1.2)); g.fillRect(box + side * inner - (side > 0 ? 2.5 : 0), y - tall, 2.5, 2 * tall); }
  }
  if (shown.held >= 0) {
    const [x, w, h] = [[box, inner + wall, half + wall], [block, body, tall], [secondary, body, tall]][shown.held];
    g.strokeStyle = theme.here; g.lineWidth = 2; g.setLineDash([5, 4]);
    g.beginPath(); g.roundRect(x - w - 4, y - h - 4, 2 * w + 8, 2 * h + 8, 7); g.stroke();
    g.setLineDash([]);
  }
  label(g, "m₁", box - inner + size * 1.1, top + wall + size * 0.85, theme.box, size);
  label(g, "m₂", block, y, theme["on-body"], size);
  label(g, "m₃", secondary, y, theme["on-body"], size);
  // The drive, on the lid of the box.
  const arrow = Math.max(12, top - 24), reachOf = Math.min(inner * 0.75, 90) * shown.force;
  g.strokeStyle = g.fillStyle = theme.ink; g.lineWidth = 2.5;
  g.beginPath(); g.moveTo(box, top - 2); g.lineTo(box, arrow); g.lineTo(box + reachOf, arrow); g.stroke();
  if (Math.abs(reachOf) > 5) {
    const d = Math.sign(reachOf), tip = box + reachOf + d * 5;
    g.beginPath(); g.moveTo(tip, arrow); g.lineTo(tip - d * 9, arrow - 5); g.lineTo(tip - d * 9, arrow + 5); g.closePath(); g.fill();
  }
  g.font = `12px ${FONT}`; g.textAlign = "left"; g.textBaseline = "middle"; g.fillStyle = theme.soft;
  g.fillText("F₁₀ sin θ", box + Math.min(inner * 0.75, 90) + 14, arrow);
}

/** The body at a place: 0 box, 1 block, 2 oscillator, -1 none. @param {Layout} at @param {number[]} x @param {number} px @param {number} py */
export function bodyAt(at, x, px, py) {
  const { scale, half } = at, reach = HALF * scale + 8;
  if (Math.abs(py - at.y) > half + WALL * scale + 12) return -1;
  const near = Math.abs(py - at.y) < half * 0.75 + 8;
  if (near && Math.abs(px - at.box - x[1] * scale) < reach) return 1;
  if (near && Math.abs(px - at.secondary - x[2] * scale) < reach) return 2;
  return Math.abs(px - at.box - x[0] * scale) < (1 + HALF + WALL) * scale + 6 ? 0 : -1;
}
