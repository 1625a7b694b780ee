//! Impact word of a periodic orbit: the order of its impacts on the two stops, how the orbit
//! closes, and its period.

use serde::{Deserialize, Serialize};
use std::f64::consts::{PI, TAU};
use vibro_studies::{Error, Result};

/// Tolerance for equal passages or halves of an orbit, as a difference of phases, rad.
pub(super) const REPETITION: f64 = 1e-8;

/// Largest numbers of letters and half periods of a parsed word. The memory for the equations
/// grows with the square of the number of impacts.
pub(super) const MOST_LETTERS: usize = 1024;
const MOST_HALF_PERIODS: u32 = 1 << 16;

/// Text of the empty word.
const EMPTY: &str = "-";

/// The order of impacts of a periodic orbit with the way it closes (docs/theory.md, section 14).
///
/// The orbit repeats itself after [`half_periods`](Self::half_periods) half drive periods:
/// unchanged if [`closing`](Self::closing) is +1, with the opposite sign if it is -1. An orbit
/// with -1 is symmetric, and its word contains half of its impacts.
///
/// ```
/// use vibro_orbits::paper::OrbitWord;
///
/// let symmetric = OrbitWord::new("U", -1, 1)?; // the motion with two symmetric impacts a period
/// let whole = symmetric.unfolded();
/// assert_eq!((whole.to_string(), whole.closing(), whole.half_periods()), ("UL".into(), 1, 2));
/// assert_eq!(whole.period(), 1); // drive periods
/// # Ok::<(), vibro_studies::Error>(())
/// ```
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct OrbitWord {
    /// +1 upper stop, -1 lower.
    letters: Vec<i8>,
    closing: i8,
    half_periods: u32,
}

/// An operation between equivalent words: a rotation, so that the word begins at another letter,
/// then the mirror image if `mirrored`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Turn {
    /// Shift of the first letter, counted in letters of the unfolded word.
    pub by: usize,
    /// Whether the mirror image is taken: opposite stops, half a drive period later.
    pub mirrored: bool,
}

impl OrbitWord {
    /// A word from its text: letters U (upper stop) and L (lower stop), or `-` for the empty word.
    ///
    /// # Errors
    /// [`Error::Form`] if `text` has other letters, if there are more than 1024 letters or 65,536
    /// half periods, if `closing` is not ±1, or if the number of half periods does not fit
    /// `closing`: it must be even and positive for +1, odd for -1.
    pub fn new(text: &str, closing: i8, half_periods: u32) -> Result<Self> {
        let letter = |c| match c {
            'U' | 'u' => Some(1),
            'L' | 'l' => Some(-1),
            _ => None,
        };
        let shown = text.trim();
        let letters: Option<Vec<i8>> = if shown == EMPTY { "" } else { shown }.chars().map(letter).collect();
        let form = |expected| Error::Form { text: text.into(), expected };
        let letters = letters.ok_or_else(|| form("a word of the letters U and L, e.g. ULL"))?;
        if letters.len() > MOST_LETTERS || half_periods > MOST_HALF_PERIODS {
            return Err(form("at most 1024 letters in at most 65,536 half drive periods"));
        }
        match (closing, half_periods % 2) {
            (1, 0) if half_periods > 0 => {}
            (-1, 1) => {}
            _ => {
                return Err(form(
                    "closing + over whole drive periods, or closing - over an odd number of half periods",
                ));
            }
        }
        Ok(Self::of(letters, closing, half_periods))
    }

    /// A word from stops (±1) that are known to be valid.
    pub(super) fn of(letters: Vec<i8>, closing: i8, half_periods: u32) -> Self {
        Self { letters, closing, half_periods }
    }

    /// The stops in order: +1 upper, -1 lower.
    pub fn letters(&self) -> &[i8] {
        &self.letters
    }

    /// Number of impacts until the orbit closes.
    pub fn len(&self) -> usize {
        self.letters.len()
    }

