//! Writes a description as the text of a file, in SI with all digits.

use crate::description::{
    Arms, Block, Body, BodyKind, Closing, Contact, Description, Dimension, Feed, ForcePoint, Free, Friction,
    Given, Level, MatrixDamping, Modal, OddPower, SeriesLaw, Signal, Spring, Stop, StopLaw, Stribeck,
    StribeckExponent, Tangent,
};
use crate::elements::Element;
use crate::formula::Formula;
use crate::kinds;
use crate::slots::{TANGENTS, of_harmonic, of_sweep};
use nalgebra::{DMatrix, DVector, RowDVector};
use std::fmt::Write;
use std::ops::Range;

/// Appends a line to a string, which cannot fail.
macro_rules! line {
    ($text:expr, $($part:tt)*) => {{
        let _ = writeln!($text, $($part)*);
    }};
}

/// Writes the whole file.
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
        if body.is_inner() || matches!(body.kind, BodyKind::Node(_)) {
            continue;
        }
        line!(text, "\n[body.{}]", body.name);
        own.body(&mut text, body);
    }
    for element in machine.elements() {
        let of = element.dotted();
        line!(text, "\n[{of}]");
        let is_contact = matches!(element, Element::Contact(_));
        if let Some(arms) = element.arms().filter(|_| !is_contact) {
            own.arms(&mut text, &of, arms);
        }
        match element {
            Element::Spring(spring) => own.spring(&mut text, &of, spring),
            Element::Damper(damper) => {
                own.line(&mut text, &of, "damping", damper.damping);
                for (key, value) in [("quadratic", damper.quadratic), ("cubic", damper.cubic)] {
                    if let Some(value) = value {
                        own.line(&mut text, &of, key, value);
                    }
                }
                own.power(&mut text, &of, damper.power);
                formula(&mut text, damper.force.as_ref());
            }
            Element::Modal(modal) => own.modal(&mut text, &of, modal),
            Element::Matrix(matrix) => given(&mut text, &matrix.given, machine.starts_at_rest),
            Element::Stop(stop) => own.stop(&mut text, &of, stop),
            Element::Friction(friction) => own.friction(&mut text, &of, friction),
            Element::Contact(contact) => own.contact(&mut text, &of, contact),
            Element::Freewheel(_) | Element::Link(_) => {}
            Element::Load(load) => {
                line!(text, "on = {:?}", machine.bodies[load.body].name);
                let is_own = |feed: &&Feed| machine.loads[feed.load].name == load.name;
                match machine.feeds.iter().find(is_own) {
                    Some(from) => {
                        line!(text, "from = {:?}", machine.name_of_output((from.block, from.output)));
                        own.line(&mut text, &of, "factor", from.factor);
                    }
                    None => own.parts(&of, &load.force).iter().for_each(|part| line!(text, "{part}")),
                }
            }
            Element::Source(source) => {
                own.parts(&of, &source.signal).iter().for_each(|part| line!(text, "{part}"));
            }
            Element::Block(block) => own.block(&mut text, &of, block),
        }
    }
    text
}

/// Writes the named parameters, with the units of their values.
fn parameters(text: &mut String, machine: &Description) {
    let all = machine.named.all();
    if !all.is_empty() {
        line!(text, "\n[parameters]");
    }
    for own in all {
        let comment = &own.comment;
        let comment = if comment.is_empty() { String::new() } else { format!(" # {comment}") };
        match &own.expression {
            Some(expression) => line!(text, "{} = \"= {}\"{comment}", own.name, expression.text),
            None if own.unit == "1" => line!(text, "{} = {:?}{comment}", own.name, own.value),
            None => line!(text, "{} = \"{:?} {}\"{comment}", own.name, own.value, own.unit),
        }
    }
}

/// Writes the formula of a force.
fn formula(text: &mut String, formula: Option<&Formula>) {
    if let Some(own) = formula {
        line!(text, "force = \"= {}\"", own.text());
    }
}

/// Returns the word for a dimension.
fn word(dimension: Dimension) -> &'static str {
    match dimension {
        Dimension::Translation => "translation",
        Dimension::Rotation => "rotation",
    }
}

