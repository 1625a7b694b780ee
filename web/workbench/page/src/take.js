// Downloads: the file, tables, pictures, FMUs.
import { SvgContext } from "../../../explorer/page/src/svg.js";
import { theme } from "../../../explorer/page/src/plot.js";
import { run } from "./run.js";

/** @param {string} name @param {Blob} content */
export function save(name, content) {
  const link = document.createElement("a");
  link.href = URL.createObjectURL(content);
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 5000);
}

/** A cell: every number reads back to the same double. @param {number} x */
const cell = (x) => (Number.isFinite(x) ? String(x) : "");

/** The columns over time: ordinary rows, and the rows before and after each event. */
export function runCsv() {
  const { machine, rows, width, count } = run, wide = machine.columns.length, lines = [["time", ...machine.columns.map((c) => c.name)].join(",")];
  for (let i = 0; i < count; i++) { const at = i * width; lines.push([rows[at], ...rows.subarray(at + machine.head, at + machine.head + wide)].map(cell).join(",")); }
  return `${lines.join("\n")}\n`;
}

export function eventsCsv() {
  const { machine, events } = run, section = new Map(machine.elements.map((e) => [e.name, e.section]));
  const line = (/** @type {import("./run.js").Met} */ m) => [cell(m.time), m.kind, m.element && `${section.get(m.element)}.${m.element}`, cell(m.value), m.stops ? String(m.stops) : "", cell(m.impulse)].join(",");
  return `${["time,kind,element,value,stops,impulse", ...events.map(line)].join("\n")}\n`;
}

/** A picture as SVG. @param {number} w @param {number} h @param {(g: any) => void} draw */
export function svg(w, h, draw) {
  const g = new SvgContext(w, h);
  g.fillStyle = theme.card; g.fillRect(0, 0, w, h);
  draw(g);
  return new Blob([g.text()], { type: "image/svg+xml" });
}

/** A picture as PNG, three times as fine as on the page. @param {number} w @param {number} h @param {(g: any) => void} draw @returns {Promise<Blob>} */
export function png(w, h, draw) {
  const canvas = document.createElement("canvas");
  canvas.width = 3 * w; canvas.height = 3 * h;
  const g = /** @type {CanvasRenderingContext2D} */ (canvas.getContext("2d"));
  g.scale(3, 3); g.fillStyle = theme.card; g.fillRect(0, 0, w, h);
  draw(g);
  return new Promise((resolve) => canvas.toBlob((blob) => resolve(/** @type {Blob} */ (blob))));
}
