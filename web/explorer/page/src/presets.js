// Parameter sets to start from. Figures refer to the paper; the values of the default set are a reconstruction.

/**
 * @typedef {object} Preset
 * @property {string} id
 * @property {string} name
 * @property {boolean} [strong] the strongly coupled set
 * @property {[string, number][]} set
 * @property {number[]} [start] x1, x2, x3 in L and v1, v2, v3 in L ω10
 * @property {string} along parameter of the diagram
 * @property {[number, number]} range
 * @property {string} [ordinate]
 * @property {boolean} [orbits]
 * @property {string} [theory]
 * @property {string} story what is to be seen and to be tried
 */

/** The common start of the studies: all bodies at rest except the block, which moves to the upper stop. */
export const MOVING_BLOCK = [0, 0, 0, 0, 1, 0];

/** @type {Preset[]} */
export const PRESETS = [
  { id: "default", name: "Two impacts a period (default set)", set: [], along: "f10", range: [0.5, 5],
    story: "The block strikes each stop once in every drive period. Drag it and let it go: it comes back to the same motion." },
  { id: "figure-9", name: "Fixed points on the manifold (figure 9)", set: [["f10", 1.2]], along: "f10", range: [0.5, 3], theory: "manifold",
    story: "Multiple scales: the slow amplitudes can only lie on a curve, the slow invariant manifold (last picture). Move the force: the motion lives while P₂ is on the strong part." },
  { id: "figure-13", name: "Modulated motion, f̂₁₀ = 0.6 (figure 13)", set: [["f10", 0.6]], along: "f10", range: [0.3, 1.2], ordinate: "strobe",
    story: "At a weak force the strikes come and go: strong for some periods, then hardly any. The motion is modulated and never repeats." },
  { id: "figure-14", name: "The diagram close up (figure 14)", set: [["f10", 2.2]], along: "f10", range: [1.9, 4],
    story: "Each value of the force has its own motion. Drag a box in the diagram to look closer, click a point to play it." },
  { id: "figure-15-pair", name: "Broken symmetry, f̂₁₀ = 2.2 (figure 15)", set: [["f10", 2.2]], along: "f10", range: [1.9, 2.9],
    story: "Past f̂₁₀ = 2.04 the two impacts become unequal, though the machine is symmetric. A mirror image of this motion exists too." },
  { id: "figure-15-long", name: "Long period, f̂₁₀ = 2.44 (figure 15)", set: [["f10", 2.44]], along: "f10", range: [2.3, 2.6],
    story: "The same impacts come back only after two drive periods: two points in the section. Move the force on: four, eight, then chaos." },
  { id: "figure-15-chaos", name: "Chaos, f̂₁₀ = 3.6 (figure 15)", set: [["f10", 3.6]], along: "f10", range: [2.8, 4],
    story: "It never repeats. Let it go from almost the same place and it soon moves otherwise; yet all its points lie on one fine figure, the section." },
  { id: "figure-15-three", name: "Three impacts, f̂₁₀ = 3.9 (figure 15)", set: [["f10", 3.9]], along: "f10", range: [3.2, 4.6],
    story: "Three impacts in a drive period: one stop is struck twice. Narrow windows of order like this one lie within the chaos." },
  { id: "figure-16", name: "Closed forms over the maxima (figure 16)", set: [["f10", 1.8]], along: "f10", range: [0.5, 5], orbits: true,
    story: "Exact periodic orbits over the computed maxima: full where they are stable, dashed where nothing could stay on them." },
  { id: "figure-19", name: "Strong coupling (set chosen here, figure 19)", strong: true, set: [], along: "f10", range: [0.5, 4], ordinate: "x1",
    story: "The coupling is strong here, and the block moves the oscillator as much as the box. The numbers of this set were chosen for this program." },
  { id: "chatter", name: "Chatter and rest: soft stops, κ = 0.2", set: [["f10", 5], ["kappa", 0.2]], along: "kappa", range: [0, 0.8],
    story: "Soft stops: the block bounces ever smaller, rests at the stop, which stays lit, and leaves when the box lets it go." },
  { id: "plastic", name: "Rest after every impact, κ = 0", set: [["f10", 3], ["kappa", 0]], along: "f10", range: [0.5, 5], ordinate: "speed",
    story: "No rebound at all: after every impact the block stays at the stop until nothing presses it there any more." },
  { id: "coexisting", name: "Coexisting attractors, f̂₁₀ = 2.5", set: [["f10", 2.5]], start: [0.5, 0.5, 0, 0, -1.5, 0], along: "f10", range: [2.2, 2.9],
    story: "The same machine and force, several motions: where it ends depends on where you let the block go. Rings in the diagram mark the one you see." },
];
