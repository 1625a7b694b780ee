// Workers with a time limit: one that takes too long is ended and replaced.

import { bytesIn } from "../../../explorer/page/src/packed.js";
import { pieces } from "./kinds.js";
import { decoder } from "./lzma.js";

/* global WORKER: the script of the workers, put in by the bundler */

/** The module of the page, compiled once. @type {WebAssembly.Module | null} */
let module = null;
let script = "";

/** The module in the page, LZMA-compressed. Its pieces are compiled while the next ones are unpacked. */
function unpack() {
  const all = pieces(decoder(bytesIn("core")));
  const stream = new ReadableStream({
    pull(to) {
      const { value, done } = all.next();
      if (done) to.close(); else to.enqueue(value);
    },
  });
  return WebAssembly.compileStreaming(new Response(stream, { headers: { "Content-Type": "application/wasm" } }));
}

/** Compiles the module in the page. */
export async function begin() {
  module = await unpack();
  script = URL.createObjectURL(new Blob([WORKER], { type: "text/javascript" }));
}

/** A refusal, with the problems of a file by line. */
export class Refused extends Error {
  /** @param {string} words @param {{line: number | null, words: string}[]} problems */
  constructor(words, problems) { super(words); this.problems = problems; }
}

/** One worker. Callers drop answers to questions that a newer one has replaced. */
export class Helper {
  constructor() {
    this.last = 0;
    /** @type {Map<number, {done: (x: any) => void, failed: (e: Error) => void, told: (x: any) => void, watch: number}>} */
    this.open = new Map();
    this.worker = this.begin();
  }

  begin() {
    const worker = new Worker(script);
    worker.onmessage = ({ data }) => this.hear(data);
    worker.onerror = (event) => { event.preventDefault(); this.end(`The computation broke off: ${event.message}`); };
    worker.postMessage({ kind: "module", module });
    return worker;
  }

  /** @param {any} data */
  hear(data) {
    if (data.panicked) return this.end(`The computation broke off, by a defect of the library: ${data.panicked}`);
    const asked = this.open.get(data.id);
    if (!asked) return;
    if (data.part !== undefined) return asked.told(data.part);
    this.open.delete(data.id);
    clearTimeout(asked.watch);
    if (data.refused !== undefined) asked.failed(refusal(data.refused)); else asked.done(data.answer);
  }

  /** Asks; after `limit` milliseconds without an answer the worker is ended. @param {string} kind @param {any} [what] @param {number} [limit] @param {(part: any) => void} [told] @returns {Promise<any>} */
  ask(kind, what = {}, limit = 0, told = () => {}) {
    return new Promise((done, failed) => {
      const id = ++this.last;
      const watch = limit && window.setTimeout(() => this.end(`It took longer than ${limit / 1000} s and was ended. A smaller machine, or the command line vibro, goes on.`), limit);
      this.open.set(id, { done, failed, told, watch });
      this.worker.postMessage({ ...what, kind, id });
    });
  }

  /** Ends the worker; all that it was asked fails with these words. A new one stands by. @param {string} words */
  end(words) {
    this.worker.terminate();
    const open = [...this.open.values()];
    this.open.clear();
    this.worker = this.begin();
    for (const asked of open) { clearTimeout(asked.watch); asked.failed(new Refused(words, [{ line: null, words }])); }
  }

  stop() { this.worker.terminate(); for (const asked of this.open.values()) clearTimeout(asked.watch); }
}

/** @param {string} words */
function refusal(words) {
  try {
    const problems = JSON.parse(words);
    if (Array.isArray(problems)) return new Refused(problems.map((p) => p.words).join("\n"), problems);
  } catch { /* words, not JSON */ }
  return new Refused(words, [{ line: null, words }]);
}
