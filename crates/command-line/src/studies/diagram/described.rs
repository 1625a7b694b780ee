//! Diagrams of described machines in tables and pictures.

use super::{ShownDiagram, across};
use crate::Result;
use crate::studies::panels::{reach, shaded};
use crate::table::exact;
use crate::wording;
use vibro_figures::canvas::palette::FAMILY;
use vibro_figures::chart::{Axis, Dash, Layer, Panel, Path, THIN};
use vibro_studies::diagram::{DescribedPoint, DiagramRequest};
use vibro_studies::{Diagram, Machine, QuantityName};

impl ShownDiagram for Machine {
    const SETTLES_EARLY: bool = true;
    const HEADINGS: [&'static [&'static str]; 2] =
        [&["interval", "contacts", "rests"], &["exponent", "error"]];
    const IMPACTS: [&'static str; 2] = ["impacts and first touches", "contacts per period"];

    fn titles(&self, request: &DiagramRequest<Self>) -> [String; 3] {
        let d = &self.description;
        let words = [
            wording::title(&d.name),
            wording::quantity(d, &request.of),
            wording::parameter(&request.axis.name),
        ];
        let [own, of, over] = &words;
        [format!("{own}: {of} over {over}"), request.of.to_string(), request.axis.name.clone()]
    }

    fn exponents_in_words(_: &u32) -> String {
        String::new()
    }

    fn column(of: &QuantityName) -> String {
        of.to_string()
    }

    fn maximum(value: f64) -> String {
        exact(value)
    }

    fn maxima_panel(
        &self,
        request: &DiagramRequest<Self>,
        diagram: &Diagram<DescribedPoint>,
        apart: &[Option<bool>],
    ) -> Result<Panel> {
        let unit = request.of.find(&self.description)?.unit;
        let range = reach(diagram, &|_, value| value, 0.0);
        let of = wording::quantity(&self.description, &request.of);
        let drawn = if request.at_section { "values at the section" } else { "local maxima" };
        let y = wording::axis(&of, unit, range.0.abs().max(range.1.abs()));
        Ok(Panel {
            title: drawn.into(),
            x: across(self, request),
            y: Axis { range: Some(range), ..y },
            layers: shaded((&request.axis, request.keep), diagram, apart, (range, &|_, value| value)),
        })
    }

    fn exponent_titles() -> [&'static str; 2] {
        ["largest Lyapunov exponent, value rising", "λ₁, 1/s"]
    }

    fn exponent_curves(points: &[Option<DescribedPoint>]) -> Vec<Layer> {
        let exponent = |p: &DescribedPoint| Some((p.value, p.settled.exponent?.value));
        let curve: Path = points.iter().flatten().filter_map(exponent).filter(|p| p.1.is_finite()).collect();
        vec![Layer::line("", FAMILY[0], Dash::Solid, curve).stroke(THIN)]
    }

    fn has_impacts(&self) -> bool {
        !self.description.stops.is_empty()
    }

    fn cells(DescribedPoint { settled, .. }: &DescribedPoint) -> [Vec<String>; 2] {
        let period = settled.period.map_or(String::new(), |n| n.to_string());
        let number = |x: Option<f64>| x.map_or(String::new(), exact);
        let exponent = settled.exponent;
        [
            vec![period, exact(settled.interval), exact(settled.contacts), settled.rests.to_string()],
            vec![number(exponent.map(|e| e.value)), number(exponent.map(|e| e.error))],
        ]
    }
}
