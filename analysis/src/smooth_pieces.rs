//! A motion cut into its smooth pieces, for variations.
//!
//! The simulator is used through its public methods.

use vibro_impact::error::{Error, Result};
use vibro_impact::model::{Augmented, SmoothMode};
use vibro_impact::simulator::{Event, Pause, Simulator};

/// How a piece ends.
#[derive(Clone, Copy, Debug)]
pub(crate) enum PieceEnd {
    /// At an impact.
    Impact {
        /// w' before the impact.
        rate: f64,
        /// The state after it, and after the merge where the block comes to rest.
        after: Augmented,
        /// Whether it comes to rest.
        rests: bool,
    },
    /// The block lets go.
    Release,
    /// At the end asked for.
    End,
}

/// One smooth piece.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Piece {
    pub(crate) mode: SmoothMode,
    /// Its duration, s.
    pub(crate) span: f64,
    pub(crate) end: PieceEnd,
}

/// The flow along a piece and its variations are those of the machine under its drive alone.
///
/// # Errors
/// [`Error::OutOfRange`] with the first load that is not zero.
fn refuse_loads(simulator: &Simulator) -> Result<()> {
    const NAMES: [&str; 3] = ["box.f", "block.f", "secondary.f"];
    let loads = simulator.loads().derivatives;
    for (name, derivatives) in NAMES.iter().zip(loads) {
        if let Some(&value) = derivatives.iter().find(|d| **d != 0.0) {
            let allowed = "0 with all its derivatives: maxima, exponents and attractors are those of the machine without loads";
            return Err(Error::OutOfRange { name, value, allowed });
        }
    }
    Ok(())
}

/// Advances a simulator without loads to the time `end` (s) and calls `visit` with each smooth piece of its motion.
///
/// # Errors
/// As [`Simulator::advance_until`], and as [`refuse_loads`].
pub(crate) fn smooth_pieces(
    simulator: &mut Simulator,
    end: f64,
    visit: &mut dyn FnMut(&Piece),
) -> Result<()> {
    refuse_loads(simulator)?;
    loop {
        let (mut time, mut way) = (simulator.time(), simulator.contact().mode());
        let (mut release, mut hit, mut rests) = (None, None, false);
        // The simulator stops at the first impact; before it, at most one release can happen.
        simulator.advance_until(
            end,
            Pause::AfterImpact,
            Some(&mut |event| match *event {
                Event::Release { time, .. } => release = Some(time),
                Event::Impact { time, side, speed, .. } => hit = Some((time, f64::from(side) * speed)),
                Event::Rest { .. } => rests = true,
            }),
        )?;
        if let Some(at) = release {
            visit(&Piece { mode: way, span: at - time, end: PieceEnd::Release });
            (time, way) = (at, SmoothMode::Flight);
        }
        let Some((at, rate)) = hit else {
            visit(&Piece { mode: way, span: end - time, end: PieceEnd::End });
            return Ok(());
        };
        let after = simulator.augmented();
        let end = PieceEnd::Impact { rate, after, rests };
        visit(&Piece { mode: way, span: at - time, end });
    }
}
