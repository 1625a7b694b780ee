//! Planes of a described machine.

use super::{ClassifiedMotion, ShownPlane, number, word};
use crate::studies::design_sweep::{limits, map};
use std::borrow::Cow;
use vibro_figures::canvas::palette::{HERE, WHITE};
use vibro_figures::chart::{Layer, MARK, Mark, Panel};
use vibro_studies::design_sweep::SampledAxis;
use vibro_studies::isoperiodic::{Isoperiodic, IsoperiodicRequest};
use vibro_studies::{Machine, ParameterAxis, PlanePoint};

impl ShownPlane for Machine {
    const ONE_PERIOD: &str = "1T";
    const CONTACTS: &str = "Impacts and first touches a period";
    const COLUMNS: &[&str] = &["class", "contacts", "rests", "interval", "exponent", "error"];

    fn motion(point: &Option<PlanePoint>) -> Option<ClassifiedMotion> {
        let PlanePoint { class, contacts, rests, .. } = (*point)?;
        Some(ClassifiedMotion { class, contacts, rests, is_two_impact: false })
    }

    fn cells(point: &Option<PlanePoint>) -> Vec<Cow<'static, str>> {
        const EMPTY: Cow<str> = Cow::Borrowed("");
        let Some(p) = point else { return vec!["refused".into(), EMPTY, EMPTY, EMPTY, EMPTY, EMPTY] };
        let [exponent, error] = p.exponent.map_or([EMPTY; 2], |e| e.map(number));
        vec![p.class.name().into(), number(p.contacts), word(p.rests), number(p.interval), exponent, error]
    }

    fn exponents_in_words(periods: u32) -> String {
        format!(" Exponents over {periods} periods.")
    }

    /// Mark at the file's own values, if these are in the plane.
    fn over(&self, request: &IsoperiodicRequest<Self>, _: &Isoperiodic<Option<PlanePoint>>) -> Vec<Layer> {
        let own = |axis: &ParameterAxis<String>| {
            let value = self.description.parameter(&axis.name).ok()?.value;
            (axis.edges().0..=axis.edges().1).contains(&value).then_some(value)
        };
        let (Some(x), Some(y)) = (own(&request.x), own(&request.y)) else { return Vec::new() };
        let mark = |name, colour| Layer::marks(name, colour, Mark::Disc, vec![(x, y)]);
        vec![mark("", WHITE).stroke(MARK + 5), mark("the machine as it is", HERE)]
    }

    /// Panel of the exponents, if the exponents of all motions were requested.
    fn more(
        &self,
        request: &IsoperiodicRequest<Self>,
        plane: &Isoperiodic<Option<PlanePoint>>,
    ) -> Vec<Panel> {
        if request.exponents.is_none() {
            return Vec::new();
        }
        let (x, y) = (&request.x, &request.y);
        let exponent = |i: usize, j: usize| plane.points[j * x.count + i]?.exponent.map(|e| e[0]);
        // Points are numbered like the designs of a sweep: the second axis changes fastest.
        let places = (0..x.count).flat_map(|i| (0..y.count).map(move |j| (i, j)));
        let values: Vec<Option<f64>> =
            places.map(|(i, j)| exponent(i, j).filter(|value| value.is_finite())).collect();
        let sampled = |axis: &ParameterAxis<String>| SampledAxis {
            name: axis.name.clone(),
            values: (0..axis.count).map(|i| axis.value(i)).collect(),
        };
        let title = "(c) Largest Lyapunov exponent".into();
        vec![map(self, title, " 1/s", [&sampled(x), &sampled(y)], &values, &limits(&values))]
    }

    fn remarks(plane: &Isoperiodic<Option<PlanePoint>>) -> Vec<String> {
        let resting = plane.points.iter().flatten().filter(|p| p.rests).count();
        match resting {
            0 => Vec::new(),
            _ => vec![format!("in {resting} motions a stop stays closed or a friction sticks for a while")],
        }
    }
}
