// Axes and curves on a canvas. Every panel draws with a context, which may also write an SVG file.

/** Colours by meaning, from the style sheet. */
export const theme = /** @type {Record<string, string>} */ ({});
const NAMES = ["paper", "card", "ink", "soft", "faint", "line", "grid", "box", "block", "secondary", "relative", "falling", "drawn-secondary", "here", "flash", "spark", "stop", "on-body"];

/** @param {string[]} more names that one page alone has */
export function readTheme(more = []) {
  const style = getComputedStyle(document.documentElement);
  for (const name of [...NAMES, ...more]) theme[name] = style.getPropertyValue(`--${name}`).trim();
}

/** The three numbers of a colour. @param {string} colour @returns {[number, number, number]} */
export function rgb(colour) {
  const hex = colour.match(/^#(..)(..)(..)$/);
  if (hex) return [parseInt(hex[1], 16), parseInt(hex[2], 16), parseInt(hex[3], 16)];
  const [r, g, b] = (colour.match(/[\d.]+/g) ?? ["0", "0", "0"]).map(Number);
  return [r, g, b];
}

export const FONT = "-apple-system, 'Segoe UI', Roboto, system-ui, sans-serif";

/** A canvas that follows the size of its element, in CSS pixels. */
export class Surface {
  /** @param {string} id */
  constructor(id) {
    this.canvas = /** @type {HTMLCanvasElement} */ (document.getElementById(id));
    this.context = /** @type {CanvasRenderingContext2D} */ (this.canvas.getContext("2d"));
    this.width = 0;
    this.height = 0;
    this.ratio = 1;
    this.changed = true;
  }
  /** Adopts the element's size; returns whether it has changed. */
  fit() {
    const { clientWidth: w, clientHeight: h } = this.canvas, ratio = Math.min(3, devicePixelRatio || 1);
    if (w === this.width && h === this.height && ratio === this.ratio) return false;
    [this.width, this.height, this.ratio] = [w, h, ratio];
    this.canvas.width = Math.max(1, Math.round(w * ratio));
    this.canvas.height = Math.max(1, Math.round(h * ratio));
    return true;
  }
  begin() {
    this.context.setTransform(this.ratio, 0, 0, this.ratio, 0, 0);
    this.context.clearRect(0, 0, this.width, this.height);
    return this.context;
  }
}

/** Round numbers between two, about `most` of them. @param {number} low @param {number} high @param {number} most */
export function ticks(low, high, most) {
  const rough = (high - low) / Math.max(1, most);
  if (!(rough > 0) || !Number.isFinite(rough)) return [];
  const power = 10 ** Math.floor(Math.log10(rough));
  const step = [1, 2, 5, 10].map((f) => f * power).find((s) => s >= rough * 0.999) ?? 10 * power;
  const found = [];
  for (let i = Math.ceil(low / step - 1e-9); i * step <= high + 1e-9 * step; i++) found.push(i * step);
  return found;
}

/** A number as an axis shows it. @param {number} x @param {number} span */
export function short(x, span) {
  const digits = Math.max(0, Math.min(8, 1 - Math.floor(Math.log10(span || 1))));
  const text = Math.abs(x) >= 1e5 ? x.toExponential(1) : x.toFixed(digits);
  return (text.includes(".") ? text.replace(/\.?0+$/, "") : text).replace(/^-0$/, "0").replace("-", "−");
}

/** @typedef {{label: string, factor: number}} Axis the words at an axis, and how many of its unit one unit of the data is */

/** A frame with linear axes. */
export class Frame {
  /** @param {[number, number]} x @param {[number, number]} y @param {{left: number, right: number, top: number, bottom: number}} box in pixels */
  constructor(x, y, box) {
    Object.assign(this, { x, y, box });
    this.x = x; this.y = y; this.box = box;
    /** Factors from data units to the displayed units, for both axes. */
    this.fx = 1; this.fy = 1;
    this.sx = (box.right - box.left) / (x[1] - x[0]);
    this.sy = (box.top - box.bottom) / (y[1] - y[0]);
  }
  px(/** @type {number} */ x) { return this.box.left + (x - this.x[0]) * this.sx; }
  py(/** @type {number} */ y) { return this.box.bottom + (y - this.y[0]) * this.sy; }
  ux(/** @type {number} */ p) { return this.x[0] + (p - this.box.left) / this.sx; }
  uy(/** @type {number} */ p) { return this.y[0] + (p - this.box.bottom) / this.sy; }
  /** Draws grid, numbers and words; an axis with a factor has numbers in its own unit. @param {any} g @param {{x?: string | Axis, y?: string | Axis, xTicks?: boolean, yTicks?: number}} [axes] */
  axes(g, axes = {}) {
    const { left, right, top, bottom } = this.box, of = (/** @type {string | Axis | undefined} */ axis) => (typeof axis === "object" ? axis : { label: axis, factor: 1 });
    const { label: wordsX, factor: fx } = of(axes.x), { label: wordsY, factor: fy } = of(axes.y), words = { ...axes, x: wordsX, y: wordsY };
    [this.fx, this.fy] = [fx, fy];
    g.lineWidth = 1; g.font = `11px ${FONT}`;
    const inUnit = (/** @type {[number, number]} */ [low, high], /** @type {number} */ f, /** @type {number} */ most) => ticks(low * f, high * f, most).map((t) => t / f);
    const across = inUnit(this.x, fx, (right - left) / 70), along = inUnit(this.y, fy, words.yTicks ?? (bottom - top) / 32), bare = words.yTicks === 0;
    g.strokeStyle = theme.grid;
    g.beginPath();
    for (const x of across) { g.moveTo(this.px(x), top); g.lineTo(this.px(x), bottom); }
    for (const y of along) { g.moveTo(left, this.py(y)); g.lineTo(right, this.py(y)); }
    g.stroke();
    g.fillStyle = theme.soft; g.textAlign = "center"; g.textBaseline = "top";
    if (words.xTicks !== false) {
      for (const x of across) if (!words.x || this.px(x) < right - 8 - g.measureText(words.x).width) g.fillText(short(x * fx, (this.x[1] - this.x[0]) * fx / 5), this.px(x), bottom + 5);
    }
    g.textAlign = "right"; g.textBaseline = "middle";
    for (const y of bare ? [] : along) g.fillText(short(y * fy, (this.y[1] - this.y[0]) * fy / 4), left - 6, this.py(y));
    g.textBaseline = "top"; g.fillStyle = theme.ink;
    if (words.x) { g.textAlign = "right"; g.fillText(words.x, right, bottom + 5); }
    if (words.y) { g.textAlign = "left"; g.textBaseline = "middle"; g.fillText(words.y, 6, top - 10); }
  }
  /** Draws inside the frame alone. @param {any} g @param {() => void} draw */
  inside(g, draw) {
    g.save();
    g.beginPath();
    g.rect(this.box.left, this.box.top, this.box.right - this.box.left, this.box.bottom - this.box.top);
    g.clip();
    draw();
    g.restore();
  }
}

/** What a place in a panel means: both coordinates, at the pointer. @param {any} g @param {Frame[]} frames @param {number} px @param {number} py */
export function readout(g, frames, px, py) {
  const frame = frames.find(({ box }) => px >= box.left && px <= box.right && py >= box.top && py <= box.bottom);
  if (!frame) return;
  const text = `${short(frame.ux(px) * frame.fx, (frame.x[1] - frame.x[0]) * frame.fx / 300)}, ${short(frame.uy(py) * frame.fy, (frame.y[1] - frame.y[0]) * frame.fy / 300)}`;
  g.font = `11px ${FONT}`;
  const wide = g.measureText(text).width + 10, left = px + 12 + wide > frame.box.right ? px - 12 - wide : px + 12, top = Math.max(frame.box.top, py - 24);
  g.globalAlpha = 0.9; g.fillStyle = theme.card;
  g.beginPath(); g.roundRect(left, top, wide, 18, 5); g.fill();
  g.globalAlpha = 1; g.fillStyle = theme.ink; g.textAlign = "left"; g.textBaseline = "middle";
  g.fillText(text, left + 5, top + 9.5);
}

/** The least range that holds all finite numbers, with some air; around numbers that are alike one in which its numbers can be told apart. @param {Iterable<number>} numbers @param {number} air @returns {[number, number]} */
export function reach(numbers, air = 0.06) {
  let low = Infinity, high = -Infinity;
  for (const x of numbers) { if (x < low) low = x; if (x > high) high = x; }
  if (!(low <= high)) return [-1, 1];
  const size = Math.max(Math.abs(low), Math.abs(high)), more = high - low > 1e-4 * size ? (high - low) * air : 0.05 * size || 1;
  return [low - more, high + more];
}
