//! Smooth pieces of a motion, for measures and variations, which need more than states at
//! communication points.
//!
//! The simulator is used through its public methods. The state at the start of each piece is
//! exact, so the series of the flow (docs/theory.md (8)) reproduces the motion.

use vibro_impact::error::{Error, Result};
use vibro_impact::flow::expand_along;
use vibro_impact::model::{Augmented, Model, SmoothMode};
use vibro_impact::simulator::{Event, Pause, Simulator};

/// End of a piece.
#[derive(Clone, Copy, Debug)]
pub(crate) enum PieceEnd {
    /// At an impact.
    Impact {
        /// +1 upper, -1 lower.
        side: f64,
        /// w' before the impact.
        rate: f64,
        /// Impulse on the box in direction `side`, N·s.
        impulse: f64,
        /// State after the impact and, if the block comes to rest, after the merge.
        after: Augmented,
        /// Whether the block comes to rest.
        rests: bool,
    },
    /// The block leaves its stop.
    Release,
    /// The requested end.
    End,
}

/// Smooth piece of a motion.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SmoothPiece {
    pub(crate) mode: SmoothMode,
    pub(crate) start: Augmented,
    /// Duration, s.
    pub(crate) span: f64,
    pub(crate) end: PieceEnd,
}

/// Refuses loads other than constant ones: the flow along a piece and its variations hold for the
/// machine under its drive and its constant loads.
///
/// # Errors
/// [`Error::OutOfRange`] with the first other load that is not zero.
fn refuse_loads(simulator: &Simulator) -> Result<()> {
    const NAMES: [&str; 3] = ["box.f", "block.f", "secondary.f"];
    let loads = simulator.loads().derivatives;
    for ((name, mut derivatives), constant) in
        NAMES.iter().zip(loads).zip(simulator.parameters().constant_loads)
    {
        derivatives[0] -= constant;
        if let Some(&value) = derivatives.iter().find(|d| **d != 0.0) {
            let allowed = "0, with all its derivatives: maxima, exponents and attractors require \
                           constant loads";
            return Err(Error::OutOfRange { name, value, allowed });
        }
    }
    Ok(())
}

/// Advances a simulator, with no loads except the constant ones of its parameters, to the time
/// `end` (s). Calls `visit` with each smooth piece of its motion.
///
/// # Errors
/// As [`Simulator::advance_until`], and as [`refuse_loads`].
pub(crate) fn smooth_pieces(
    simulator: &mut Simulator,
    model: &Model,
    end: f64,
    visit: &mut dyn FnMut(&SmoothPiece),
) -> Result<()> {
    refuse_loads(simulator)?;
    loop {
        let (mut start, mut time, mut way) =
            (simulator.augmented(), simulator.time(), simulator.contact().mode());
        let (mut release, mut hit, mut rests) = (None, None, false);
        // The simulator stops at the first impact; before it there is at most one release.
        simulator.advance_until(
            end,
            Pause::AfterImpact,
            Some(&mut |event| match *event {
                Event::Release { time, .. } => release = Some(time),
                Event::Impact { time, side, speed, impulse } => {
                    hit = Some((time, f64::from(side), speed, impulse));
                }
                Event::Rest { .. } => rests = true,
            }),
        )?;
        if let Some(at) = release {
            visit(&SmoothPiece { mode: way, start, span: at - time, end: PieceEnd::Release });
            let forces = model.constant_forces();
            start = expand_along(model, way, (&start, forces.as_ref()), at - time, |_, _| ());
            (time, way) = (at, SmoothMode::Flight);
        }
        let Some((at, side, speed, impulse)) = hit else {
            visit(&SmoothPiece { mode: way, start, span: end - time, end: PieceEnd::End });
            return Ok(());
        };
        let after = simulator.augmented();
        let end = PieceEnd::Impact { side, rate: side * speed, impulse, after, rests };
        visit(&SmoothPiece { mode: way, start, span: at - time, end });
    }
}
