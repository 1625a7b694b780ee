// Curves and pictures that take a bounded time for each frame of the page, however many rows or
// events a run has.
import { reach } from "../../../explorer/page/src/plot.js";

/** Number of intervals of a thinned curve: about one for each pixel of its panel. */
export const INTERVALS = 700;
/** Number of points in an interval up to which a curve is not thinned. */
const FEW = 4;
/** Time for the further pieces of all growing pictures in one frame, ms. */
const BUDGET = 8;
/** Number of items in a piece: the time for a path's stroke grows faster than its length. */
export const PIECE = 200;

/** Points of a curve over ascending times that its picture needs: the first and the last, and the least and the largest of each interval. A line through them covers the same height in each interval as a line through all points. */
export class Thin {
  /** @param {number} from @param {number} to */
  constructor(from, to) {
    this.from = from;
    this.scale = INTERVALS / (to - from);
    this.count = 0;
    this.low = this.high = this.interval = NaN;
    /** Indices of the least and the largest point of each interval. @type {[number, number][]} */
    this.kept = [];
  }
  /** Takes the next point. @param {number} time @param {number} value */
  add(time, value) {
    const i = this.count++, interval = Math.floor((time - this.from) * this.scale), own = this.kept[this.kept.length - 1];
    if (interval !== this.interval) {
      this.interval = interval;
      this.low = this.high = value;
      this.kept.push([i, i]);
      return;
    }
    if (value < this.low) { this.low = value; own[0] = i; }
    if (value > this.high) { this.high = value; own[1] = i; }
  }
  /** Indices of the points in order: all of them if they are few. */
  indices() {
    if (this.count <= FEW * INTERVALS) return Array.from({ length: this.count }, (_, i) => i);
    return [0, ...this.kept.flatMap(([least, largest]) => (least < largest ? [least, largest] : [largest, least])), this.count - 1];
  }
}

/** Strokes a line through points, in pieces. @param {any} g @param {number[]} indices @param {(i: number) => number} x @param {(i: number) => number} y */
export function stroke(g, indices, x, y) {
  for (let from = 0; from < indices.length - 1; from += PIECE) {
    g.beginPath();
    g.moveTo(x(indices[from]), y(indices[from]));
    for (let k = from + 1; k <= Math.min(from + PIECE, indices.length - 1); k++) g.lineTo(x(indices[k]), y(indices[k]));
    g.stroke();
  }
}

/** Air around a range that will grow, and around one that will not, as parts of it. */
const AIR = { growing: 0.3, last: 0.06 };

/** The range of an axis: while its numbers grow it grows in steps, so that a picture seldom begins anew. @param {[number, number]} before @param {[number, number]} ends @param {boolean} isLast @returns {[number, number]} */
export function stepped(before, ends, isLast) {
  if (isLast) return reach(ends, AIR.last);
  return before[0] <= ends[0] && ends[1] <= before[1] ? before : reach(ends, AIR.growing);
}

/** Time until which pictures may grow in this frame, and whether one has more to draw. */
const growth = { until: 0, isLeft: false };

/** Begins a frame of the page. */
export const beginFrame = () => { growth.until = performance.now() + BUDGET; growth.isLeft = false; };
/** Whether a picture has more to draw in the next frame. */
export const isGrowing = () => growth.isLeft;

/** A picture of many items on its own canvas, to which each frame of the page adds as much as its time allows. */
export class Growing {
  constructor() {
    this.canvas = document.createElement("canvas");
    this.key = "";
    this.done = 0;
  }
  /** Draws further items and puts the picture onto a panel; a file gets all items at once. @param {any} onto @param {string} key what the drawn items depend on: with another key the picture begins anew @param {number} count @param {(g: any, from: number, to: number) => void} piece */
  draw(onto, key, count, piece) {
    if (!(onto instanceof CanvasRenderingContext2D)) return piece(onto, 0, count);
    const { canvas } = this, { width, height } = onto.canvas, g = /** @type {CanvasRenderingContext2D} */ (canvas.getContext("2d", { willReadFrequently: true })), whole = `${width} ${height} ${key}`;
    if (this.key !== whole) { this.key = whole; this.done = 0; canvas.width = width; canvas.height = height; g.setTransform(onto.getTransform()); }
    for (let isFirst = true; this.done < count && (isFirst || performance.now() < growth.until); isFirst = false) {
      const to = Math.min(count, this.done + PIECE);
      piece(g, this.done, to);
      // Reading a pixel makes the browser draw now, so that the drawing counts to the time.
      g.getImageData(0, 0, 1, 1);
      this.done = to;
    }
    growth.isLeft ||= this.done < count;
    onto.save();
    onto.setTransform(1, 0, 0, 1, 0, 0);
    onto.drawImage(canvas, 0, 0);
    onto.restore();
  }
}