    /// Whether the word has no impact.
    pub fn is_empty(&self) -> bool {
        self.letters.is_empty()
    }

    /// +1: the orbit closes on itself; -1: on its mirror image, so that it is symmetric.
    pub fn closing(&self) -> i8 {
        self.closing
    }

    /// The sign of [`closing`](Self::closing) as a character.
    pub fn sign(&self) -> char {
        if self.closing > 0 { '+' } else { '-' }
    }

    /// The letters with the closing sign.
    pub fn signed(&self) -> String {
        format!("{self}{}", self.sign())
    }

    /// The error for a word without an orbit, with the reason.
    pub(super) fn no_orbit(&self, reason: impl Into<String>) -> Error {
        Error::NoOrbit {
            word: self.to_string(),
            closing: self.sign(),
            period: self.period(),
            reason: reason.into(),
        }
    }

    /// Half drive periods until the orbit closes.
    pub fn half_periods(&self) -> u32 {
        self.half_periods
    }

    /// The orbit's period in drive periods.
    pub fn period(&self) -> u32 {
        if self.closing == 1 { self.half_periods / 2 } else { self.half_periods }
    }

    /// Θ, the drive's phase over which the orbit closes, rad.
    pub fn span(&self) -> f64 {
        f64::from(self.half_periods) * PI
    }

    /// The stop (±1.0) of impact i, also for i past the end of the word.
    pub(super) fn side(&self, i: usize) -> f64 {
        let (rounds, index) = (i / self.len(), i % self.len());
        let sign = if self.closing == -1 && rounds % 2 == 1 { -1.0 } else { 1.0 };
        sign * f64::from(self.letters[index])
    }

    /// The word repeated twice, which closes with +1: W becomes W W, and the half word W of a
    /// symmetric orbit becomes W followed by its opposite.
    #[must_use]
    pub fn unfolded(&self) -> Self {
        let again = self.letters.iter().map(|s| s * self.closing);
        let letters = self.letters.iter().copied().chain(again).collect();
        Self::of(letters, 1, 2 * self.half_periods)
    }

    /// The word repeated k times; for a symmetric orbit k must be odd.
    pub(super) fn repeated(&self, k: usize) -> Self {
        let sides = (0..k * self.len()).map(|i| self.side(i) as i8);
        Self::of(sides.collect(), self.closing, self.half_periods * k as u32)
    }

    /// The half word that [unfolds](Self::unfolded) to this word, if there is one.
    #[must_use]
    pub fn folded(&self) -> Option<Self> {
        let (n, half) = (self.len(), self.half_periods / 2);
        if self.closing != 1 || n % 2 == 1 {
            return None;
        }
        // After an odd number of half periods only the opposite can follow, after an even number
        // only a repetition.
        let closing = if half % 2 == 1 { -1 } else { 1 };
        let (first, second) = self.letters.split_at(n / 2);
        let fits = first.iter().zip(second).all(|(a, b)| *b == closing * a);
        fits.then(|| Self::of(first.to_vec(), closing, half))
    }

    /// The word that gives this word when repeated k times, if there is one; for a symmetric orbit
    /// k must be odd.
    fn divided(&self, k: usize) -> Option<Self> {
        let parts = u32::try_from(k).ok()?;
        let n = self.len() / k;
        let fits = self.len().is_multiple_of(k)
            && self.half_periods.is_multiple_of(parts)
            && (self.closing == -1 || (self.half_periods / parts).is_multiple_of(2));
        if !fits || (self.closing == -1 && k.is_multiple_of(2)) {
            return None;
        }
        let part = Self::of(self.letters[..n].to_vec(), self.closing, self.half_periods / parts);
        (0..self.len()).all(|i| f64::from(self.letters[i]) == part.side(i)).then_some(part)
    }

    /// The word with letter `side` (±1) inserted at index `k`.
    #[must_use]
    pub fn inserted(&self, k: usize, side: i8) -> Self {
        let mut word = self.clone();
        word.letters.insert(k, side);
        word
    }

