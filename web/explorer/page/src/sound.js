// A soft tick at impacts, off by default.

/** @type {AudioContext | null} */
let audio = null;

/** @param {boolean} on */
export function enable(on) {
  if (on && !audio) audio = new AudioContext();
  if (!on && audio) { void audio.close(); audio = null; }
}

/** One tick: stronger and lower for a larger part of the usual impulse; to the left or right as the stop is. @param {number} part @param {number} side */
export function tick(part, side) {
  if (!audio) return;
  const now = audio.currentTime, tone = audio.createOscillator(), level = audio.createGain(), place = audio.createStereoPanner();
  tone.type = "triangle";
  tone.frequency.setValueAtTime(980 - 420 * Math.min(1, part), now);
  tone.frequency.exponentialRampToValueAtTime(240, now + 0.05);
  level.gain.setValueAtTime(0.0001, now);
  level.gain.exponentialRampToValueAtTime(0.02 + 0.13 * Math.min(1, part), now + 0.002);
  level.gain.exponentialRampToValueAtTime(0.0001, now + 0.07);
  place.pan.value = 0.5 * side;
  tone.connect(level).connect(place).connect(audio.destination);
  tone.start(now);
  tone.stop(now + 0.09);
}
