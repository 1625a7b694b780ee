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

/** Number of values that are written without a pause, so that the page responds. */
const PIECE = 20_000;

/** The columns over time: ordinary rows, and the rows before and after each event; null if another run begins meanwhile. */
export async function runCsv() {
  const { machine, rows, width, count, begun } = run, wide = machine.columns.length, pieces = [new Blob([`${["time", ...machine.columns.map((c) => c.name)].join(",")}\n`])], step = Math.ceil(PIECE / wide);
  for (let from = 0; from < count; from += step) {
    let piece = "";
    for (let i = from; i < Math.min(count, from + step); i++) { const at = i * width; piece += `${[rows[at], ...rows.subarray(at + machine.head, at + machine.head + wide)].map(cell).join(",")}\n`; }
    pieces.push(new Blob([piece]));
    await new Promise((resolve) => setTimeout(resolve));
    if (run.begun !== begun) return null;
  }
  return new Blob(pieces, { type: "text/csv" });
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
