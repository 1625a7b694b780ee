//! A ball that falls on a floor and bounces: a component with two states, an event indicator, event mode and saved states, for
//! both interface types of both versions. Between impacts its motion is exact, and so is the time of each impact.
//!
//! `cargo build --example bouncing_ball` makes the library that hosts load; `cargo run --example describe` writes its descriptions.

use fmi_doors::description::{Capabilities, Causality, CoSimulation, Description, Experiment, ModelExchange};
use fmi_doors::description::{Type, Unit, Unknown, Variable};
use fmi_doors::log::{Category, Log};
use fmi_doors::{Advance, Bases, Component, Handled, Instantiation, Life, Named, Phase, Problem};
use serde::{Deserialize, Serialize};

fmi_doors::export!(Ball);

/// The variables, by value reference counted from 1.
const NAMES: [&str; 8] = ["time", "g", "e", "h", "v", "der(h)", "der(v)", "bounces"];
const TIME: u32 = 1;
const GRAVITY: u32 = 2;
const RESTITUTION: u32 = 3;
const HEIGHT: u32 = 4;
const SPEED: u32 = 5;
const HEIGHT_RATE: u32 = 6;
const SPEED_RATE: u32 = 7;
const BOUNCES: u32 = 8;
/// A flight shorter than this, s, is none: the ball stays on the floor.
const REST: f64 = 1e-5;

/// The ball; before initialization ends, its motion is the start.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Ball {
    life: Life,
    /// Acceleration by gravity, m/s2, and restitution coefficient.
    gravity: f64,
    restitution: f64,
    /// Time, s; height of its lowest point above the floor, m; speed upwards, m/s.
    time: f64,
    height: f64,
    speed: f64,
    resting: bool,
    bounces: u32,
}

impl Ball {
    fn new(life: Life) -> Self {
        let (gravity, restitution) = (9.81, 0.7);
        let (time, height, speed) = (0.0, 1.0, 0.0);
        Self { life, gravity, restitution, time, height, speed, resting: false, bounces: 0 }
    }

    /// Whether it touches the floor and has not bounced yet.
    fn is_due(&self) -> bool {
        !self.resting && self.height <= 0.0 && self.speed < 0.0
    }

    /// When it falls on the floor next, s; never where it rests.
    fn impact(&self) -> f64 {
        match self.resting {
            true => f64::INFINITY,
            false if self.is_due() => self.time,
            false => {
                self.time
                    + (self.speed + (self.speed.powi(2) + 2.0 * self.gravity * self.height).sqrt())
                        / self.gravity
            }
        }
    }

    /// Free flight up to a time.
    fn fly(&mut self, time: f64) {
        if !self.resting {
            let dt = time - self.time;
            self.height += (self.speed - 0.5 * self.gravity * dt) * dt;
            self.speed -= self.gravity * dt;
        }
        self.time = time;
    }

    fn bounce(&mut self, log: &mut dyn Log) {
        self.bounces = self.bounces.saturating_add(1);
        (self.height, self.speed) = (0.0, -self.restitution * self.speed);
        if 2.0 * self.speed < REST * self.gravity {
            (self.speed, self.resting) = (0.0, true);
        }
        if log.wants(Category::Events) {
            log.log(
                Category::Events,
                &format!("bounce at t = {} s, upwards with {} m/s", self.time, self.speed),
            );
        }
    }

    fn value(&self, reference: u32) -> f64 {
        match reference {
            TIME => self.time,
            GRAVITY => self.gravity,
            RESTITUTION => self.restitution,
            HEIGHT => self.height,
            SPEED | HEIGHT_RATE => self.speed,
            SPEED_RATE => {
                if self.resting {
                    0.0
                } else {
                    -self.gravity
                }
            }
            _ => self.bounces.into(),
        }
    }

    /// The name of a variable that has one of the types.
    fn name(&self, reference: u32, bases: Bases) -> Result<&'static str, Problem> {
        let own = if reference == BOUNCES { fmi_doors::Base::Integer } else { fmi_doors::Base::Real };
        let found = NAMES.get((reference as usize).wrapping_sub(1)).filter(|_| bases.contains(own));
        let allowed = || "allowed are those of the model description, from 1 to 8".to_owned();
        found.copied().ok_or_else(|| Problem::Reference { reference, wanted: bases.name, found: allowed() })
    }
}

impl Component for Ball {
    type Problem = Problem;
    type State = Self;
    type Pieces = ();

    fn instantiate(request: &Instantiation<'_>) -> Result<Self, Problem> {
        request.check_token(&token())?;
        Ok(Self::new(request.life()))
    }

    fn life(&self) -> &Life {
        &self.life
    }

    fn life_mut(&mut self) -> &mut Life {
        &mut self.life
    }

    fn exit_initialization(&mut self, _: &mut dyn Log) -> Result<(), Problem> {
        self.time = self.life.start_time();
        self.life.begin();
        Ok(())
    }

