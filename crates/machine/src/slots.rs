//! Slots: mutable references to the numbers of a description, with dotted names.

use crate::description::{
    Arms, Block, Body, BodyKind, Closing, Contact, ContactLaw, Description, Dimension, Free, Integrated,
    Level, Modal, OddPower, SeriesLaw, Signal, Spring, StopLaw, Tangent,
};
use crate::formula::Formula;
use crate::kinds::{self, NumberKind};
use crate::named::Named;

/// A number in a description, with name and kind.
pub(crate) struct Slot<'a> {
    pub name: String,
    pub kind: NumberKind,
    pub dimension: Dimension,
    pub value: &'a mut f64,
}

/// Keys of the tangents of a contact.
pub(crate) const TANGENTS: [&str; 2] = ["tangent", "second_tangent"];

/// End of the name of an exponent.
pub(crate) const EXPONENT: &str = ".exponent";

/// Collector of slots; `dimension` is the dimension of the current body or element.
struct Slots<'a> {
    all: Vec<Slot<'a>>,
    dimension: Dimension,
    /// Names of the exponents that follow from named parameters. Other exponents are not parameters.
    exponents: Vec<String>,
}

impl<'a> Slots<'a> {
    fn push(&mut self, name: String, kind: NumberKind, value: &'a mut f64) {
        self.all.push(Slot { name, kind, dimension: self.dimension, value });
    }

    /// Collects a coordinate of a body with many; `has_masses` names the bodies with masses.
    fn coordinate(&mut self, body: &'a mut Body, at_rest: bool, has_masses: &[String]) {
        self.dimension = body.dimension;
        let (BodyKind::Free(free), Some((of, place))) = (&mut body.kind, body.name.split_once(".q")) else {
            return;
        };
        let name = |key: &str| format!("modal.{of}.{key}{place}");
        if has_masses.iter().any(|name| name == of) {
            self.push(name("masses"), kinds::MODAL_MASS, &mut free.inertia);
        }
        self.push(name("gravity"), kinds::SHARE, &mut free.gravity);
        if !at_rest {
            self.push(name("start.q"), kinds::INNER_START, &mut free.s);
            self.push(name("start.v"), kinds::INNER_START, &mut free.v);
        }
    }

    fn modal(&mut self, modal: &'a mut Modal) {
        self.dimension = Dimension::Translation;
        let names: Vec<String> = (0..modal.damping_ratios.len()).map(|i| modal.name_of_ratio(i)).collect();
        for (i, frequency) in modal.frequencies.iter_mut().enumerate() {
            self.push(format!("modal.{}.frequencies[{i}]", modal.name), kinds::NATURAL, frequency);
        }
        for (name, ratio) in names.into_iter().zip(&mut modal.damping_ratios) {
            self.push(name, kinds::RATIO, ratio);
        }
    }

    fn body(&mut self, body: &'a mut Body, at_rest: bool) {
        let of = format!("body.{}", body.name);
        self.dimension = body.dimension;
        match &mut body.kind {
            BodyKind::Free(Free { inertia, gravity, s, v }) => {
                let translation = body.dimension == Dimension::Translation;
                let key = if translation { "mass" } else { "inertia" };
                self.push(format!("{of}.{key}"), kinds::INERTIA, inertia);
                if translation {
                    self.push(format!("{of}.gravity"), kinds::COSINE, gravity);
                }
                if !at_rest {
                    self.push(format!("{of}.start.s"), kinds::START, s);
                    self.push(format!("{of}.start.v"), kinds::START_RATE, v);
                }
            }
            BodyKind::Node(_) => {}
            BodyKind::Prescribed { motion, rate } => {
                self.signal(&format!("{of}.motion"), motion, kinds::POSITION);
                self.push(format!("{of}.motion.rate"), kinds::RATE, rate);
            }
            BodyKind::Integrated(Integrated { level, signal, s, v }) => {
                let (of, is_rate) = (format!("{of}.motion"), *level == Level::Rate);
                let kind = if is_rate { kinds::DRIVEN_RATE } else { kinds::ACCELERATION };
                self.signal(&format!("{of}.{}", level.key()), signal, kind);
                self.push(format!("{of}.s"), kinds::START, s);
                if !is_rate {
                    self.push(format!("{of}.v"), kinds::START_RATE, v);
                }
            }
        }
    }

