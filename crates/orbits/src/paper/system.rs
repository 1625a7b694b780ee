//! The machine in the units of an orbit: lengths in L, the drive's phase as time (docs/theory.md,
//! sections 9 and 14).

pub(super) use super::balance::Anchor;
pub use super::balance::ConstantLoads;
use super::balance::{Balance, balance};
use crate::stop_word::OrbitWord;
use nalgebra::{Complex, Matrix2, Matrix4};
use vibro_impact::State;
use vibro_impact::parameters::Parameters;
use vibro_impact::steady::exact_orbit::{Flight, Transition, Vector6};
use vibro_numerics::bernstein::Polynomial;
use vibro_studies::Result;

/// A machine with its constant loads in an orbit's units. Lengths are in L, and a prime is the
/// derivative with respect to the drive's phase, whose period is 2π.
#[derive(Clone, Copy, Debug)]
pub struct System {
    parameters: Parameters,
    loads: ConstantLoads,
    pub(super) flight: Flight,
    /// H of docs/theory.md (71): without impacts the box swings as Im(H e^{iφ}).
    response: Complex<f64>,
    /// The reference positions of states, and the unbalanced loads there.
    balance: Balance,
    /// Acceleration of a block without a spring under its load, docs/theory.md (111); 0 if the
    /// block has a spring.
    pull: f64,
    /// The anchor, if a body is hardly held by a spring: the equations for the state then contain
    /// the first contact instead of this body's return, docs/theory.md (112).
    anchor: Option<Anchor>,
}

/// Stiffness of a second soft spring, relative to mass times ω1², below which states lose so many
/// digits that their equations may count as singular.
const NEUTRAL: f64 = 1e-8;

/// Determinant of σI minus the map of the free flight over a word, below which a mode counts as
/// near resonance. The relative distance of the mode's frequency from resonance is about the
/// square root of this determinant.
const RESONANT: f64 = 1e-4;

impl System {
    /// A machine under its drive and its constant loads.
    ///
    /// # Errors
    /// The errors of [`Flight::new`]; an error if the undamped box is at resonance, if a load acts
    /// on a box or a secondary oscillator without a spring, if a load is not finite, or if a
    /// spring would hold a load farther than 1e100 L away.
    pub fn new(parameters: &Parameters) -> Result<Self> {
        let loads = ConstantLoads { forces: parameters.constant_loads };
        let parameters = &Parameters { constant_loads: [0.0; 3], ..*parameters };
        let flight = Flight::new(parameters)?;
        let response = flight.harmonic(parameters)?;
        let balance = balance(parameters, loads)?;
        let scale = parameters.block_mass * parameters.stop_gap * parameters.drive_frequency.powi(2);
        let falls = parameters.coupling_stiffness == 0.0;
        let pull = if falls { loads.forces[1] / scale } else { 0.0 };
        let anchor = Anchor::of(std::iter::once(parameters));
        Ok(Self { parameters: *parameters, loads, flight, response, balance, pull, anchor })
    }

    /// This machine with the anchor of another one, so that the equations of both can be compared.
    #[must_use]
    pub(super) fn anchored(self, anchor: Option<Anchor>) -> Self {
        Self { anchor, ..self }
    }

    /// The anchor: the bodies held by the first contact in the equations for the state.
    pub(super) fn anchor(&self) -> Option<Anchor> {
        self.anchor
    }

    /// Anchors that may be needed near the resonance of a mode with hardly any damping. The free
    /// flight over the span of the word then returns the box, or the block and the secondary
    /// oscillator, nearly to the initial state. The matrix σI - M is singular except for the
    /// square of the distance of the mode's frequency from resonance (docs/theory.md, section 14).
    pub(super) fn resonant_anchors(&self, word: &OrbitWord) -> [Option<Anchor>; 2] {
        let Transition { one, pair } = self.flight.transition(word.span());
        let sigma = f64::from(word.closing());
        let left = [
            (Anchor::Box, (Matrix2::identity() * sigma - one).determinant()),
            (Anchor::Block, (Matrix4::identity() * sigma - pair).determinant()),
        ];
        left.map(|(anchor, left)| (left.abs() < RESONANT).then_some(anchor))
    }

