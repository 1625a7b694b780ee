//! Writing of a description as the text of a file, in SI with all digits.

use crate::description::{
    Arms, Body, BodyKind, DampingLimit, Description, Dimension, ForcePoint, Friction, Level, SeriesLaw,
    Signal, Spring, Stop, StopLaw,
};
use crate::elements::Element;
use crate::kinds;
use crate::slots::{of_harmonic, of_sweep};
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
    let own = Writing { machine };
    line!(text, "name = {:?}", machine.name);
    line!(text, "gravity = {}", own.number("gravity", machine.gravity));
    if machine.starts_at_rest {
        line!(text, "start = \"rest\"");
    }
    parameters(&mut text, machine);
    for body in &machine.bodies {
        line!(text, "\n[body.{}]", body.name);
        own.body(&mut text, body);
    }
    for element in machine.elements() {
        let of = element.dotted();
        line!(text, "\n[{of}]");
        if let Some(arms) = element.arms() {
            own.arms(&mut text, &of, arms);
        }
        match element {
            Element::Spring(spring) => own.spring(&mut text, &of, spring),
            Element::Damper(damper) => own.line(&mut text, &of, "damping", damper.damping),
            Element::Stop(stop) => own.stop(&mut text, &of, stop),
            Element::Friction(friction) => own.friction(&mut text, &of, friction),
            Element::Freewheel(_) | Element::Link(_) => {}
            Element::Load(load) => {
                line!(text, "on = {:?}", machine.bodies[load.body].name);
                own.parts(&of, &load.force).iter().for_each(|part| line!(text, "{part}"));
            }
        }
    }
    text
}

/// The named parameters, with the units of their values.
fn parameters(text: &mut String, machine: &Description) {
    let all = machine.named.all();
    if !all.is_empty() {
        line!(text, "\n[parameters]");
    }
    for own in all {
        match &own.expression {
            Some(expression) => line!(text, "{} = \"= {}\"", own.name, expression.text),
            None if own.unit == "1" => line!(text, "{} = {:?}", own.name, own.value),
            None => line!(text, "{} = \"{:?} {}\"", own.name, own.value, own.unit),
        }
    }
}

/// The word for a dimension.
fn word(dimension: Dimension) -> &'static str {
    match dimension {
        Dimension::Translation => "translation",
        Dimension::Rotation => "rotation",
    }
}

/// The machine whose numbers are written, each as a number or as its expression.
struct Writing<'a> {
    machine: &'a Description,
}