    /// Collects the levers of an element and sets the dimension for its other slots; returns its
    /// dotted name.
    fn element(
        &mut self,
        section: &str,
        name: &str,
        arms: &'a mut Arms,
        bodies: &[(String, Dimension)],
    ) -> String {
        let of = format!("{section}.{name}");
        self.dimension = arms.dimension;
        let levers = if arms.levers { &mut arms.terms[..] } else { &mut [] };
        for (body, arm) in levers {
            let Some((body, dimension)) = bodies.get(*body) else { continue };
            self.push(format!("{of}.arms.{body}"), kinds::arm_of(*dimension, arms.dimension), arm);
        }
        of
    }

    /// Collects the parameters of a formula, which follow from named parameters.
    fn formula(&mut self, of: &str, formula: &'a mut Option<Formula>) {
        for (name, value) in formula.iter_mut().flat_map(Formula::parameters_mut) {
            self.push(format!("{of}.force.{name}"), kinds::OF_FORMULA, value);
        }
    }

    fn spring(&mut self, spring: &'a mut Spring, bodies: &[(String, Dimension)], at_rest: bool) {
        let is_curved = spring.is_curved();
        let of = self.element("spring", &spring.name, &mut spring.arms, bodies);
        if !spring.points.is_empty() {
            self.push(format!("{of}.damping"), kinds::DAMPING, &mut spring.damping);
            for (i, point) in spring.points.iter_mut().enumerate() {
                self.push(format!("{of}.points[{i}].e"), kinds::POINT, &mut point.e);
                self.push(format!("{of}.points[{i}].f"), kinds::POINT_FORCE, &mut point.f);
            }
            return;
        }
        let stiffness = match spring.series {
            Some(_) => kinds::SERIES_STIFFNESS,
            None if spring.across.is_some() => kinds::ACROSS_STIFFNESS,
            None if is_curved => kinds::CURVED_STIFFNESS,
            None => kinds::STIFFNESS,
        };
        match &mut spring.stepped {
            Some(signal) => self.signal(&format!("{of}.stiffness"), signal, kinds::STEPPED),
            None => self.push(format!("{of}.stiffness"), stiffness, &mut spring.stiffness),
        }
        for ((key, kind), coefficient) in kinds::CURVE.into_iter().zip(&mut spring.curve) {
            if let Some(value) = coefficient {
                self.push(format!("{of}.{key}"), kind, value);
            }
        }
        self.power(&of, false, &mut spring.power);
        self.formula(&of, &mut spring.force);
        self.push(format!("{of}.damping"), kinds::DAMPING, &mut spring.damping);
        if let Some(across) = &mut spring.across {
            self.push(format!("{of}.offset"), kinds::OFFSET, &mut across.offset);
            return self.push(format!("{of}.free_length"), kinds::FREE_LENGTH, &mut across.free_length);
        }
        let Some(series) = &mut spring.series else {
            return self.push(format!("{of}.preload"), kinds::PRELOAD, &mut spring.preload);
        };
        match &mut series.law {
            SeriesLaw::Dashpot { damping } => {
                self.push(format!("{of}.series_damping"), kinds::SERIES_DAMPING, damping);
            }
            SeriesLaw::Slider { slip } => self.push(format!("{of}.slip"), kinds::SLIP, slip),
        }
        if !at_rest {
            self.push(format!("{of}.slider"), kinds::SLIDER, &mut series.slider);
        }
    }

    /// Collects the coefficient of a power with two sides.
    fn power(&mut self, of: &str, of_rate: bool, power: &'a mut Option<OddPower>) {
        if let Some(OddPower { coefficient, exponent }) = power {
            let kind = kinds::coefficient_of_power(*exponent, of_rate);
            self.push(format!("{of}.coefficient"), kind, coefficient);
            self.exponent(of, exponent);
        }
    }

    /// Collects an exponent if it follows from named parameters.
    fn exponent(&mut self, of: &str, exponent: &'a mut f64) {
        let name = format!("{of}{EXPONENT}");
        if self.exponents.contains(&name) {
            self.push(name, kinds::EXPONENT, exponent);
        }
    }

