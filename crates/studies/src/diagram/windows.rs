//! Diagrams read as a whole: windows of one class, hysteresis between the two directions.

use super::{Diagram, DiagramPoint};
use crate::class::MotionClass;

/// Window of neighbouring values at which motions have the same class.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Window {
    /// The first value.
    pub from: f64,
    /// The last one.
    pub to: f64,
    /// Class of the motions.
    pub class: MotionClass,
}

impl<P: DiagramPoint> Diagram<P> {
    /// Values at which the two directions end on attractors that are neither equal nor mirror
    /// images. Two without a period are distinct where their [means](crate::paper::statistics)
    /// certainly differ; a motion that has not settled is on no attractor.
    pub fn hysteresis(&self) -> Vec<bool> {
        self.apart().into_iter().map(|apart| apart == Some(true)).collect()
    }

    /// Whether the two directions end on [other attractors](Self::hysteresis), by value; `None`
    /// where that is undecided: a motion has not settled or was refused, or neither has a period
    /// and their means do not tell.
    pub fn apart(&self) -> Vec<Option<bool>> {
        self.up.iter().zip(&self.down).map(|(a, b)| a.as_ref()?.differs(b.as_ref()?)).collect()
    }

    /// The motion at the value of the rising direction that is nearest to `value`; `None` where the
    /// simulator refused all.
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
