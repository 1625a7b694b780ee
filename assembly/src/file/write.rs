//! Writing of a description as the text of a file, in SI with all digits.

use crate::description::{
    Arms, Body, BodyKind, DampingLimit, Description, Dimension, Friction, Signal, Stop, StopLaw,
};
use crate::elements::Element;
use crate::kinds;
use std::fmt::Write;

/// Appends a line to a string, which cannot fail.
macro_rules! line {
    ($text:expr, $($part:tt)*) => {{
        let _ = writeln!($text, $($part)*);
    }};
}

/// The whole file.
pub(super) fn machine(machine: &Description) -> String {
    let mut text = String::new();
    line!(text, "name = {:?}", machine.name);
    line!(text, "gravity = {:?}", machine.gravity);
    if machine.starts_at_rest {
        line!(text, "start = \"rest\"");
    }
    for body in &machine.bodies {
        line!(text, "\n[body.{}]", body.name);
        self::body(&mut text, body);
    }
    for element in machine.elements() {
        line!(text, "\n[{}]", element.dotted());
        if let Some(arms) = element.arms() {
            self::arms(&mut text, machine, arms);
        }
        match element {
            Element::Spring(spring) => {
                line!(text, "stiffness = {:?}", spring.stiffness);
                line!(text, "damping = {:?}", spring.damping);
                line!(text, "preload = {:?}", spring.preload);
            }
            Element::Damper(damper) => line!(text, "damping = {:?}", damper.damping),
            Element::Stop(stop) => self::stop(&mut text, stop),
            Element::Friction(friction) => self::friction(&mut text, friction),
            Element::Link(_) => {}
            Element::Load(load) => {
                line!(text, "on = {:?}", machine.bodies[load.body].name);
                parts(&load.force).iter().for_each(|part| line!(text, "{part}"));
            }
        }
    }
    text
}

fn body(text: &mut String, body: &Body) {
    match &body.kind {
        BodyKind::Free(free) => {
            match body.dimension {
                Dimension::Translation => {
                    line!(text, "mass = {:?}", free.inertia);
                    line!(text, "gravity = {:?}", free.gravity);
                }
                Dimension::Rotation => line!(text, "inertia = {:?}", free.inertia),
            }
            if (free.s, free.v) != (0.0, 0.0) {
                line!(text, "start = {{ s = {:?}, v = {:?} }}", free.s, free.v);
            }
        }
        BodyKind::Prescribed { motion, rate } => {
            let dimension = match body.dimension {
                Dimension::Translation => "translation",
                Dimension::Rotation => "rotation",
            };
            line!(text, "dimension = {dimension:?}");
            let mut parts = parts(motion);
            parts.push(format!("rate = {rate:?}"));
            line!(text, "motion = {{ {} }}", parts.join(", "));
        }
    }
}

fn arms(text: &mut String, machine: &Description, arms: &Arms) {
    let name = |body: usize| machine.bodies[body].name.as_str();
    if arms.levers {
        let arm = |&(body, arm): &(usize, f64)| {
            let of = &machine.bodies[body];
            match kinds::arm_of(of.dimension, arms.dimension).unit(arms.dimension) {
                "1" => format!("{} = {arm:?}", of.name),
                unit => format!("{} = \"{arm:?} {unit}\"", of.name),
            }
        };
        let all: Vec<_> = arms.terms.iter().map(arm).collect();
        return line!(text, "arms = {{ {} }}", all.join(", "));
    }
    let end = |sign: f64| arms.terms.iter().find(|term| term.1 == sign).map_or("ground", |term| name(term.0));
    line!(text, "between = [{:?}, {:?}]", end(-1.0), end(1.0));
}

fn stop(text: &mut String, stop: &Stop) {
    line!(text, "gap = {:?}", stop.gap);
    match stop.law {
        StopLaw::Rigid { restitution } => line!(text, "restitution = {restitution:?}"),
        StopLaw::Compliant { stiffness, damping, limit } => {
            line!(text, "stiffness = {stiffness:?}");
            line!(text, "damping = {damping:?}");
            let law = match limit {
                DampingLimit::NoPull => "no-pull",
                DampingLimit::Elastogap => "elastogap",
            };
            line!(text, "law = {law:?}");
        }
    }
}

fn friction(text: &mut String, friction: &Friction) {
    line!(text, "force = {}", signal(&friction.force));
    if let Some(level) = &friction.static_force {
        line!(text, "static = {}", signal(level));
    }
}

/// A signal as a number or as an inline table.
fn signal(signal: &Signal) -> String {
    if signal.is_constant() {
        return format!("{:?}", signal.constant);
    }
    format!("{{ {} }}", parts(signal).join(", "))
}

/// The keys of a signal with their values.
fn parts(signal: &Signal) -> Vec<String> {
    let mut parts = vec![format!("constant = {:?}", signal.constant)];
    let harmonics = signal.harmonics.iter().map(|h| {
        format!("{{ amplitude = {:?}, frequency = {:?}, phase = {:?} }}", h.amplitude, h.frequency, h.phase)
    });
    let pairs = |pairs: &mut dyn Iterator<Item = (f64, f64)>| {
        pairs.map(|(time, value)| format!("[{time:?}, {value:?}]")).collect::<Vec<_>>().join(", ")
    };
    if !signal.harmonics.is_empty() {
        parts.push(format!("harmonics = [{}]", harmonics.collect::<Vec<_>>().join(", ")));
    }
    if !signal.steps.is_empty() {
        parts.push(format!("steps = [{}]", pairs(&mut signal.steps.iter().map(|s| (s.time, s.height)))));
    }
    if let Some(record) = &signal.table {
        parts.push(format!("table = [{}]", pairs(&mut record.knots.iter().copied())));
        parts.push(format!("interpolation = {:?}", if record.cubic { "cubic" } else { "straight" }));
    }
    if signal.input {
        parts.push("input = true".into());
    }
    parts
}
