//! Basins of the paper's machine in tables and pictures: attractors with their mirror images.

use super::lengths::Lengths;
use crate::studies::basin::{Listed, ShownBasins};
use crate::table::exact;
use vibro_figures::chart::Axis;
use vibro_studies::basin::{Basins, StartAxis};
use vibro_studies::paper::ParameterSet;
use vibro_studies::paper::basin::ClassedAttractor;
use vibro_studies::paper::stroboscopic::COORDINATES;

impl ShownBasins for ParameterSet {
    const HAS_IMAGES: bool = true;

    fn headings(_: &Basins<ClassedAttractor>) -> Vec<String> {
        let impacts = ["impacts_upper", "impacts_lower"];
        let rest = ["rms_X1", "rms_X2", "rms_X3", "share", "share_of_mirror_image"];
        impacts.into_iter().chain(rest).map(String::from).collect()
    }

    fn listed(&self, found: &ClassedAttractor, shares: [f64; 2]) -> Listed {
        let ClassedAttractor { attractor, class } = found;
        let numbers = attractor.impacts.iter().chain(&attractor.sizes).chain(&shares);
        // For a motion without a period this is a mean, known to two or three digits.
        let [upper, lower] = attractor.impacts.map(|x| match attractor.period {
            Some(_) => exact(x),
            None => format!("{x:.2}"),
        });
        let [own, image] = shares.map(|share| 100.0 * share);
        let means = attractor
            .statistics
            .map_or(String::new(), |statistics| format!("; means over {} drive periods", statistics.periods));
        let class = class.name();
        let told = format!(
            "{class}, {upper} + {lower} impacts a period, {own:.1} % of the starts, its mirror image {image:.1} %{means}"
        );
        Listed { row: numbers.map(|x| exact(*x)).collect(), words: [class, told] }
    }

    fn titles(&self) -> [String; 3] {
        ["Basins of attraction".into(), self.caption(), ", the other initial values zero".into()]
    }

    fn start_axis(&self, axis: &StartAxis) -> Axis {
        let lengths = Lengths::of(self);
        let symbols = ["X₁", "X₂", "X₃"];
        let shown = match COORDINATES.iter().position(|name| *name == axis.name).unwrap_or_default() {
            i @ 0..3 => lengths.axis(&lengths.displacement(symbols[i])),
            i => lengths.rates(&[symbols[i - 3]]),
        };
        Axis { label: format!("at the start: {}", shown.label), range: Some((axis.from, axis.to)), ..shown }
    }

    fn rest_in_words(&self, _: &Basins<ClassedAttractor>) -> Option<String> {
        None
    }
}
