//! Diagrams as a whole: windows of one class, hysteresis between the two directions.

use super::{Diagram, DiagramPoint};
use crate::class::MotionClass;

/// Window of neighbouring values at which motions have the same class.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Window {
    /// The first value.
    pub from: f64,
    /// The last value.
    pub to: f64,
    /// Class of the motions.
    pub class: MotionClass,
}

impl<P: DiagramPoint> Diagram<P> {
    /// Values at which the two directions end on attractors that are neither equal nor mirror
    /// images. For two attractors without a period only the [means](crate::paper::statistics) of
    /// the paper's machine decide. A motion that has not settled does not count.
    pub fn hysteresis(&self) -> Vec<bool> {
        self.apart().into_iter().map(|apart| apart == Some(true)).collect()
    }

    /// Whether the two directions end on [different attractors](Self::hysteresis), by value.
    /// `None` if that is undecided: a motion has not settled or was refused, or neither has a
    /// period and no means decide.
    pub fn apart(&self) -> Vec<Option<bool>> {
        self.up.iter().zip(&self.down).map(|(a, b)| a.as_ref()?.differs(b.as_ref()?)).collect()
    }

    /// The motion at the value of the rising direction nearest to `value`; `None` if the simulator
    /// refused all.
    pub fn nearest(&self, value: f64) -> Option<&P> {
        let near = |a: &&P, b: &&P| (a.value() - value).abs().total_cmp(&(b.value() - value).abs());
        self.up.iter().flatten().min_by(near)
    }

    /// The windows of a direction in its order.
    pub fn windows(points: &[Option<P>]) -> Vec<Window> {
        let mut found: Vec<Window> = Vec::new();
        for point in points.iter().flatten() {
            let (value, class) = (point.value(), point.class());
            match found.last_mut().filter(|w| w.class == class) {
                Some(window) => window.to = value,
                None => found.push(Window { from: value, to: value, class }),
            }
        }
        found
    }
}
