//! Loops of force over displacement: springs with a slider, and contacts with friction.

use super::super::MotionRecord;
use crate::wording::{ORDINALS, axis, spoken};
use vibro_figures::chart::{Layer, Panel, Path, STYLES, THIN, style};
use vibro_machine::description::{Arms, Dimension, SeriesLaw};
use vibro_machine::{Element, Quantity, Start, What};
use vibro_studies::common_period;

/// Number of points of a loop.
const POINTS: u32 = 720;

/// Elements side by side, whose forces add.
struct Together<'m> {
    name: String,
    /// Arms of springs with a slider; `None` for a contact.
    arms: Option<&'m Arms>,
    displacement: Quantity,
    /// Normal force of a contact, which has a loop if it stays closed.
    normal: Option<Quantity>,
    forces: Vec<Quantity>,
    dimension: Dimension,
}

/// The elements with loops. Springs with a slider between the same bodies are side by side.
fn together(record: &MotionRecord) -> Vec<Together<'_>> {
    let d = &record.assembly.description;
    let mut all: Vec<Together> = Vec::new();
    for (i, element) in d.elements().enumerate() {
        let slides = element.series().is_some_and(|own| matches!(own.law, SeriesLaw::Slider { .. }));
        let (name, dimension) = (spoken(element.name()), element.dimension(d));
        if let Element::Contact(_) = element {
            all.extend(element.branches().map(|k| Together {
                name: k.map_or(name.clone(), |k| format!("{name}, {} tangent", ORDINALS[k])),
                arms: None,
                displacement: Quantity::of_element(i, What::TangentE(k)),
                normal: Some(Quantity::of_element(i, What::F)),
                forces: vec![Quantity::of_element(i, What::TangentF(k))],
                dimension,
            }));
        }
        let Some(arms) = element.arms().filter(|_| slides) else { continue };
        let force = Quantity::of_element(i, What::F);
        match all.iter_mut().find(|own| own.arms == Some(arms)) {
            Some(own) => {
                own.name += &format!(" + {name}");
                own.forces.push(force);
            }
            None => all.push(Together {
                name,
                arms: Some(arms),
                displacement: Quantity::of_element(i, What::E),
                normal: None,
                forces: vec![force],
                dimension,
            }),
        }
    }
    all
}

/// The loops during one period after the end of a motion with a period. `None` without such
/// elements, for a motion shorter than its period, and for elements of both dimensions.
pub(super) fn panel(record: &MotionRecord) -> Option<Panel> {
    let (all, period) = (together(record), common_period(&record.assembly.description)?);
    let dimension = all.first()?.dimension;
    if record.ended.is_some() || all.len() > STYLES || all.iter().any(|own| own.dimension != dimension) {
        return None;
    }
    let begin = record.motion.time();
    // The loops take no longer than the motion took.
    if period > begin - record.start.time {
        return None;
    }
    let mut motion = Start::of(&record.motion).motion(record.assembly.clone()).ok()?;
    let mut all: Vec<(Together, Path)> = all.into_iter().map(|own| (own, Vec::new())).collect();
    for k in 0..=POINTS {
        motion.advance_to(begin + period * f64::from(k) / f64::from(POINTS)).ok()?;
        all.retain(|(own, _)| own.normal.is_none_or(|normal| motion.value(normal) > 0.0));
        for (own, points) in &mut all {
            let force = own.forces.iter().map(|force| motion.value(*force)).sum();
            points.push((motion.value(own.displacement), force));
        }
    }
    if all.is_empty() {
        return None;
    }
    let size = |of: fn(&(f64, f64)) -> f64| {
        all.iter().flat_map(|own| &own.1).fold(0.0, |most: f64, p| most.max(of(p).abs()))
    };
    let [noun, unit, force, force_unit] = match dimension {
        Dimension::Translation => ["relative displacement", "m", "force", "N"],
        Dimension::Rotation => ["relative angle", "rad", "torque", "N.m"],
    };
    let (x, y) = (axis(noun, unit, size(|p| p.0)), axis(force, force_unit, size(|p| p.1)));
    let title = match &all[..] {
        [(one, _)] => format!("the next period: {}", one.name),
        _ => "the next period".into(),
    };
    let several = all.len() > 1;
    let layers = all.into_iter().enumerate().map(|(k, (own, points))| {
        let (colour, dash) = style(k);
        Layer::line(if several { &own.name } else { "" }, colour, dash, points).stroke(THIN)
    });
    Some(Panel { title, x, y, layers: layers.collect() })
}
