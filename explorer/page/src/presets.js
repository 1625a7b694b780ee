// Parameter sets to begin with. Figures are those of the paper; the numbers of the default set are a reconstruction.

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
 */

/** The start that studies have in common: all at rest but the block, which moves to the upper stop. */
export const MOVING_BLOCK = [0, 0, 0, 0, 1, 0];

/** @type {Preset[]} */
export const PRESETS = [
  { id: "default", name: "Two impacts a period (default set)", set: [], along: "f10", range: [0.5, 5] },
  { id: "figure-9", name: "Figure 9: weak force, f̂₁₀ = 1.2", set: [["f10", 1.2]], along: "sigma1", range: [-1.5, 2] },
  { id: "figure-13", name: "Figure 13: modulated motion, f̂₁₀ = 0.6", set: [["f10", 0.6]], along: "f10", range: [0.3, 1.2], ordinate: "strobe" },
  { id: "figure-14", name: "Figure 14: the diagram close up", set: [["f10", 2.2]], along: "f10", range: [1.9, 4] },
  { id: "figure-15-pair", name: "Figure 15: broken symmetry, f̂₁₀ = 2.2", set: [["f10", 2.2]], along: "f10", range: [1.9, 2.9] },
  { id: "figure-15-long", name: "Figure 15: long period, f̂₁₀ = 2.44", set: [["f10", 2.44]], along: "f10", range: [2.3, 2.6] },
  { id: "figure-15-chaos", name: "Figure 15: chaos, f̂₁₀ = 3.6", set: [["f10", 3.6]], along: "f10", range: [2.8, 4] },
  { id: "figure-15-three", name: "Figure 15: three impacts, f̂₁₀ = 3.9", set: [["f10", 3.9]], along: "f10", range: [3.2, 4.6] },
  { id: "figure-16", name: "Figure 16: closed forms over the maxima", set: [["f10", 1.8]], along: "f10", range: [0.5, 5], orbits: true },
  { id: "figure-19", name: "Figure 19: strong coupling (set chosen here)", strong: true, set: [], along: "f10", range: [0.5, 4], ordinate: "x1" },
  { id: "chatter", name: "Chatter and rest: soft stops, κ = 0.2", set: [["f10", 5], ["kappa", 0.2]], along: "kappa", range: [0, 0.8] },
  { id: "plastic", name: "Rest after every impact, κ = 0", set: [["f10", 3], ["kappa", 0]], along: "f10", range: [0.5, 5], ordinate: "speed" },
  { id: "coexisting", name: "Coexisting attractors, f̂₁₀ = 2.5", set: [["f10", 2.5]], start: [0.5, 0.5, 0, 0, -1.5, 0], along: "f10", range: [2.2, 2.9] },
];
