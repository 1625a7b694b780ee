// A drawing context that writes SVG: the part of Canvas 2D that the panels use.

const number = (/** @type {number} */ x) => String(Math.round(x * 100) / 100);
const escape = (/** @type {string} */ t) => t.replace(/[&<>"]/g, (c) => `&#${c.charCodeAt(0)};`);

export class SvgContext {
  /** @param {number} width @param {number} height */
  constructor(width, height) {
    this.width = width;
    this.height = height;
    this.body = "";
    this.defs = "";
    this.path = "";
    this.open = 0;
    this.clips = 0;
    /** @type {{groups: number, style: object}[]} */
    this.stack = [];
    this.fillStyle = "#000"; this.strokeStyle = "#000"; this.lineWidth = 1; this.globalAlpha = 1;
    this.font = "12px sans-serif"; this.textAlign = "start"; this.textBaseline = "alphabetic"; this.lineCap = "butt"; this.lineJoin = "miter";
    /** @type {number[]} */
    this.dash = [];
  }
  style() {
    const { fillStyle, strokeStyle, lineWidth, globalAlpha, font, textAlign, textBaseline, lineCap, lineJoin, dash } = this;
    return { fillStyle, strokeStyle, lineWidth, globalAlpha, font, textAlign, textBaseline, lineCap, lineJoin, dash };
  }
  save() { this.stack.push({ groups: this.open, style: this.style() }); }
  restore() {
    const last = this.stack.pop();
    if (!last) return;
    for (; this.open > last.groups; this.open--) this.body += "</g>\n";
    Object.assign(this, last.style);
  }
  group(/** @type {string} */ attributes) { this.body += `<g ${attributes}>\n`; this.open++; }
  translate(/** @type {number} */ x, /** @type {number} */ y) { this.group(`transform="translate(${number(x)} ${number(y)})"`); }
  rotate(/** @type {number} */ a) { this.group(`transform="rotate(${number(a * 180 / Math.PI)})"`); }
  clip() { const id = `c${++this.clips}`; this.defs += `<clipPath id="${id}"><path d="${this.path}"/></clipPath>`; this.group(`clip-path="url(#${id})"`); }
  setLineDash(/** @type {number[]} */ dash) { this.dash = dash; }
  beginPath() { this.path = ""; }
  closePath() { this.path += "Z"; }
  moveTo(/** @type {number} */ x, /** @type {number} */ y) { this.path += `M${number(x)} ${number(y)}`; }
  lineTo(/** @type {number} */ x, /** @type {number} */ y) { this.path += `${this.path ? "L" : "M"}${number(x)} ${number(y)}`; }
  rect(/** @type {number} */ x, /** @type {number} */ y, /** @type {number} */ w, /** @type {number} */ h) { this.path += `M${number(x)} ${number(y)}h${number(w)}v${number(h)}h${number(-w)}Z`; }
  roundRect(/** @type {number} */ x, /** @type {number} */ y, /** @type {number} */ w, /** @type {number} */ h, /** @type {number} */ r) {
    const n = number, a = `a${n(r)} ${n(r)} 0 0 1 `;
    this.path += `M${n(x + r)} ${n(y)}h${n(w - 2 * r)}${a}${n(r)} ${n(r)}v${n(h - 2 * r)}${a}${n(-r)} ${n(r)}h${n(2 * r - w)}${a}${n(-r)} ${n(-r)}v${n(2 * r - h)}${a}${n(r)} ${n(-r)}Z`;
  }
  arc(/** @type {number} */ x, /** @type {number} */ y, /** @type {number} */ r) { const n = number; this.path += `M${n(x - r)} ${n(y)}a${n(r)} ${n(r)} 0 1 0 ${n(2 * r)} 0a${n(r)} ${n(r)} 0 1 0 ${n(-2 * r)} 0Z`; }
  paint(/** @type {string} */ d, /** @type {string} */ how) { this.body += `<path d="${d}" ${how}${this.globalAlpha < 1 ? ` opacity="${number(this.globalAlpha)}"` : ""}/>\n`; }
  fill() { this.paint(this.path, `fill="${this.fillStyle}"`); }
  stroke() {
    const dash = this.dash.length ? ` stroke-dasharray="${this.dash.join(" ")}"` : "";
    this.paint(this.path, `fill="none" stroke="${this.strokeStyle}" stroke-width="${number(this.lineWidth)}" stroke-linecap="${this.lineCap}" stroke-linejoin="${this.lineJoin}"${dash}`);
  }
  fillRect(/** @type {number} */ x, /** @type {number} */ y, /** @type {number} */ w, /** @type {number} */ h) { this.paint(`M${number(x)} ${number(y)}h${number(w)}v${number(h)}h${number(-w)}Z`, `fill="${this.fillStyle}"`); }
  clearRect() {}
  measureText(/** @type {string} */ text) { return { width: text.length * parseFloat(this.font.match(/[\d.]+(?=px)/)?.[0] ?? "12") * 0.56 }; }
  fillText(/** @type {string} */ text, /** @type {number} */ x, /** @type {number} */ y) {
    const size = parseFloat(this.font.match(/[\d.]+(?=px)/)?.[0] ?? "12");
    const anchor = { center: "middle", right: "end", end: "end" }[this.textAlign] ?? "start";
    const shift = { middle: 0.35, top: 0.8, hanging: 0.8, bottom: -0.2 }[this.textBaseline] ?? 0;
    this.body += `<text x="${number(x)}" y="${number(y + shift * size)}" font-size="${size}" fill="${this.fillStyle}" text-anchor="${anchor}"${/(^|\s)(600|bold)/.test(this.font) ? ' font-weight="600"' : ""}>${escape(text)}</text>\n`;
  }
  drawImage(/** @type {HTMLCanvasElement} */ image, /** @type {number} */ x, /** @type {number} */ y, /** @type {number} */ w, /** @type {number} */ h) {
    this.body += `<image x="${number(x)}" y="${number(y)}" width="${number(w)}" height="${number(h)}" href="${image.toDataURL()}"/>\n`;
  }
  /** A glow, which SVG files leave out. */
  createRadialGradient() { return { addColorStop() {}, toString: () => "none" }; }
  text() {
    while (this.stack.length) this.restore();
    return `<svg xmlns="http://www.w3.org/2000/svg" width="${this.width}" height="${this.height}" viewBox="0 0 ${this.width} ${this.height}" font-family="system-ui, DejaVu Sans, sans-serif"><defs>${this.defs}</defs>\n${this.body}</svg>\n`;
  }
}
