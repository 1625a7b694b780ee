// Bytes that are stored in the page as text: the page is in UTF-16, with two bytes per character.
// Characters that HTML or UTF-16 would not preserve are avoided: the bytes form blocks, each mixed
// with numbers derived from the block's first character, its key. The number of bytes comes first:
// `3:…`.

/** Number of characters of a block after its key. A longer block may have no key that avoids all these characters. */
export const BLOCK = 200;

/** The number that follows in a block, by the generator of all numbers of 16 bits. @param {number} key */
export const following = (key) => (key * 25173 + 13849) & 0xffff;

/** The bytes in an element of the page. @param {string} id */
export function bytesIn(id) {
  const text = document.getElementById(id)?.textContent ?? "", begin = text.indexOf(":") + 1, length = Number(text.slice(0, Math.max(0, begin - 1)));
  const letters = new Uint16Array(Math.ceil(length / 2));
  for (let i = begin, count = 0, key = 0; count < letters.length; i++) {
    if ((i - begin) % (BLOCK + 1) === 0) key = text.charCodeAt(i);
    else { key = following(key); letters[count++] = text.charCodeAt(i) ^ key; }
  }
  return new Uint8Array(letters.buffer, 0, length);
}

/** What an element of the page has compressed by gzip. @param {string} id */
export function unzipped(id) {
  return new Response(new Blob([bytesIn(id)]).stream().pipeThrough(new DecompressionStream("gzip")));
}
