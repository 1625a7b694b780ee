// Exports: pictures, tables, parameter files.
import { ROW } from "./core.js";
import { diagram, drawDiagram } from "./diagram.js";
import { layout, drawMachine } from "./machine-view.js";
import { motion } from "./motion.js";
import { curves, manifoldRows, drawHistory, drawPortrait, drawResponse, drawSection } from "./panels.js";
import { theme } from "./plot.js";
import { PARAMETERS, set, startSi, state, toHash } from "./state.js";
import { SvgContext } from "./svg.js";

/** @param {string} name @param {Blob | string} content @param {string} type */
function save(name, content, type) {
  const link = document.createElement("a");
  link.href = URL.createObjectURL(typeof content === "string" ? new Blob([content], { type }) : content);
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 5000);
}

/** @param {string} figure @param {any} g @param {number} w @param {number} h @param {number} ratio @param {import("./machine-view.js").Shown} shown */
function draw(figure, g, w, h, ratio, shown) {
  g.fillStyle = theme.card;
  g.fillRect(0, 0, w, h);
  if (figure === "history") drawHistory(g, w, h);
  else if (figure === "portrait") drawPortrait(g, w, h);
  else if (figure === "poincare") drawSection(g, w, h, ratio);
  else if (figure === "response") drawResponse(g, w, h);
  else if (figure === "machine") drawMachine(g, w, h, layout(w, h, shown.extent, !shown.parts.k23), shown);
  else drawDiagram(g, w, h, ratio, true);
}

const note = () => `${state.strong ? "the strongly coupled set chosen for this program" : "the default set, a reconstruction"}${state.set.length ? ` with ${state.set.map(([n, v]) => `${n} = ${v}`).join(", ")}` : ""}`;

/** The numbers of a figure as CSV. @param {string} figure */
export function table(figure) {
  const lines = [`# ${note()}`];
  const rows = (/** @type {string[]} */ names, /** @type {ArrayLike<number>} */ data, /** @type {number} */ width) => {
    lines.push(names.join(","));
    for (let i = 0; i + width <= data.length; i += width) lines.push(Array.prototype.slice.call(data, i, i + names.length).map((x) => (Number.isNaN(x) ? "" : x)).join(","));
  };
  const motionNames = ["time (s)", "x1 (m)", "x2 (m)", "x3 (m)", "v1 (m/s)", "v2 (m/s)", "v3 (m/s)", "w (m)", "w' (m/s)", "drive phase (rad)"];
  if (figure === "history" || figure === "machine") rows(motionNames, motion.rows.subarray(0, motion.count * ROW), ROW);
  else if (figure === "portrait") rows(motionNames, motion.settled, ROW);
  else if (figure === "poincare") rows(state.section === "strobe" ? ["w (m)", "w' (m/s)", "x1 (m)", "v1 (m/s)"] : ["drive phase (rad)", "approach speed with the stop's sign (m/s)", "x1 (m)", "v1 (m/s)"], motion.points, 4);
  else if (figure === "response" && state.theory === "manifold") rows(["C/L", "B/L", "passes all tests", "0: curve, 1: P1, 2: P2"], manifoldRows().rows, 4);
  else if (figure === "response") {
    for (const theory of /** @type {const} */ (["exact", "scales", "strong"])) if (curves[theory].length) { lines.push(`# ${theory}`); rows([state.along, "A1/L", "A2/L", "A3/L", "stable"], curves[theory], 5); }
  } else {
    lines.push(`direction,${state.along},${state.ordinate}`);
    for (const which of /** @type {const} */ (["rising", "falling"])) diagram.found[which].forEach((found, i) => {
      const value = state.range[0] + (state.range[1] - state.range[0]) * (i + 0.5) / diagram.columns;
      for (let k = 6; found && k < found.length; k++) lines.push(`${which},${value},${found[k]}`);
    });
  }
  return lines.join("\n") + "\n";
}

/** A parameter file of `vibro`. */
export function toml() {
  const physical = PARAMETERS.filter((p) => !p.group).map((p) => `${p.name} = ${decimal(set.value(p.name))} # ${p.symbol}, ${p.unit}`);
  return `# ${note()}\n[si]\n${physical.join("\n")}\n`;
}

/** TOML and Python read a number with a point as a real one. @param {number} x */
const decimal = (x) => (/[.e]/.test(String(x)) ? String(x) : `${x}.0`);

/** Start values for fmpy. */
export function startValues() {
  const names = ["box.s", "block.s", "secondary.s", "box.v", "block.v", "secondary.v"], start = startSi();
  const lines = PARAMETERS.filter((p) => !p.group).map((p) => [p.name, set.value(p.name)]).concat(names.map((name, i) => [name, start[i]]));
  return `start_values = {\n${lines.map(([n, v]) => `    "${n}": ${decimal(Number(v))},`).join("\n")}\n}\n`;
}

/** @param {string} kind @param {string} figure @param {{width: number, height: number}} size @param {import("./machine-view.js").Shown} shown */
export async function take(kind, figure, { width, height }, shown) {
  const name = `vibro-${figure}`;
  if (kind === "csv") save(`${name}.csv`, table(figure), "text/csv");
  else if (kind === "svg") {
    const g = new SvgContext(width, height);
    draw(figure, g, width, height, 2, shown);
    save(`${name}.svg`, g.text(), "image/svg+xml");
  } else if (kind === "png") {
    const canvas = document.createElement("canvas"), ratio = 3;
    canvas.width = width * ratio; canvas.height = height * ratio;
    const g = /** @type {CanvasRenderingContext2D} */ (canvas.getContext("2d"));
    g.scale(ratio, ratio);
    draw(figure, g, width, height, ratio, shown);
    const blob = await new Promise((resolve) => canvas.toBlob(resolve));
    save(`${name}.png`, /** @type {Blob} */ (blob), "image/png");
  } else if (kind === "toml") save("machine.toml", toml(), "application/toml");
  else if (kind === "fmpy") {
    save("start_values.py", startValues(), "text/x-python");
  } else {
    const link = `${location.href.split("#")[0]}#${toHash()}`;
    try { await navigator.clipboard.writeText(link); return "The link is copied; it holds the whole view."; } catch { return link; }
  }
  return "Saved.";
}