    /// Collects the numbers of a curved contact.
    fn contact(&mut self, of: &str, law: &'a mut StopLaw, contact: &'a mut ContactLaw) {
        let StopLaw::Compliant { stiffness, damping, .. } = law else { return };
        self.push(format!("{of}.stiffness"), kinds::stiffness_of_power(contact.exponent), stiffness);
        self.exponent(of, &mut contact.exponent);
        match &mut contact.dissipation {
            Some(dissipation) => self.push(format!("{of}.dissipation"), kinds::DISSIPATION, dissipation),
            None => self.push(format!("{of}.damping"), kinds::DAMPING, damping),
        }
    }

    /// Collects the numbers of a contact with a normal stiffness.
    fn pressing(&mut self, contact: &'a mut Contact, bodies: &[(String, Dimension)], at_rest: bool) {
        let of = format!("contact.{}", contact.name);
        let indices: Vec<&str> = (0..contact.tangents.len()).map(|k| contact.index_of(k)).collect();
        self.element(&of, "normal", &mut contact.normal, bodies);
        match &mut contact.closing {
            Closing::Gap(gap) => self.push(format!("{of}.gap"), kinds::GAP, gap),
            Closing::Preload(preload) => {
                self.push(format!("{of}.preload"), kinds::CONTACT_PRELOAD, preload);
            }
        }
        if contact.stiffness.is_finite() {
            self.push(format!("{of}.stiffness"), kinds::NORMAL_STIFFNESS, &mut contact.stiffness);
        }
        if contact.tangents.is_empty() {
            return self.push(format!("{of}.damping"), kinds::DAMPING, &mut contact.damping);
        }
        let mut sliders = Vec::new();
        for ((key, index), own) in TANGENTS.into_iter().zip(indices).zip(&mut contact.tangents) {
            let Tangent { arms, stiffness, slider } = own;
            self.element(&of, key, arms, bodies);
            let name = format!("{of}.tangential_stiffness{index}");
            self.push(name, kinds::TANGENTIAL_STIFFNESS, stiffness);
            sliders.push((format!("{of}.slider{index}"), slider));
        }
        self.push(format!("{of}.friction"), kinds::FRICTION_OF_CONTACT, &mut contact.friction);
        for (name, slider) in sliders.into_iter().filter(|_| !at_rest) {
            self.push(name, kinds::SLIDER, slider);
        }
    }

    fn law(&mut self, of: &str, law: &'a mut StopLaw, stepped: &'a mut Option<Signal>) {
        match law {
            StopLaw::Rigid { restitution } => {
                self.push(format!("{of}.restitution"), kinds::RESTITUTION, restitution);
            }
            // A rigid stop on residual flexibility has neither.
            StopLaw::Compliant { stiffness, .. } if stiffness.is_infinite() => {}
            StopLaw::Compliant { stiffness, damping, .. } => {
                match stepped {
                    Some(signal) => self.signal(&format!("{of}.stiffness"), signal, kinds::STEPPED),
                    None => self.push(format!("{of}.stiffness"), kinds::STIFFNESS, stiffness),
                }
                self.push(format!("{of}.damping"), kinds::DAMPING, damping);
            }
        }
    }

    fn signal(&mut self, of: &str, signal: &'a mut Signal, kind: NumberKind) {
        self.push(format!("{of}.constant"), kind, &mut signal.constant);
        let count = signal.harmonics.len();
        for (i, harmonic) in signal.harmonics.iter_mut().enumerate() {
            let of = of_harmonic(of, i, count);
            self.push(format!("{of}.amplitude"), kind, &mut harmonic.amplitude);
            self.push(format!("{of}.frequency"), kinds::FREQUENCY, &mut harmonic.frequency);
            self.push(format!("{of}.phase"), kinds::PHASE, &mut harmonic.phase);
        }
        let count = signal.sweeps.len();
        for (i, sweep) in signal.sweeps.iter_mut().enumerate() {
            let of = of_sweep(of, i, count);
            self.push(format!("{of}.amplitude"), kind, &mut sweep.amplitude);
            self.push(format!("{of}.from"), kinds::SWEPT, &mut sweep.from);
            self.push(format!("{of}.to"), kinds::SWEPT, &mut sweep.to);
            self.push(format!("{of}.duration"), kinds::DURATION, &mut sweep.duration);
            self.push(format!("{of}.phase"), kinds::PHASE, &mut sweep.phase);
        }
        for (i, step) in signal.steps.iter_mut().enumerate() {
            self.push(format!("{of}.steps[{i}].time"), kinds::TIME, &mut step.time);
            self.push(format!("{of}.steps[{i}].height"), kind, &mut step.height);
        }
        if let Some(scale) = signal.table.as_mut().and_then(|record| record.scale.as_mut()) {
            self.push(format!("{of}.table.scale"), kinds::scale_of(kind), scale);
        }
        if let Some(repeat) = &mut signal.repeat {
            self.push(format!("{of}.repeat"), kinds::PERIOD, repeat);
        }
    }

