//! Panel of the maxima of the paper's machine over a bifurcation diagram.

use super::lengths::Lengths;
use crate::studies::panels::{reach, shaded};
use crate::studies::parameter_axis;
use vibro_figures::canvas::palette::HERE;
use vibro_figures::chart::{Dash, Layer, Panel, THIN};
use vibro_studies::paper::ParameterSet;
use vibro_studies::paper::bifurcation::{Diagram, Sweep, SweepPoint};

/// The panel of all maxima: shaded by frequency, with the falling direction at values where it
/// settles on another motion, and a mark at the set's own value.
pub(super) fn maxima_panel(
    set: &ParameterSet,
    sweep: &Sweep,
    diagram: &Diagram,
    apart: &[Option<bool>],
) -> Panel {
    let (axis, lengths) = (&sweep.axis, Lengths::of(set));
    let symbol = lengths.displacement(sweep.of.symbol());
    let length = |p: &SweepPoint, x: f64| lengths.ratio(axis.name, p.value) * x;
    let (x, y) = (axis.edges(), reach(diagram, &length, 1e-3));
    let mut layers = shaded((axis, sweep.keep), diagram, apart, (y, &length));
    let own = axis.name.value(set);
    if set.is_set(axis.name) && (axis.from..=axis.to).contains(&own) {
        let name = format!("this set: {}", set.told(axis.name, own));
        let line = vec![(own, y.0), (own, y.1)];
        layers.push(Layer::line(&name, HERE, Dash::Dotted, line).stroke(THIN));
    }
    Panel {
        title: format!("Local maxima of {symbol}"),
        x: parameter_axis(set, axis.name, x),
        y: lengths.axis_over(&symbol, y.0, y.1),
        layers,
    }
}
