// Bytes that lie in the page as text: seven bits a letter, an eighth more than the bytes
// themselves. What HTML would change (NUL, carriage return, <) stands with the seven bits after it
// in one letter of two bytes. Their number stands first: `3:…`.

/** The letters that HTML would change, in the order of their numbers. */
export const CHANGED = [0, 13, 60];

/** The bytes in an element of the page. @param {string} id */
export function bytesIn(id) {
  const text = document.getElementById(id)?.textContent ?? "", begin = text.indexOf(":") + 1, length = Number(text.slice(0, begin - 1));
  // The last letters may hold bits of one byte more.
  const bytes = new Uint8Array(length + 2);
  let held = 0, bits = 0, count = 0;
  const take = (/** @type {number} */ seven) => {
    held = (held << 7) | seven; bits += 7;
    if (bits >= 8) { bits -= 8; bytes[count++] = held >> bits; held &= (1 << bits) - 1; }
  };
  for (let i = begin; begin > 0 && i < text.length; i++) {
    const c = text.charCodeAt(i);
    if (c < 128) take(c); else { take(CHANGED[(c - 128) >> 7]); take((c - 128) & 127); }
  }
  return bytes.subarray(0, begin > 0 ? Math.min(count, length) : 0);
}

/** The module in the page, compressed by gzip. @returns {Promise<WebAssembly.Module>} */
export async function unpack() {
  const plain = new Blob([bytesIn("core")]).stream().pipeThrough(new DecompressionStream("gzip"));
  return WebAssembly.compile(await new Response(plain).arrayBuffer());
}