    /// The word without letter `k`.
    #[must_use]
    pub fn removed(&self, k: usize) -> Self {
        let mut word = self.clone();
        word.letters.remove(k);
        word
    }

    /// Number of rotations: one for each letter, two for each letter of a symmetric orbit's half
    /// word.
    fn turns(&self) -> usize {
        if self.closing == -1 { 2 * self.len() } else { self.len() }
    }

    /// The word after `turn`.
    fn turned(&self, turn: Turn) -> Self {
        let sign = if turn.mirrored { -1.0 } else { 1.0 };
        let letters = (0..self.len()).map(|i| (sign * self.side(i + turn.by)) as i8).collect();
        Self::of(letters, self.closing, self.half_periods)
    }

    /// All turns. Turns with a mirror image exist only without loads; a symmetric orbit leaves
    /// them out, since they equal rotations.
    fn all_turns(&self, mirror: bool) -> impl Iterator<Item = Turn> {
        let mirrored = mirror && self.closing == 1;
        let both = [false, true].into_iter().filter(move |m| !m || mirrored);
        let turns = self.turns();
        both.flat_map(move |mirrored| (0..turns).map(move |by| Turn { by, mirrored }))
    }

    /// The canonical word (the first equivalent one in the order U < L) with a turn that leads to
    /// it. Rotations are equivalent; without loads (`mirror`) mirror images are too.
    pub(super) fn canonical_turn(&self, mirror: bool) -> (Self, Turn) {
        let own = (self.clone(), Turn { by: 0, mirrored: false });
        self.all_turns(mirror).fold(own, |best, turn| {
            let word = self.turned(turn);
            // U is +1 and comes first.
            if word.letters > best.0.letters { (word, turn) } else { best }
        })
    }

    /// The first of all equivalent words in the order U < L. A word can begin at any impact of its
    /// orbit, and may be mirrored, so an orbit has several words.
    #[must_use]
    pub fn canonical(&self) -> Self {
        self.canonical_turn(true).0
    }

    /// Turns that leave the word unchanged: orbits whose phases differ by such a turn are equal.
    pub(super) fn symmetries(&self, mirror: bool) -> Vec<Turn> {
        self.all_turns(mirror).filter(|turn| self.turned(*turn).letters == self.letters).collect()
    }

    /// The phases of the orbit after a turn, the first in [0, 2π).
    pub(super) fn turned_phases(&self, phases: &[f64], turn: Turn) -> Vec<f64> {
        let n = self.len();
        if n == 0 {
            return Vec::new();
        }
        let shift = if turn.mirrored { PI } else { 0.0 };
        let at = |i: usize| phases[i % n] + (i / n) as f64 * self.span() + shift;
        let whole = (at(turn.by) / TAU).floor() * TAU;
        (0..n).map(|i| at(i + turn.by) - whole).collect()
    }

    /// The shortest word of the orbit with its phases: repetitions and symmetry are removed if
    /// phases repeat to `tolerance`. A word is folded to closing -1 only without loads (`mirror`).
    pub(super) fn reduced(&self, phases: &[f64], mirror: bool, tolerance: f64) -> (Self, Vec<f64>) {
        let repeats = |part: &Self| {
            let n = part.len();
            (n..self.len()).all(|i| (phases[i] - phases[i - n] - part.span()).abs() < tolerance)
        };
        let folded = || self.folded().filter(|f| f.closing == 1 || mirror);
        let parts = (2..=self.len()).rev().filter_map(|k| self.divided(k)).chain(folded());
        match parts.into_iter().find(repeats) {
            Some(part) => {
                let n = part.len();
                part.reduced(&phases[..n], mirror, tolerance)
            }
            None => (self.clone(), phases.to_vec()),
        }
    }
}

