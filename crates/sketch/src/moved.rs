//! A layout with moved bodies; everything attached to them moves along.

use crate::layout::{Layout, With};

/// Smallest length of a symbol between approaching bodies.
const LEAST: f64 = 60.0;

impl Layout {
    /// The layout with each body moved along its coordinate by `shift`, and the plates of each
    /// stop `opening` apart; both by name, in units of the drawing.
    pub(crate) fn moved(&self, shift: &dyn Fn(&str) -> f64, opening: &dyn Fn(&str) -> Option<f64>) -> Self {
        let mut moved = self.clone();
        let shifts: Vec<f64> = self.bodies.iter().map(|body| shift(&body.name)).collect();
        let by = |with: With| with.map(|column| column.map_or(0.0, |column| shifts[column]));
        for (body, shift) in moved.bodies.iter_mut().zip(&shifts) {
            (body.left, body.right) = (body.left + shift, body.right + shift);
        }
        for own in &mut moved.placed {
            let ([from, to], length) = (by(own.with), own.to - own.from);
            // A load's arrow ends at its body.
            let from = if own.symbol.is_none() { to } else { from };
            (own.from, own.to) = (own.from + from, own.to + to);
            own.to = own.to.max(own.from + LEAST.min(length));
            own.stretch = own.to - own.from - length;
            own.opening = opening(&own.name);
        }
        for (ends, with) in &mut moved.lines {
            ends.iter_mut().zip(by(*with)).for_each(|(end, by)| end.0 += by);
        }
        moved.texts.iter_mut().for_each(|(at, _, column)| at.0 += shifts[*column]);
        moved
    }
}
