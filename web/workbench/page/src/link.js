// The address contains the compressed file: a machine is shared by a link.

/** Longest link, in letters. */
export const LONGEST = 32_000;

/** @param {ReadableStream | null} stream */
const bytesOf = async (stream) => new Uint8Array(await new Response(stream).arrayBuffer());

/** The part of a link after `#`; empty where it would be too long. @param {string} text */
export async function toHash(text) {
  const packed = await bytesOf(new Blob([text]).stream().pipeThrough(new CompressionStream("gzip")));
  if (packed.length > LONGEST) return "";
  const letters = btoa(Array.from(packed, (b) => String.fromCharCode(b)).join(""));
  const hash = `z=${letters.replaceAll("+", "-").replaceAll("/", "_").replaceAll("=", "")}`;
  return hash.length > LONGEST ? "" : hash;
}

/** The text in a link, or nothing where there is none; throws where it is damaged, by gzip's checksum. Links of before 0.4 (`m=`) have none. @param {string} hash */
export async function fromHash(hash) {
  const found = hash.match(/^#([mz])=([\w-]*)$/);
  if (!found) return null;
  const bytes = Uint8Array.from(atob(found[2].replaceAll("-", "+").replaceAll("_", "/")), (c) => c.charCodeAt(0));
  return new TextDecoder().decode(await bytesOf(new Blob([bytes]).stream().pipeThrough(new DecompressionStream(found[1] === "z" ? "gzip" : "deflate-raw"))));
}
