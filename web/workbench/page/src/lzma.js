// Decoder of LZMA (I. Pavlov's public LZMA specification, 2015): a range coder with adaptive bits,
// for literals and for matches with earlier data.

/** Rows of the state table: next state after a literal, a match, a repeated match, a short one. */
const AFTER_LITERAL = [0, 0, 0, 0, 1, 2, 3, 4, 5, 6, 4, 5];

/** Reads a file `.lzma` of known size: properties, dictionary's size, size, stream. `until` decodes up to about a place and returns the place that is reached in `out`. @param {Uint8Array} file */
export function decoder(file) {
  const view = new DataView(file.buffer, file.byteOffset, file.byteLength), size = view.getUint32(5, true), out = new Uint8Array(size);
  const lc = file[0] % 9, lp = Math.floor(file[0] / 9) % 5, pb = Math.floor(file[0] / 45);
  const literals = 0x300 << (lc + lp), places = (1 << pb) - 1, contexts = (1 << lp) - 1;
  // Positions of the bits of each kind.
  const isMatch = 0, isRep = 192, isRep0 = 204, isRep1 = 216, isRep2 = 228, isLong = 240, slots = 432, special = 688, align = 816, matchLength = 832, repLength = 1346, literal = 1860;
  const bits = new Uint16Array(literal + literals).fill(1024);
  // Range and code are in an array: a browser stores a 32-bit variable as a separate object.
  const now = new Int32Array([-1, view.getUint32(14)]);
  let at = 18, to = 0, state = 0, rep0 = 0, rep1 = 0, rep2 = 0, rep3 = 0;

  /** @param {number} place */
  function bit(place) {
    const p = bits[place], bound = Math.imul(now[0] >>> 11, p);
    let range = bound, code = now[1], found = 0;
    if ((code >>> 0) < (bound >>> 0)) bits[place] = p + ((2048 - p) >> 5); else { range = (now[0] - bound) | 0; code = (code - bound) | 0; bits[place] = p - (p >> 5); found = 1; }
    if ((range >>> 24) === 0) { range <<= 8; code = (code << 8) | file[at++]; }
    now[0] = range; now[1] = code;
    return found;
  }
  /** @param {number} place @param {number} count */
  function tree(place, count) {
    let found = 1;
    for (let i = 0; i < count; i++) found = (found << 1) | bit(place + found);
    return found - (1 << count);
  }
  /** Lowest bit first. @param {number} place @param {number} count */
  function reversed(place, count) {
    let node = 1, found = 0;
    for (let i = 0; i < count; i++) { const own = bit(place + node); node = (node << 1) | own; found |= own << i; }
    return found;
  }
  /** Bits that are 0 or 1 alike. @param {number} count */
  function even(count) {
    let found = 0;
    for (let i = 0; i < count; i++) {
      let range = now[0] >>> 1, code = now[1];
      const own = (code >>> 0) >= range ? 1 : 0;
      if (own) code -= range;
      if ((range >>> 24) === 0) { range <<= 8; code = (code << 8) | file[at++]; }
      now[0] = range; now[1] = code;
      found = (found << 1) | own;
    }
    return found;
  }
  /** @param {number} place @param {number} context */
  function length(place, context) {
    if (!bit(place)) return 2 + tree(place + 2 + (context << 3), 3);
    if (!bit(place + 1)) return 10 + tree(place + 130 + (context << 3), 3);
    return 18 + tree(place + 258, 8);
  }

  /** @param {number} end */
  const until = (end) => { while (to < end) next(); return to; };
  function next() {
    const context = to & places;
    if (!bit(isMatch + (state << 4) + context)) {
      const before = to > 0 ? out[to - 1] : 0, own = literal + 0x300 * (((to & contexts) << lc) + (before >> (8 - lc)));
      // After a match, each bit is coded together with the bit of the byte that the match would
      // repeat, up to the first different bit.
      let node = 1, other = state >= 7 ? out[to - rep0 - 1] : -1, range = now[0], code = now[1];
      while (node < 0x100) {
        const expected = (other >> 7) & 1, place = own + node + (other < 0 ? 0 : (1 + expected) << 8);
        const p = bits[place], bound = Math.imul(range >>> 11, p);
        let found = 0;
        if ((code >>> 0) < (bound >>> 0)) { range = bound; bits[place] = p + ((2048 - p) >> 5); } else { range = (range - bound) | 0; code = (code - bound) | 0; bits[place] = p - (p >> 5); found = 1; }
        if ((range >>> 24) === 0) { range <<= 8; code = (code << 8) | file[at++]; }
        node = (node << 1) | found;
        other = other < 0 || found !== expected ? -1 : (other << 1) & 0xff;
      }
      now[0] = range; now[1] = code;
      out[to++] = node;
      state = AFTER_LITERAL[state];
      return;
    }
    let count = 0;
    if (!bit(isRep + state)) {
      [rep3, rep2, rep1] = [rep2, rep1, rep0];
      count = length(matchLength, context);
      state = state < 7 ? 7 : 10;
      const slot = tree(slots + (Math.min(count - 2, 3) << 6), 6);
      if (slot < 4) rep0 = slot;
      else {
        const low = (slot >> 1) - 1, base = (2 | (slot & 1)) << low;
        rep0 = slot < 14 ? base + reversed(special + base - slot, low) : base + (even(low - 4) << 4) + reversed(align, 4);
      }
    } else {
      if (!bit(isRep0 + state)) {
        if (!bit(isLong + (state << 4) + context)) { state = state < 7 ? 9 : 11; out[to] = out[to - rep0 - 1]; to++; return; }
      } else if (!bit(isRep1 + state)) [rep1, rep0] = [rep0, rep1];
      else if (!bit(isRep2 + state)) [rep2, rep1, rep0] = [rep1, rep0, rep2];
      else [rep3, rep2, rep1, rep0] = [rep2, rep1, rep0, rep3];
      count = length(repLength, context);
      state = state < 7 ? 8 : 11;
    }
    for (let from = to - rep0 - 1; count > 0 && to < size; count--) out[to++] = out[from++];
  }
  return { out, until };
}
