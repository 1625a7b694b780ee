// A WebAssembly module with the bytes of its code separated by kind, which improves compression by
// a twelfth (WebAssembly Core Specification, chapter 5: binary format).

/** Kinds of code bytes; all other bytes are with the opcodes. */
const [OPCODE, LOCAL, CONSTANT, MEMORY, CALL, BRANCH] = Array(6).keys();
export const KINDS = 6;

/** Goes through the bodies of functions byte by byte. `move` takes the next byte of a kind, puts it where it belongs, and returns it. @param {(kind: number) => number} move @param {number} functions */
export function walk(move, functions) {
  let done = 0;
  const byte = (/** @type {number} */ kind) => { done++; return move(kind); };
  const bytes = (/** @type {number} */ count) => { for (; count > 0; count--) byte(OPCODE); };
  const number = (/** @type {number} */ kind) => {
    for (let value = 0, shift = 0; ; shift += 7) {
      const own = byte(kind);
      value |= (own & 127) << shift;
      if (own < 128) return value >>> 0;
    }
  };
  const place = () => { number(MEMORY); number(MEMORY); };
  const instruction = () => {
    const code = byte(OPCODE);
    if (code >= 0x45 && code <= 0xc4) return; // arithmetic
    if (code >= 0x20 && code <= 0x24) number(LOCAL); // locals and globals
    else if (code >= 0x28 && code <= 0x3e) place(); // loads and stores
    else if (code === 0x41 || code === 0x42) number(CONSTANT);
    else if (code === 0x10) number(CALL);
    else if (code === 0x11) { number(CALL); number(CALL); } // through a table
    else if (code === 0x0c || code === 0x0d) number(BRANCH);
    else if (code === 0x0e) { for (let left = number(BRANCH); left >= 0; left--) number(BRANCH); } // a table of branches
    else if (code >= 0x02 && code <= 0x04) number(OPCODE); // types of blocks
    else if (code === 0x43) bytes(4);
    else if (code === 0x44) bytes(8);
    else if (code === 0x1c) bytes(number(OPCODE)); // types of a choice
    else if ([0x25, 0x26, 0x3f, 0x40, 0xd0, 0xd2].includes(code)) number(OPCODE); // tables, size of memory, references
    else if (code === 0xfc) {
      const own = number(OPCODE);
      // Conversions have no operand; instructions that copy or initialise memories and tables have two.
      if (own >= 8) number(OPCODE);
      if (own === 8 || own === 10 || own === 12 || own === 14) number(OPCODE);
    } else if (code === 0xfd) {
      const own = number(OPCODE);
      if (own <= 11 || (own >= 84 && own <= 93)) place();
      if (own === 12 || own === 13) bytes(16);
      else if ((own >= 21 && own <= 34) || (own >= 84 && own <= 91)) bytes(1); // lanes
    }
  };
  for (; functions > 0; functions--) {
    const size = number(OPCODE), end = done + size;
    for (let locals = number(OPCODE); locals > 0; locals--) { number(OPCODE); bytes(1); }
    while (done < end) instruction();
    if (done !== end) throw new Error(`a function ends ${done - end} bytes late: an instruction is unknown`);
  }
}

/** The pieces of a module one after another, from what `apart.mjs` writes: the part before the functions, blocks of functions, the part after them. @param {{out: Uint8Array, until: (end: number) => void}} apart its bytes, known up to where `until` was asked for */
export function* pieces({ out, until }) {
  const view = new DataView(out.buffer);
  let at = 0;
  const word = () => { until(at += 4); return view.getUint32(at - 4, true); };
  const bytes = () => { const size = word(); until(at += size); return out.subarray(at - size, at); };
  yield bytes();
  for (let functions = word(); functions > 0; functions = word()) {
    const kinds = Array.from({ length: KINDS }, bytes), places = new Uint32Array(KINDS);
    const piece = new Uint8Array(kinds.reduce((sum, kind) => sum + kind.length, 0));
    let to = 0;
    walk((kind) => piece[to++] = kinds[kind][places[kind]++], functions);
    yield piece;
  }
  yield bytes();
}
