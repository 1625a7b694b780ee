//! The powers of a machine's loads and losses, as products of two linear functions of the state,
//! with the contact states that each requires (docs/assembly-law.md, section 9).

use super::{BranchLaw, ContactRows, System};
use crate::curved::HUNT_CROSSLEY;
use crate::description::StopLaw;
use crate::functional::Functional;
use crate::kernel::Sparse;
use crate::mode::{FrictionState, Mode, SliderState, StopState};
use std::sync::Arc;

/// The account to which a power belongs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Account {
    /// Work of a load.
    Load(usize),
    /// Work of prescribed motions.
    Motions,
    /// Loss in a spring's dashpot.
    Dashpot(usize),
    /// Loss in a compliant stop.
    Stop(usize),
    /// Loss in a friction element.
    Friction(usize),
    /// Loss in the dashpot or slider in series with a spring.
    Branch(usize),
}

/// A factor times the product of two linear functions of the state.
#[derive(Clone, Debug)]
pub struct Power {
    /// The account to which its work is added.
    pub account: Account,
    /// The factor.
    pub factor: f64,
    /// Indices of the two functions.
    pub of: [usize; 2],
}

/// Contact states that a power requires.
#[derive(Clone, Copy, Debug)]
enum When {
    Always,
    Stop(usize, StopState),
    Friction(usize, FrictionState),
    /// State of a friction element, and state of the stop whose force sets its level.
    Following((usize, FrictionState), (usize, StopState)),
    Slider(usize, SliderState),
}

/// Powers of the loads and losses of a machine, for all modes. A compliant stop loses the work
/// done on it minus the increase of its stored energy ½ k max(0, e - gap)².
#[derive(Clone, Debug)]
pub struct Losses {
    /// The linear functions of all powers.
    pub rows: Arc<Vec<Sparse>>,
    all: Vec<(When, Power)>,
}

impl Losses {
    /// The powers of a machine.
    pub fn new(system: &System) -> Self {
        let mut rows: Vec<Sparse> = Vec::new();
        let mut all = Vec::new();
        let mut put = |when: When, account: Account, factor: f64, left: &Functional, right: &Functional| {
            let own = [left, right].map(|row| AsRef::<Sparse>::as_ref(row).clone());
            if factor == 0.0 || own.iter().any(|row| row.terms().is_empty()) {
                return;
            }
            let is_square = own[0] == own[1];
            let [left, right] = own;
            rows.push(left);
            let of = if is_square { [rows.len() - 1; 2] } else { [rows.len() - 1, rows.len()] };
            rows.extend((!is_square).then_some(right));
            all.push((when, Power { account, factor, of }));
        };
        for (i, (row, &body)) in system.loads.iter().zip(&system.load_bodies).enumerate() {
            put(When::Always, Account::Load(i), 1.0, row, system.seen(body)[1]);
            for &(stop, factor) in &system.load_limits[i] {
                let (when, excess) = (When::Stop(stop, StopState::Pressed), &system.stops[stop].excess);
                put(when, Account::Load(i), factor, excess, &system.bodies[body].v);
            }
        }
        for (i, spring) in system.springs.iter().enumerate() {
            let rate = &spring.elongation.rate;
            put(When::Always, Account::Dashpot(i), spring.damping, rate, rate);
            for &(curve, factor) in &spring.curves {
                let curved = &system.curved[curve];
                if curved.is_of_rate {
                    let force = Functional::unit(system.signals.size, curved.place, 1.0);
                    put(When::Always, Account::Dashpot(i), factor, &force, rate);
                }
            }
            if let Some(own) = &spring.formula {
                put(When::Always, Account::Dashpot(i), 1.0, &own.lossy, rate);
            }
        }
        for (i, stop) in system.stops.iter().enumerate() {
            let (rate, account) = (&stop.elongation.rate, Account::Stop(i));
            if let StopLaw::Compliant { damping, .. } = stop.law {
                put(When::Stop(i, StopState::Pressed), account, damping, rate, rate);
            }
            if let Some(ContactRows { dissipation, product, .. }) = &stop.contact {
                let factor = HUNT_CROSSLEY * dissipation * stop.stiffness();
                put(When::Stop(i, StopState::Pressed), account, factor, product, rate);
            }
            if stop.is_limited() {
                put(When::Stop(i, StopState::Free), account, -1.0, &stop.spring, rate);
                put(When::Stop(i, StopState::Capped), account, 1.0, &stop.spring, rate);
            }
        }
        for (i, friction) in system.frictions.iter().enumerate() {
            for state in [FrictionState::Up, FrictionState::Down] {
                let (account, rate) = (Account::Friction(i), &friction.elongation.rate);
                for (place, own) in friction.levels.iter().enumerate() {
                    let when = match &friction.follows {
                        None => When::Friction(i, state),
                        Some(all) => When::Following((i, state), all[place]),
                    };
                    put(when, account, state.direction(), &own.level, rate);
                }
            }
        }
        for (i, branch) in system.branches.iter().enumerate() {
            let account = Account::Branch(i);
            match branch.law {
                BranchLaw::Dashpot(damping) => {
                    put(When::Always, account, 1.0 / damping, &branch.force, &branch.force);
                }
                BranchLaw::Slider(_) => {
                    for state in [SliderState::Up, SliderState::Down] {
                        let level = system.branch_force(i, state);
                        put(When::Slider(i, state), account, 1.0, &level, &branch.elongation.rate);
                    }
                }
                BranchLaw::Contact { .. } => {
                    for state in [SliderState::Up, SliderState::Down] {
                        let Some(level) = &branch.level else { continue };
                        put(
                            When::Slider(i, state),
                            account,
                            1.0,
                            level,
                            &branch.slip_rate(state.direction()),
                        );
                    }
                }
            }
        }
        Self { rows: Arc::new(rows), all }
    }

    /// The powers that act in a mode.
    pub fn of_mode(&self, mode: &Mode) -> impl Iterator<Item = &Power> {
        let acts = |when: When| match when {
            When::Always => true,
            When::Stop(i, state) => mode.stops[i] == state,
            When::Friction(i, state) => mode.frictions[i] == state,
            When::Following((i, state), (stop, pressed)) => {
                mode.frictions[i] == state && mode.stops[stop] == pressed
            }
            When::Slider(i, state) => mode.sliders[i] == state,
        };
        self.all.iter().filter(move |(when, _)| acts(*when)).map(|(_, power)| power)
    }
}
