//! A ball that falls on a floor and bounces: a table of its variables, and its exact motion from
//! impact to impact. `main.rs` makes an FMU of it, for both interface types of both versions, with
//! event mode, intermediate update, an event indicator and saved states.

use fmi_doors::description::Experiment;
use fmi_doors::tabular::{Row, Tabular};

/// The ball.
pub enum Ball {}

// Places in the table.
const TIME: usize = 0;
const GRAVITY: usize = 1;
const RESTITUTION: usize = 2;
const HEIGHT: usize = 3;
const SPEED: usize = 4;
const HEIGHT_RATE: usize = 5;
const SPEED_RATE: usize = 6;
const BOUNCES: usize = 7;

/// Shortest flight, s. If the next flight would be shorter, the ball stays on the floor.
const REST: f64 = 1e-5;

/// Whether the ball stays on the floor: height and velocity are zero. In a flight both are never
/// zero at once, since its height is positive at the top.
fn rests(x: &[f64]) -> bool {
    x[HEIGHT] == 0.0 && x[SPEED] == 0.0
}

impl Tabular for Ball {
    const NAME: &'static str = "BouncingBall";
    const IDENTIFIER: &'static str = "bouncing_ball";
    const DESCRIPTION: &'static str = "A ball that falls on a floor and bounces";
    const VERSION: &'static str = env!("CARGO_PKG_VERSION");
    const ROWS: &'static [Row] = &[
        Row::time("time"),
        Row::parameter("g", "m/s2", 9.81, "Gravity").within(f64::MIN_POSITIVE, f64::MAX),
        Row::parameter("e", "1", 0.7, "Restitution coefficient").within(0.0, 1.0),
        Row::state("h", "m", 1.0, "Height above the floor").within(0.0, f64::MAX),
        Row::state("v", "m/s", 0.0, "Speed upwards"),
        Row::derivative("der(h)", "m/s", HEIGHT, "Rate of the height"),
        Row::derivative("der(v)", "m/s2", SPEED, "Acceleration upwards"),
        Row::counter("bounces", "Bounces so far"),
    ];
    const INDICATORS: &'static [usize] = &[HEIGHT];
    const EXPERIMENT: Experiment =
        Experiment { start_time: 0.0, stop_time: 3.0, tolerance: 1e-6, step_size: 0.01 };

    fn evaluate(x: &mut [f64]) {
        x[HEIGHT_RATE] = x[SPEED];
        x[SPEED_RATE] = if rests(x) { 0.0 } else { -x[GRAVITY] };
    }

    fn advance(x: &mut [f64], time: f64) {
        let (dt, a) = (time - x[TIME], x[SPEED_RATE]);
        x[HEIGHT] += (x[SPEED] + 0.5 * a * dt) * dt;
        x[SPEED] += a * dt;
    }

    /// Time of the next impact; the present time if the ball is at the floor and falls.
    fn next_event(x: &[f64]) -> f64 {
        if rests(x) {
            return f64::INFINITY;
        }
        let fall = 2.0 * x[GRAVITY] * x[HEIGHT].max(0.0);
        x[TIME] + (x[SPEED] + (x[SPEED].powi(2) + fall).sqrt()) / x[GRAVITY]
    }

    fn event(x: &mut [f64]) -> String {
        (x[HEIGHT], x[SPEED]) = (0.0, -x[RESTITUTION] * x[SPEED]);
        if 2.0 * x[SPEED] < REST * x[GRAVITY] {
            x[SPEED] = 0.0;
        }
        x[BOUNCES] += 1.0;
        format!("bounce, upwards with {} m/s,", x[SPEED])
    }
}