    fn reset(&mut self) {
        *self = Self::new(Life::new(self.life.interface, self.life.handling));
    }

    fn time(&self) -> f64 {
        self.time
    }

    fn variable(&self, reference: u32) -> Result<Named<'_>, Problem> {
        let name = self.name(reference, Bases::ANY)?.into();
        let intermediate_update = [HEIGHT, SPEED].contains(&reference);
        Ok(Named { name, continuous_input: false, intermediate_update })
    }

    fn get(
        &mut self,
        bases: Bases,
        references: &[u32],
        mut write: impl FnMut(usize, f64),
    ) -> Result<(), Problem> {
        references.iter().try_for_each(|reference| self.name(*reference, bases).map(drop))?;
        references.iter().enumerate().for_each(|(i, reference)| write(i, self.value(*reference)));
        Ok(())
    }

    fn set(&mut self, bases: Bases, references: &[u32], read: impl Fn(usize) -> f64) -> Result<(), Problem> {
        let mut after = self.clone();
        for (i, &reference) in references.iter().enumerate() {
            let (name, value) = (self.name(reference, bases)?, read(i));
            let early = [Phase::Instantiated, Phase::Initialization].contains(&self.life.phase);
            let (place, range, allowed) = match reference {
                GRAVITY => (&mut after.gravity, f64::MIN_POSITIVE..=f64::MAX, "a finite number > 0"),
                RESTITUTION => (&mut after.restitution, 0.0..=1.0, "a number from 0 to 1"),
                HEIGHT => (&mut after.height, 0.0..=f64::MAX, "a finite number >= 0"),
                SPEED => (&mut after.speed, f64::MIN..=f64::MAX, "a finite number"),
                _ => return Err(not_settable(name, self.life.phase)),
            };
            if !early {
                return Err(not_settable(name, self.life.phase));
            }
            if !range.contains(&value) {
                return Err(Problem::value(name, value, allowed));
            }
            *place = value;
        }
        *self = after;
        Ok(())
    }

    fn handle_events(&mut self, log: &mut dyn Log) -> Result<Handled, Problem> {
        let states = self.is_due();
        if states {
            self.bounce(log);
        }
        Ok(Handled { states, nominals: false })
    }

    fn next_event_time(&mut self) -> Option<f64> {
        let stepping = self.life.interface == fmi_doors::Interface::CoSimulation;
        Some(self.impact()).filter(|time| stepping && time.is_finite())
    }

    /// To the end, or before the next bounce where the host handles events and takes steps that end early.
    fn advance(&mut self, point: f64, size: f64, log: &mut dyn Log) -> Result<Advance, Problem> {
        self.life.check_step(point, size, self.time)?;
        let (end, handling, bounces) = (point + size, self.life.handling, self.bounces);
        self.life.phase = Phase::Step;
        loop {
            let impact = self.impact();
            if impact > end {
                self.fly(end);
                let event = handling.event_mode && self.bounces > bounces;
                return Ok(Advance { time: end, event, early: false });
            }
            self.fly(impact);
            (self.height, self.speed) = (0.0, self.speed.min(-0.0));
            if handling.event_mode && handling.early_return && self.is_due() {
                return Ok(Advance { time: impact, event: true, early: impact < end });
            }
            self.bounce(log);
        }
    }

    fn number_of_continuous_states(&self) -> usize {
        2
    }

    fn number_of_event_indicators(&self) -> usize {
        1
    }

    fn set_time(&mut self, time: f64) -> Result<(), Problem> {
        if !time.is_finite() {
            return Err(Problem::value("time", time, "a finite number"));
        }
        self.time = time;
        Ok(())
    }

    fn set_continuous_states(&mut self, states: &[f64]) -> Result<(), Problem> {
        match *states {
            [height, speed] if height.is_finite() && speed.is_finite() => {
                (self.height, self.speed) = (height, speed);
                Ok(())
            }
            _ => Err(Problem::value("h or v", f64::NAN, "a finite number")),
        }
    }

    fn continuous_states(&self) -> Result<impl AsRef<[f64]>, Problem> {
        Ok([self.height, self.speed])
    }

    fn state_derivatives(&self) -> Result<impl AsRef<[f64]>, Problem> {
        Ok([self.value(HEIGHT_RATE), self.value(SPEED_RATE)])
    }

    fn event_indicators(&self) -> Result<impl AsRef<[f64]>, Problem> {
        Ok([self.height])
    }

    fn save(&self) -> Result<Self, Problem> {
        Ok(self.clone())
    }

    fn restore(&mut self, saved: &Self) -> Result<(), Problem> {
        let mut life = self.life;
        life.take_over(&saved.life)?;
        *self = Self { life, ..saved.clone() };
        Ok(())
    }

    fn serialize(&self, saved: &Self) -> Result<Vec<u8>, Problem> {
        postcard::to_stdvec(&(token(), saved)).map_err(refused)
    }

    fn deserialize(&self, bytes: &[u8]) -> Result<Self, Problem> {
        let (written_by, ball): (String, Self) = postcard::from_bytes(bytes).map_err(refused)?;
        let numbers = [ball.gravity, ball.restitution, ball.time, ball.height, ball.speed];
        if written_by == token() && numbers.iter().all(|number| number.is_finite()) && ball.gravity > 0.0 {
            return Ok(ball);
        }
        Err(Problem::SavedState { what: "it is not of this FMU".into() })
    }
}