/// Returns a matrix as a list of rows.
fn square(a: &DMatrix<f64>) -> String {
    let row = |row: RowDVector<f64>| format!("{:?}", row.as_slice());
    let rows: Vec<String> = a.row_iter().map(|own| row(own.into_owned())).collect();
    format!("[{}]", rows.join(", "))
}

/// Writes the keys of a body with matrices.
fn given(text: &mut String, given: &Given, at_rest: bool) {
    let list = |all: Vec<f64>| format!("{all:?}");
    line!(text, "mass = {}", square(&given.mass));
    line!(text, "stiffness = {}", square(&given.stiffness));
    match &given.damping {
        MatrixDamping::None => {}
        MatrixDamping::Matrix(damping) => line!(text, "damping = {}", square(damping)),
        MatrixDamping::Rayleigh(factors) => line!(text, "rayleigh = {factors:?}"),
        MatrixDamping::Ratios(ratios) => match ratios[..] {
            [one] => line!(text, "damping_ratio = {one:?}"),
            _ => line!(text, "damping_ratio = {ratios:?}"),
        },
    }
    if let Some(gyroscopic) = &given.gyroscopic {
        line!(text, "gyroscopic = {}", square(gyroscopic));
    }
    let vector = |own: &DVector<f64>| list(own.iter().copied().collect());
    line!(text, "gravity = {}", vector(&given.gravity));
    if !at_rest {
        line!(text, "start = {{ q = {}, v = {} }}", vector(&given.q), vector(&given.v));
    }
    for node in &given.nodes {
        let (row, dimension) = (vector(&node.row), word(node.dimension));
        line!(text, "nodes.{} = {{ row = {row}, dimension = {dimension:?} }}", node.name);
    }
}

/// Returns a body's name as a key; a node's name has a dot, so it is quoted.
fn key(body: &Body) -> String {
    if body.name.contains('.') { format!("{:?}", body.name) } else { body.name.clone() }
}