    /// Whether the block has no spring.
    pub fn has_free_block(&self) -> bool {
        self.parameters.coupling_stiffness == 0.0
    }

    /// Acceleration of a block without a spring under its load, units of ω1² L.
    pub(super) fn pull(&self) -> f64 {
        self.pull
    }

    /// Whether the impulses of a word can balance, over one pass of the word, the load on a body
    /// without a spring (docs/theory.md (113)). Without a load the word needs both stops; with a
    /// load it needs the stop towards which the load pulls.
    pub(super) fn balances(&self, word: &OrbitWord) -> bool {
        let p = &self.parameters;
        let has = |side: i8| word.letters().contains(&side);
        let held = p.box_stiffness > 0.0 && p.coupling_stiffness > 0.0 && p.secondary_stiffness > 0.0;
        if held || word.closing() < 0 {
            true
        } else if self.pull == 0.0 {
            has(1) == has(-1)
        } else {
            has(if self.pull > 0.0 { 1 } else { -1 })
        }
    }

    /// Whether the motion without impacts attracts its neighbourhood: all bodies have springs and
    /// are reached by dampers.
    pub(super) fn holds_and_damps(&self) -> bool {
        let p = &self.parameters;
        let needed = [
            p.box_stiffness,
            p.box_damping,
            p.coupling_stiffness,
            p.secondary_stiffness,
            p.secondary_damping,
        ];
        needed.iter().all(|c| *c > 0.0)
    }

    /// The period of an orbit with a word, s.
    pub(super) fn period(&self, word: &OrbitWord) -> f64 {
        self.parameters.period() * f64::from(word.period())
    }

    /// The machine's parameters, without its [loads](Self::loads).
    pub fn parameters(&self) -> &Parameters {
        &self.parameters
    }

    /// The constant loads.
    pub fn loads(&self) -> ConstantLoads {
        self.loads
    }

    /// w_s, the displacement of the block in the box that the loads cause without impacts, units
    /// of L.
    pub fn offset(&self) -> f64 {
        self.balance.offset()
    }

    /// This machine with the rest positions as reference positions, however far away they are: a
    /// motion without impacts oscillates about them.
    pub(super) fn at_rest(self) -> Self {
        Self { balance: self.balance.at_rest(), ..self }
    }

    /// Whether the mirror image of each motion is also a motion: only without loads.
    pub fn is_symmetric(&self) -> bool {
        self.loads == ConstantLoads::default()
    }

    /// |H|, the amplitude of the block in the box without impacts, units of L.
    pub fn amplitude(&self) -> f64 {
        self.response.norm()
    }

    /// Amplitude and angle of the gap's motion without impacts,
    /// `offset + amplitude sin(φ + angle)`.
    pub(super) fn wave(&self) -> (f64, f64) {
        (self.response.norm(), (-self.response).arg())
    }

    /// w, w' and w'' of the motion without impacts at a phase.
    pub(super) fn forced_gap(&self, phase: f64) -> [f64; 3] {
        let turned = -self.response * Complex::cis(phase);
        let [x1, x2, _] = self.balance.places;
        [turned.im + (x2 - x1), turned.re, -turned.im]
    }

    /// The motion without impacts at a phase.
    pub(super) fn forced(&self, phase: f64) -> Vector6 {
        let turned = self.response * Complex::cis(phase);
        let [x1, x2, x3] = self.balance.places;
        Vector6::new(x1 + turned.im, x2, x3, turned.re, 0.0, 0.0)
    }

    /// Reference positions of the states, units of L: the rest positions under the loads, unless
    /// these are far beyond the stops.
    pub(super) fn rest_positions(&self) -> [f64; 3] {
        self.balance.places
    }