impl std::fmt::Display for OrbitWord {
    /// The letters, U for the upper stop and L for the lower; `-` for the empty word.
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        if self.letters.is_empty() {
            return f.write_str(EMPTY);
        }
        self.letters.iter().try_for_each(|s| f.write_str(if *s > 0 { "U" } else { "L" }))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn closed_form_canonical_words() {
        for (text, closing, half, canonical) in [
            ("LUL", 1, 2, "UUL"), // the mirror image ULU begins with two upper impacts once turned
            ("LLU", 1, 2, "UUL"),
            ("L", -1, 1, "U"),
            ("LU", 1, 2, "UL"),
            ("LLUULL", 1, 4, "UUUULL"),
            ("UL", -1, 1, "UU"), // U L | L U: begun at the last letter U U | L L
        ] {
            let word = OrbitWord::new(text, closing, half).unwrap();
            assert_eq!(word.canonical().to_string(), canonical, "{text}");
            assert_eq!(word.canonical(), word.canonical().canonical());
        }
    }

    #[test]
    fn invariant_a_word_is_read_as_it_is_shown() {
        for (text, closing, half) in [("U", -1, 1), ("ULL", 1, 2), ("", 1, 2), ("", -1, 1)] {
            let word = OrbitWord::new(text, closing, half).unwrap();
            assert_eq!(OrbitWord::new(&word.to_string(), closing, half).unwrap(), word, "{text}");
        }
    }

    #[test]
    fn invariant_unfolding_and_folding_undo_each_other() {
        for (text, closing, half) in [("U", -1, 1), ("ULL", 1, 2), ("UUL", -1, 3), ("UL", 1, 4)] {
            let word = OrbitWord::new(text, closing, half).unwrap();
            assert_eq!(word.unfolded().folded(), Some(word.clone()), "{text}");
            assert_eq!(word.unfolded().half_periods(), 2 * half);
            assert_eq!(word.inserted(1, -1).removed(1), word);
        }
        assert_eq!(OrbitWord::new("ULL", 1, 2).unwrap().folded(), None);
    }

    #[test]
    fn invariant_turned_phases_repeat_after_all_letters() {
        let (word, phases) = (OrbitWord::new("UUL", -1, 1).unwrap(), [0.3, 1.0, 2.2]);
        let once = |phases: &[f64]| word.turned_phases(phases, Turn { by: 1, mirrored: false });
        let mut turned = phases.to_vec();
        for _ in 0..6 {
            turned = once(&turned);
            assert!((0.0..TAU).contains(&turned[0]) && turned.windows(2).all(|w| w[0] < w[1]));
        }
        assert!(turned.iter().zip(phases).all(|(a, b)| (a - b).abs() < 1e-14));
    }

    #[test]
    fn invariant_repetitions_and_symmetry_are_taken_out() {
        let word = OrbitWord::new("ULULUL", 1, 6).unwrap();
        let phases: Vec<f64> = (0..6).map(|i| 0.4 + PI * f64::from(i)).collect();
        let (least, one) = word.reduced(&phases, true, 1e-9);
        assert_eq!((least.to_string(), least.closing(), least.half_periods()), ("U".into(), -1, 1));
        assert_eq!(one, [0.4]);
        // Under loads an orbit may repeat but is not symmetric.
        assert_eq!(word.reduced(&phases, false, 1e-9).0, OrbitWord::new("UL", 1, 2).unwrap());
        let unequal: Vec<f64> = phases.iter().map(|p| p + 0.01 * p.sin()).collect();
        assert_eq!(word.reduced(&[&unequal[..2], &phases[2..]].concat(), true, 1e-9).0, word);
    }

    #[test]
    fn words_that_cannot_be_are_refused_with_the_form() {
        for (text, closing, half) in [("UX", 1, 2), ("U", -1, 2), ("U", 1, 3), ("U", 1, 0), ("U", 2, 2)] {
            assert!(matches!(OrbitWord::new(text, closing, half), Err(Error::Form { .. })), "{text}");
        }
    }
}