fn refused(error: postcard::Error) -> Problem {
    Problem::SavedState { what: error.to_string().into() }
}

fn not_settable(name: &'static str, phase: Phase) -> Problem {
    Problem::NotSettable {
        name: name.into(),
        phase: phase.words(),
        allowed: "g, e, h and v until initialization ends",
    }
}

/// What tells the library and another description apart.
fn token() -> String {
    fmi_doors::identifier::identifier(concat!("bouncing ball ", env!("CARGO_PKG_VERSION")))
}

/// What `modelDescription.xml` says, of both versions.
pub fn description() -> Description {
    let time = Type::real("Time", "Time", "s");
    let length = Type::real("Position", "Length", "m");
    let velocity = Type::real("Velocity", "Velocity", "m/s");
    let acceleration = Type::real("Acceleration", "Acceleration", "m/s2");
    let number = Type::real("Number", "DimensionlessRatio", "1");
    let real = |reference: u32, declared, causality, text| {
        Variable::real(reference, NAMES[reference as usize - 1], declared, causality, text)
    };
    let variables = vec![
        real(TIME, &time, Causality::Independent, "Time"),
        Variable {
            min: Some(0.0),
            ..real(GRAVITY, &acceleration, Causality::Parameter, "Gravity").starting_at(9.81)
        },
        Variable {
            min: Some(0.0),
            max: Some(1.0),
            ..real(RESTITUTION, &number, Causality::Parameter, "Restitution coefficient").starting_at(0.7)
        },
        Variable {
            min: Some(0.0),
            ..real(HEIGHT, &length, Causality::Output, "Height above the floor")
                .starting_at(1.0)
                .reinitialized()
        },
        real(SPEED, &velocity, Causality::Output, "Speed upwards").starting_at(0.0).reinitialized(),
        real(HEIGHT_RATE, &velocity, Causality::Local, "Rate of the height").derivative_of(HEIGHT),
        real(SPEED_RATE, &acceleration, Causality::Local, "Acceleration upwards").derivative_of(SPEED),
        real(BOUNCES, &number, Causality::Output, "Bounces so far").counting(),
    ];
    let unit = |name: &'static str, m, s| Unit {
        name: name.into(),
        exponents: [0, m, s, 0, 0, 0, 0, 0],
        display: vec![],
    };
    Description {
        model_name: "BouncingBall".into(),
        model_identifier: "bouncing_ball".into(),
        token: token().into(),
        description: "A ball that falls on a floor and bounces".into(),
        author: "".into(),
        version: env!("CARGO_PKG_VERSION").into(),
        copyright: "".into(),
        license: env!("CARGO_PKG_LICENSE").into(),
        generation_tool: "fmi-doors".into(),
        generation_date_and_time: None,
        structured_names: true,
        model_exchange: Some(ModelExchange {
            needs_completed_integrator_step: false,
            number_of_event_indicators: 1,
        }),
        co_simulation: Some(CoSimulation {
            might_return_early_from_do_step: true,
            has_event_mode: true,
            ..CoSimulation::default()
        }),
        capabilities: Capabilities {
            can_get_and_set_fmu_state: true,
            can_serialize_fmu_state: true,
            ..Capabilities::default()
        },
        units: vec![
            unit("s", 0, 1),
            unit("m", 1, 0),
            unit("m/s", 1, -1),
            unit("m/s2", 1, -2),
            unit("1", 0, 0),
        ],
        types: vec![time, length, velocity, acceleration, number],
        log_categories: fmi_doors::messages::log_categories("Each bounce", "Why a value was not taken")
            .to_vec(),
        experiment: Experiment { start_time: 0.0, stop_time: 3.0, tolerance: 1e-6, step_size: 0.01 },
        variables,
        outputs: vec![Unknown::on(HEIGHT, [HEIGHT]), Unknown::on(SPEED, [SPEED]), Unknown::on(BOUNCES, [])],
        derivatives: vec![Unknown::on(HEIGHT_RATE, [SPEED]), Unknown::on(SPEED_RATE, [GRAVITY])],
        initial_unknowns: vec![
            Unknown::on(HEIGHT_RATE, [SPEED]),
            Unknown::on(SPEED_RATE, [GRAVITY]),
            Unknown::on(BOUNCES, []),
        ],
        event_indicators: vec![Unknown::on(HEIGHT, [HEIGHT])],
    }
}