    fn block(&mut self, block: &'a mut Block, units: &[&'static str], inputs: &[String]) {
        self.dimension = Dimension::Translation;
        let of = format!("block.{}", block.name);
        let matrices = [("a", &mut block.a), ("b", &mut block.b), ("c", &mut block.c), ("d", &mut block.d)];
        for (key, rows) in matrices {
            for (i, row) in rows.iter_mut().enumerate() {
                for (j, value) in row.iter_mut().enumerate() {
                    self.push(format!("{of}.{key}[{i},{j}]"), kinds::COEFFICIENT_OF_BLOCK, value);
                }
            }
        }
        for (i, value) in block.start.iter_mut().enumerate() {
            self.push(format!("{of}.start[{i}]"), kinds::BLOCK_START, value);
        }
        for (output, limits) in block.outputs.iter().zip(&mut block.limits) {
            let limits = limits.iter_mut().flatten().enumerate();
            for (i, value) in limits.filter(|(_, limit)| limit.is_finite()) {
                self.push(format!("{of}.limits.{output}[{i}]"), kinds::OUTPUT_LIMIT, value);
            }
        }
        let Some(sampling) = &mut block.sampling else { return };
        self.push(format!("{of}.sample"), kinds::SAMPLE, &mut sampling.period);
        self.push(format!("{of}.delay"), kinds::DELAY, &mut sampling.delay);
        for ((quantum, input), unit) in sampling.quanta.iter_mut().zip(inputs).zip(units) {
            let Some(value) = quantum else { continue };
            self.push(format!("{of}.quantum.{input}"), kinds::quantum(unit), value);
        }
    }

    fn level(&mut self, of: &str, signal: &'a mut Signal) {
        if signal.is_constant() {
            self.push(of.to_owned(), kinds::LEVEL, &mut signal.constant);
        } else {
            self.signal(of, signal, kinds::FORCE);
        }
    }
}

/// Name of harmonic `i` of `count` of a signal; a single harmonic has the signal's name.
pub(crate) fn of_harmonic(of: &str, i: usize, count: usize) -> String {
    if count == 1 { of.to_owned() } else { format!("{of}.harmonics[{i}]") }
}

/// Name of sweep `i` of `count` of a signal.
pub(crate) fn of_sweep(of: &str, i: usize, count: usize) -> String {
    if count == 1 { format!("{of}.sweep") } else { format!("{of}.sweep[{i}]") }
}