    /// Clearance of the block from the nearer stop without impacts, units of L; `None` if there is
    /// no such motion, because a block without a spring falls under a load.
    pub(super) fn clearance(&self) -> Option<f64> {
        (self.pull == 0.0).then(|| 1.0 - self.amplitude() - self.offset().abs())
    }

    /// Rate of the free part of a state in flight: A z plus the constant part of docs/theory.md
    /// (111).
    pub(super) fn rate(&self, z: &Vector6) -> Vector6 {
        self.flight.rate_of(z, 0.0) + self.balance.push
    }

    /// The free part of a state after a flight with a given span and map.
    pub(super) fn state_after(&self, transition: &Transition, span: f64, z: &Vector6) -> Vector6 {
        let after = transition.apply(z);
        if self.balance.push == Vector6::zeros() || span == 0.0 { after } else { after + self.fall(span) }
    }

    /// Displacement of a state by the loads over a flight that starts at rest at the reference
    /// positions.
    fn fall(&self, span: f64) -> Vector6 {
        let pieces = self.flight.least_pieces(span);
        let length = span / f64::from(pieces);
        let (one, transition) = (self.fall_piece(length), self.flight.transition(length));
        let step = Flight::state(&one, 1.0, length);
        (0..pieces).fold(Vector6::zeros(), |fallen, _| transition.apply(&fallen) + step)
    }

    /// The fall over a Taylor piece as polynomials. For z' = A z + d with constant d, the state
    /// that starts from z = 0 is the integral of the free flight that starts from d.
    pub(super) fn fall_piece(&self, length: f64) -> [Polynomial; 3] {
        let free = self.flight.piece(&self.balance.push, 0.0, length, 0.0);
        free.map(|x| {
            std::array::from_fn(|k| match k.checked_sub(1) {
                None => 0.0,
                Some(before) => length * x[before] / k as f64,
            })
        })
    }

    /// The free part of a state after a flight over a span.
    pub(super) fn fly(&self, span: f64, z: &Vector6) -> Vector6 {
        self.state_after(&self.flight.transition(span), span, z)
    }

    /// A state in SI units from a state in units of L and ω1 L.
    pub(super) fn si(&self, y: &Vector6) -> State {
        let length = self.parameters.stop_gap;
        let speed = length * self.parameters.drive_frequency;
        State { x: [0, 1, 2].map(|i| length * y[i]), v: [3, 4, 5].map(|i| speed * y[i]) }
    }

    /// The error that names the parameter for which the periodic response to impulses is singular:
    /// the motion without impacts then has a neutral direction.
    pub(super) fn singular(&self) -> vibro_impact::Error {
        let p = &self.parameters;
        let damped = "a value > 0, because without damping a mode is in resonance with the orbit";
        // The first contact can replace the return of one softly held body, but not of two.
        let soft: Vec<Anchor> = Anchor::held(p)
            .into_iter()
            .filter(|(_, part)| *part <= NEUTRAL)
            .map(|(anchor, _)| anchor)
            .collect();
        let (name, value, allowed) = if soft.len() > 1 && soft.contains(&Anchor::Box) {
            let held = "a larger value, because without a spring the box has no equilibrium position";
            ("box.k", p.box_stiffness, held)
        } else if soft.len() > 1 {
            let held = "a larger value, because without a spring the secondary oscillator has no \
                        equilibrium position";
            ("secondary.k", p.secondary_stiffness, held)
        } else if p.box_damping == 0.0 {
            ("box.c", 0.0, damped)
        } else if p.secondary_damping == 0.0 {
            ("secondary.c", 0.0, damped)
        } else {
            ("drive.frequency", p.drive_frequency, "a value away from the resonance of a weakly damped mode")
        };
        let needed_by = "impact phases of a periodic orbit as unknowns";
        vibro_impact::Error::Undefined { name, value, needed_by, allowed }
    }
}