/// The machine to write; each number becomes a number or its expression.
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
            BodyKind::Node(_) => {}
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

    fn block(&self, text: &mut String, of: &str, block: &Block) {
        let (inputs, _) = self.machine.inputs_of(block);
        line!(text, "inputs = {inputs:?}");
        line!(text, "states = {}", block.start.len());
        let list = |name: &str, all: &[f64]| {
            let numbers = all.iter().enumerate().map(|(i, x)| self.number(&format!("{of}.{name}{i}]"), *x));
            format!("[{}]", numbers.collect::<Vec<_>>().join(", "))
        };
        line!(text, "start = {}", list("start[", &block.start));
        for (key, rows) in [("a", &block.a), ("b", &block.b), ("c", &block.c), ("d", &block.d)] {
            let rows = rows.iter().enumerate().map(|(i, row)| list(&format!("{key}[{i},"), row));
            line!(text, "{key} = [{}]", rows.collect::<Vec<_>>().join(", "));
        }
        line!(text, "outputs = {:?}", block.outputs);
        for (output, limits) in block.outputs.iter().zip(&block.limits) {
            if let Some(limits) = limits {
                line!(text, "limits.{output} = {}", list(&format!("limits.{output}["), limits));
            }
        }
        let Some(sampling) = &block.sampling else { return };
        self.line(text, of, "sample", sampling.period);
        self.line(text, of, "delay", sampling.delay);
        for (input, quantum) in inputs.iter().zip(&sampling.quanta) {
            if let Some(quantum) = quantum {
                let number = self.number(&format!("{of}.quantum.{input}"), *quantum);
                line!(text, "quantum.{input:?} = {number}");
            }
        }
    }

    fn arms(&self, text: &mut String, element: &str, arms: &Arms) {
        let key = if arms.levers { "arms" } else { "between" };
        line!(text, "{key} = {}", self.ends(element, arms));
    }

    /// Returns the levers of an elongation as an inline table, or its two ends as a list.
    fn ends(&self, element: &str, arms: &Arms) -> String {
        let machine = self.machine;
        let name = |body: usize| machine.bodies[body].name.as_str();
        if arms.levers {
            let arm = |&(body, arm): &(usize, f64)| {
                let of = &machine.bodies[body];
                if let Some(expression) = self.expression(&format!("{element}.arms.{}", of.name)) {
                    return format!("{} = {expression}", key(of));
                }
                match kinds::arm_of(of.dimension, arms.dimension).unit(arms.dimension) {
                    "1" => format!("{} = {arm:?}", key(of)),
                    unit => format!("{} = \"{arm:?} {unit}\"", key(of)),
                }
            };
            let all: Vec<_> = arms.terms.iter().map(arm).collect();
            return format!("{{ {} }}", all.join(", "));
        }
        let end =
            |sign: f64| arms.terms.iter().find(|term| term.1 == sign).map_or("ground", |term| name(term.0));
        format!("[{:?}, {:?}]", end(-1.0), end(1.0))
    }

    fn contact(&self, text: &mut String, of: &str, contact: &Contact) {
        let row = |key: &str, arms: &Arms| {
            let ends = self.ends(&format!("{of}.{key}"), arms);
            if arms.levers { format!("{key} = {{ arms = {ends} }}") } else { format!("{key} = {ends}") }
        };
        line!(text, "{}", row("normal", &contact.normal));
        match contact.closing {
            Closing::Gap(gap) => self.line(text, of, "gap", gap),
            Closing::Preload(preload) => self.line(text, of, "preload", preload),
        }
        let Contact { stiffness, damping, .. } = *contact;
        let is_rigid = stiffness.is_infinite();
        if !is_rigid {
            self.line(text, of, "stiffness", stiffness);
        }
        if contact.tangents.is_empty() {
            if !is_rigid {
                self.line(text, of, "damping", damping);
            }
            return;
        }
        for (key, tangent) in TANGENTS.into_iter().zip(&contact.tangents) {
            line!(text, "{}", row(key, &tangent.arms));
        }
        let is_box = contact.tangents.len() > 1;
        if is_box {
            line!(text, "cone = \"box\"");
        }
        let each = |key: &str, number: fn(&Tangent) -> f64| {
            let own = contact.tangents.iter().enumerate();
            let own =
                own.map(|(k, own)| self.number(&format!("{of}.{key}{}", contact.index_of(k)), number(own)));
            let own = own.collect::<Vec<_>>().join(", ");
            if is_box { format!("{key} = [{own}]") } else { format!("{key} = {own}") }
        };
        line!(text, "{}", each("tangential_stiffness", |own| own.stiffness));
        self.line(text, of, "friction", contact.friction);
        if !self.machine.starts_at_rest {
            line!(text, "{}", each("slider", |own| own.slider));
        }
    }

    fn modal(&self, text: &mut String, of: &str, modal: &Modal) {
        let numbers = |key: &str, all: Vec<f64>| {
            let number = |(i, x): (usize, f64)| self.number(&format!("{of}.{key}[{i}]"), x);
            format!("[{}]", all.into_iter().enumerate().map(number).collect::<Vec<_>>().join(", "))
        };
        line!(text, "frequencies = {}", numbers("frequencies", modal.frequencies.clone()));
        match modal.damping_ratios[..] {
            [one] => self.line(text, of, "damping_ratio", one),
            _ => line!(text, "damping_ratio = {}", numbers("damping_ratio", modal.damping_ratios.clone())),
        }
        let coordinates = modal.first..modal.first + modal.frequencies.len();
        let of_free = |of: &dyn Fn(&Free) -> f64| -> Vec<f64> {
            let free = self.machine.bodies[coordinates.clone()].iter();
            free.filter_map(|body| if let BodyKind::Free(free) = &body.kind { Some(of(free)) } else { None })
                .collect()
        };
        if modal.has_masses {
            line!(text, "masses = {}", numbers("masses", of_free(&|free| free.inertia)));
        }
        line!(text, "gravity = {}", numbers("gravity", of_free(&|free| free.gravity)));
        if !self.machine.starts_at_rest {
            let (q, v) = (of_free(&|free| free.s), of_free(&|free| free.v));
            line!(text, "start = {{ q = {}, v = {} }}", numbers("start.q", q), numbers("start.v", v));
        }
        self.nodes(text, coordinates);
        if let Some(own) = &modal.residual {
            let name = |node: &usize| self.machine.bodies[*node].name.split_once('.').map(|name| name.1);
            let nodes: Vec<_> = own.nodes.iter().filter_map(name).collect();
            line!(text, "residual = {{ nodes = {nodes:?}, flexibility = {} }}", square(&own.flexibility));
        }
    }

    /// Writes the nodes on a body with many coordinates.
    fn nodes(&self, text: &mut String, coordinates: Range<usize>) {
        for body in &self.machine.bodies {
            let BodyKind::Node(row) = &body.kind else { continue };
            let Some((_, name)) = body.name.split_once('.').filter(|_| coordinates.contains(&row[0].0))
            else {
                continue;
            };
            let terms = row.iter().map(|(k, factor)| format!("\"{}\" = {factor:?}", k - coordinates.start));
            let row = terms.collect::<Vec<_>>().join(", ");
            line!(text, "nodes.{name} = {{ row = {{ {row} }}, dimension = {:?} }}", word(body.dimension));
        }
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
        self.stiffness(text, of, spring.stiffness, spring.stepped.as_ref());
        for ((key, _), coefficient) in kinds::CURVE.iter().zip(spring.curve) {
            if let Some(value) = coefficient {
                self.line(text, of, key, value);
            }
        }
        self.power(text, of, spring.power);
        formula(text, spring.force.as_ref());
        self.line(text, of, "damping", spring.damping);
        if let Some(across) = &spring.across {
            self.line(text, of, "offset", across.offset);
            return self.line(text, of, "free_length", across.free_length);
        }
        let Some(series) = &spring.series else { return self.line(text, of, "preload", spring.preload) };
        match series.law {
            SeriesLaw::Dashpot { damping } => self.line(text, of, "series_damping", damping),
            SeriesLaw::Slider { slip } => self.line(text, of, "slip", slip),
        }
        if !self.machine.starts_at_rest {
            self.line(text, of, "slider", series.slider);
        }
    }

    /// Writes a power with two sides.
    fn power(&self, text: &mut String, of: &str, power: Option<OddPower>) {
        if let Some(OddPower { coefficient, exponent }) = power {
            self.line(text, of, "coefficient", coefficient);
            self.line(text, of, "exponent", exponent);
        }
    }

    /// Writes a stiffness as a number or as an inline table.
    fn stiffness(&self, text: &mut String, of: &str, stiffness: f64, stepped: Option<&Signal>) {
        match stepped {
            None => self.line(text, of, "stiffness", stiffness),
            Some(signal) => {
                let parts = self.parts(&format!("{of}.stiffness"), signal).join(", ");
                line!(text, "stiffness = {{ {parts} }}");
            }
        }
    }

    fn stop(&self, text: &mut String, of: &str, stop: &Stop) {
        self.line(text, of, "gap", stop.gap);
        match stop.law {
            StopLaw::Rigid { restitution } => self.line(text, of, "restitution", restitution),
            StopLaw::Compliant { stiffness, .. } if stiffness.is_infinite() => {}
            StopLaw::Compliant { stiffness, damping, limit } => {
                self.stiffness(text, of, stiffness, stop.stepped.as_ref());
                if let Some(contact) = stop.contact {
                    self.line(text, of, "exponent", contact.exponent);
                }
                match stop.contact.and_then(|contact| contact.dissipation) {
                    Some(dissipation) => self.line(text, of, "dissipation", dissipation),
                    None => self.line(text, of, "damping", damping),
                }
                line!(text, "law = {:?}", limit.word());
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
        if let Some(Stribeck { speed, exponent }) = friction.stribeck {
            self.line(text, of, "stribeck", speed);
            if exponent == StribeckExponent::One {
                line!(text, "stribeck_exponent = 1");
            }
        }
        if let Some(viscous) = friction.viscous {
            self.line(text, of, "viscous", viscous);
        }
    }

    /// Returns a level of friction as a number or as an inline table.
    fn level(&self, of: &str, signal: &Signal) -> String {
        if signal.is_constant() {
            return self.number(of, signal.constant);
        }
        format!("{{ {} }}", self.parts(of, signal).join(", "))
    }

    /// Returns the keys of a signal with their values.
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