impl Writing<'_> {
    fn expression(&self, name: &str) -> Option<String> {
        self.machine.named.of_number(name).map(|expression| format!("\"= {}\"", expression.text))
    }

    fn number(&self, name: &str, value: f64) -> String {
        self.expression(name).unwrap_or_else(|| format!("{value:?}"))
    }

    fn line(&self, text: &mut String, of: &str, key: &str, value: f64) {
        line!(text, "{key} = {}", self.number(&format!("{of}.{key}"), value));
    }

    fn body(&self, text: &mut String, body: &Body) {
        let of = format!("body.{}", body.name);
        match &body.kind {
            BodyKind::Free(free) => {
                match body.dimension {
                    Dimension::Translation => {
                        self.line(text, &of, "mass", free.inertia);
                        self.line(text, &of, "gravity", free.gravity);
                    }
                    Dimension::Rotation => self.line(text, &of, "inertia", free.inertia),
                }
                let start = |key: &str, value| self.number(&format!("{of}.start.{key}"), value);
                let (s, v) = (start("s", free.s), start("v", free.v));
                let follows = s.starts_with('"') || v.starts_with('"');
                if follows || (free.s, free.v) != (0.0, 0.0) {
                    line!(text, "start = {{ s = {s}, v = {v} }}");
                }
            }
            BodyKind::Prescribed { motion, rate } => {
                line!(text, "dimension = {:?}", word(body.dimension));
                let of = format!("{of}.motion");
                let mut parts = self.parts(&of, motion);
                parts.push(format!("rate = {}", self.number(&format!("{of}.rate"), *rate)));
                line!(text, "motion = {{ {} }}", parts.join(", "));
            }
            BodyKind::Integrated(motion) => {
                line!(text, "dimension = {:?}", word(body.dimension));
                let (of, key) = (format!("{of}.motion"), motion.level.key());
                let signal = self.parts(&format!("{of}.{key}"), &motion.signal).join(", ");
                let number = |key: &str, value| self.number(&format!("{of}.{key}"), value);
                let mut parts =
                    vec![format!("{key} = {{ {signal} }}"), format!("s = {}", number("s", motion.s))];
                if motion.level == Level::Acceleration {
                    parts.push(format!("v = {}", number("v", motion.v)));
                }
                line!(text, "motion = {{ {} }}", parts.join(", "));
            }
        }
    }

    fn arms(&self, text: &mut String, element: &str, arms: &Arms) {
        let machine = self.machine;
        let name = |body: usize| machine.bodies[body].name.as_str();
        if arms.levers {
            let arm = |&(body, arm): &(usize, f64)| {
                let of = &machine.bodies[body];
                if let Some(expression) = self.expression(&format!("{element}.arms.{}", of.name)) {
                    return format!("{} = {expression}", of.name);
                }
                match kinds::arm_of(of.dimension, arms.dimension).unit(arms.dimension) {
                    "1" => format!("{} = {arm:?}", of.name),
                    unit => format!("{} = \"{arm:?} {unit}\"", of.name),
                }
            };
            let all: Vec<_> = arms.terms.iter().map(arm).collect();
            return line!(text, "arms = {{ {} }}", all.join(", "));
        }
        let end =
            |sign: f64| arms.terms.iter().find(|term| term.1 == sign).map_or("ground", |term| name(term.0));
        line!(text, "between = [{:?}, {:?}]", end(-1.0), end(1.0));
    }

    fn points(&self, text: &mut String, of: &str, points: &[ForcePoint]) {
        let point = |(i, point): (usize, &ForcePoint)| {
            let of = format!("{of}.points[{i}]");
            let number = |key: &str, value| self.number(&format!("{of}.{key}"), value);
            format!("[{}, {}]", number("e", point.e), number("f", point.f))
        };
        let all: Vec<_> = points.iter().enumerate().map(point).collect();
        line!(text, "points = [{}]", all.join(", "));
    }

    fn spring(&self, text: &mut String, of: &str, spring: &Spring) {
        if !spring.points.is_empty() {
            self.line(text, of, "damping", spring.damping);
            return self.points(text, of, &spring.points);
        }
        self.line(text, of, "stiffness", spring.stiffness);
        self.line(text, of, "damping", spring.damping);
        let Some(series) = &spring.series else { return self.line(text, of, "preload", spring.preload) };
        match series.law {
            SeriesLaw::Dashpot { damping } => self.line(text, of, "series_damping", damping),
            SeriesLaw::Slider { slip } => self.line(text, of, "slip", slip),
        }
        if !self.machine.starts_at_rest {
            self.line(text, of, "slider", series.slider);
        }
    }

    fn stop(&self, text: &mut String, of: &str, stop: &Stop) {
        self.line(text, of, "gap", stop.gap);
        match stop.law {
            StopLaw::Rigid { restitution } => self.line(text, of, "restitution", restitution),
            StopLaw::Compliant { stiffness, damping, limit } => {
                self.line(text, of, "stiffness", stiffness);
                self.line(text, of, "damping", damping);
                let law = match limit {
                    DampingLimit::NoPull => "no-pull",
                    DampingLimit::Elastogap => "elastogap",
                    DampingLimit::Pull => "pull",
                    DampingLimit::UndampedRebound => "undamped-rebound",
                };
                line!(text, "law = {law:?}");
            }
        }
    }

    fn friction(&self, text: &mut String, of: &str, friction: &Friction) {
        if let Some(follows) = &friction.follows {
            line!(text, "follows = {:?}", self.machine.stops[follows.stop].name);
            self.line(text, of, "coefficient", follows.coefficient);
            if let Some(coefficient) = follows.static_coefficient {
                self.line(text, of, "static_coefficient", coefficient);
            }
            return;
        }
        line!(text, "force = {}", self.level(&format!("{of}.force"), &friction.force));
        if let Some(level) = &friction.static_force {
            line!(text, "static = {}", self.level(&format!("{of}.static"), level));
        }
    }

    /// A level of friction as a number or as an inline table.
    fn level(&self, of: &str, signal: &Signal) -> String {
        if signal.is_constant() {
            return self.number(of, signal.constant);
        }
        format!("{{ {} }}", self.parts(of, signal).join(", "))
    }

    /// The keys of a signal with their values.
    fn parts(&self, of: &str, signal: &Signal) -> Vec<String> {
        let number = |of: &str, key: &str, value: f64| self.number(&format!("{of}.{key}"), value);
        let mut parts = vec![format!("constant = {}", number(of, "constant", signal.constant))];
        let count = signal.harmonics.len();
        let harmonics = signal.harmonics.iter().enumerate().map(|(i, h)| {
            let of = of_harmonic(of, i, count);
            format!(
                "{{ amplitude = {}, frequency = {}, phase = {} }}",
                number(&of, "amplitude", h.amplitude),
                number(&of, "frequency", h.frequency),
                number(&of, "phase", h.phase)
            )
        });
        if !signal.harmonics.is_empty() {
            parts.push(format!("harmonics = [{}]", harmonics.collect::<Vec<_>>().join(", ")));
        }
        let count = signal.sweeps.len();
        let sweeps = signal.sweeps.iter().enumerate().map(|(i, sweep)| {
            let of = of_sweep(of, i, count);
            let numbers = [
                ("amplitude", sweep.amplitude),
                ("from", sweep.from),
                ("to", sweep.to),
                ("duration", sweep.duration),
                ("phase", sweep.phase),
            ];
            let numbers = numbers.map(|(key, value)| format!("{key} = {}", number(&of, key, value)));
            format!("{{ {}, law = {:?} }}", numbers.join(", "), sweep.law.word())
        });
        if !signal.sweeps.is_empty() {
            parts.push(format!("sweep = [{}]", sweeps.collect::<Vec<_>>().join(", ")));
        }
        let steps = signal.steps.iter().enumerate().map(|(i, step)| {
            let of = format!("{of}.steps[{i}]");
            format!("[{}, {}]", number(&of, "time", step.time), number(&of, "height", step.height))
        });
        if !signal.steps.is_empty() {
            parts.push(format!("steps = [{}]", steps.collect::<Vec<_>>().join(", ")));
        }
        if let Some(record) = &signal.table {
            let knots = record.knots.iter().map(|(time, value)| format!("[{time:?}, {value:?}]"));
            parts.push(format!("table = [{}]", knots.collect::<Vec<_>>().join(", ")));
            parts.push(format!("interpolation = {:?}", record.interpolation.word()));
            if let Some(scale) = record.scale {
                parts.push(format!("scale = {}", number(&format!("{of}.table"), "scale", scale)));
            }
        }
        if let Some(repeat) = signal.repeat {
            parts.push(format!("repeat = {}", number(of, "repeat", repeat)));
        }
        if signal.input {
            parts.push("input = true".into());
        }
        parts
    }
}