/// The slots of all parameters of a machine.
pub(crate) fn slots(machine: &mut Description) -> Vec<Slot<'_>> {
    let bodies: Vec<_> = machine.bodies.iter().map(|b| (b.name.clone(), b.dimension)).collect();
    let inputs: Vec<_> = machine.blocks.iter().map(|block| machine.inputs_of(block)).collect();
    let exponents = machine.named.numbers().filter(|name| name.ends_with(EXPONENT)).map(str::to_owned);
    let mut slots =
        Slots { all: Vec::new(), dimension: Dimension::Translation, exponents: exponents.collect() };
    slots.push("gravity".into(), kinds::GRAVITY, &mut machine.gravity);
    let own = machine.modals.iter().filter(|own| own.has_masses);
    let has_masses: Vec<String> = own.map(|own| own.name.clone()).collect();
    let matrices: Vec<String> = machine.matrices.iter().map(|own| format!("{}.q[", own.name)).collect();
    for body in &mut machine.bodies {
        match body.is_inner() {
            // The numbers of matrices are not parameters.
            true if matrices.iter().any(|of| body.name.starts_with(of)) => {}
            true => slots.coordinate(body, machine.starts_at_rest, &has_masses),
            false => slots.body(body, machine.starts_at_rest),
        }
    }
    for spring in &mut machine.springs {
        slots.spring(spring, &bodies, machine.starts_at_rest);
    }
    for damper in &mut machine.dampers {
        let kind = if damper.is_curved() { kinds::CURVED_DAMPING } else { kinds::DASHPOT };
        let of = slots.element("damper", &damper.name, &mut damper.arms, &bodies);
        slots.push(format!("{of}.damping"), kind, &mut damper.damping);
        if let Some(quadratic) = &mut damper.quadratic {
            slots.push(format!("{of}.quadratic"), kinds::QUADRATIC_DAMPING, quadratic);
        }
        if let Some(cubic) = &mut damper.cubic {
            slots.push(format!("{of}.cubic"), kinds::CUBIC_DAMPING, cubic);
        }
        slots.power(&of, true, &mut damper.power);
        slots.formula(&of, &mut damper.force);
    }
    machine.modals.iter_mut().for_each(|modal| slots.modal(modal));
    for stop in &mut machine.stops {
        let of = slots.element("stop", &stop.name, &mut stop.arms, &bodies);
        slots.push(format!("{of}.gap"), kinds::GAP, &mut stop.gap);
        match &mut stop.contact {
            Some(contact) => slots.contact(&of, &mut stop.law, contact),
            None => slots.law(&of, &mut stop.law, &mut stop.stepped),
        }
    }
    for friction in &mut machine.frictions {
        let of = slots.element("friction", &friction.name, &mut friction.arms, &bodies);
        if let Some(follows) = &mut friction.follows {
            slots.push(format!("{of}.coefficient"), kinds::COEFFICIENT, &mut follows.coefficient);
            if let Some(coefficient) = &mut follows.static_coefficient {
                slots.push(format!("{of}.static_coefficient"), kinds::COEFFICIENT, coefficient);
            }
            continue;
        }
        slots.level(&format!("{of}.force"), &mut friction.force);
        if let Some(level) = &mut friction.static_force {
            slots.level(&format!("{of}.static"), level);
        }
        if let Some(stribeck) = &mut friction.stribeck {
            slots.push(format!("{of}.stribeck"), kinds::STRIBECK, &mut stribeck.speed);
        }
        if let Some(viscous) = &mut friction.viscous {
            slots.push(format!("{of}.viscous"), kinds::VISCOUS, viscous);
        }
    }
    for contact in &mut machine.contacts {
        slots.pressing(contact, &bodies, machine.starts_at_rest);
    }
    for wheel in &mut machine.freewheels {
        slots.element("freewheel", &wheel.name, &mut wheel.arms, &bodies);
    }
    for link in &mut machine.links {
        slots.element("link", &link.name, &mut link.arms, &bodies);
    }
    let mut feeds = machine.feeds.iter_mut().peekable();
    for (i, load) in machine.loads.iter_mut().enumerate() {
        slots.dimension = bodies.get(load.body).map_or(Dimension::Translation, |b| b.1);
        match feeds.next_if(|feed| feed.load == i) {
            Some(feed) => slots.push(format!("load.{}.factor", load.name), kinds::FACTOR, &mut feed.factor),
            None => slots.signal(&format!("load.{}", load.name), &mut load.force, kinds::FORCE),
        }
    }
    slots.dimension = Dimension::Translation;
    for source in &mut machine.sources {
        slots.signal(&format!("signal.{}", source.name), &mut source.signal, kinds::SIGNAL);
    }
    for (block, (names, units)) in machine.blocks.iter_mut().zip(&inputs) {
        slots.block(block, units, names);
    }
    // The value of a parameter with an expression follows from others.
    let own = |named: &&mut Named| named.expression.is_none();
    for Named { name, unit, value, .. } in machine.named.all_mut().iter_mut().filter(own) {
        slots.push(name.clone(), kinds::named(unit), value);
    }
    slots.all
}
