//! `terminalsAndIcons.xml` (FMI 3.0.2, 2.4.9) of a described machine: a mechanical terminal for
//! each body. Its members are the body's motion, the input that drives it, if any, and the inputs
//! of its loads.

use std::fmt::Write;
use vibro_machine::description::{Body, BodyKind, Dimension, Level};
use vibro_machine_component::Plan;

/// Kinds of the terminals, for translation and for rotation. Kinds defined by tools begin with an
/// underscore and the tool's name.
const KINDS: [&str; 2] = ["_VibroImpact_TranslationalFlange", "_VibroImpact_RotationalFlange"];

/// The input of a body's motion, and its level: `s`, `v` or `a`.
fn driving_input(body: &Body) -> Option<(String, &'static str)> {
    let name = &body.name;
    match &body.kind {
        BodyKind::Prescribed { motion, .. } if motion.input => {
            Some((format!("body.{name}.motion.input"), "s"))
        }
        BodyKind::Integrated(own) if own.signal.input => {
            let level = if own.level == Level::Rate { "v" } else { "a" };
            Some((format!("body.{name}.motion.{}.input", own.level.key()), level))
        }
        _ => None,
    }
}

/// The text of the file. The matching rule is `bus`, since a connected terminal may have only
/// displacement and force.
pub fn xml(plan: &Plan) -> String {
    let machine = &plan.assembly.description;
    let mut text = String::from(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<fmiTerminalsAndIcons fmiVersion=\"3.0\">\n  <GraphicalRepresentation>\n    \
         <CoordinateSystem x1=\"-100\" y1=\"-100\" x2=\"100\" y2=\"100\" suggestedScalingFactorTo_mm=\"0.1\"/>\n    \
         <Icon x1=\"-100\" y1=\"-100\" x2=\"100\" y2=\"100\"/>\n  </GraphicalRepresentation>\n  <Terminals>\n",
    );
    for (i, body) in machine.bodies.iter().enumerate().filter(|(_, body)| !body.is_inner()) {
        let kind = KINDS[usize::from(body.dimension == Dimension::Rotation)];
        let name = &body.name;
        // Writing to a String cannot fail.
        let _ = writeln!(
            text,
            "    <Terminal name=\"{name}\" matchingRule=\"bus\" terminalKind=\"{kind}\" description=\"Motion of {name}, and the force on it\">"
        );
        let mut member = |variable: &str, member: &str, kind: &str| {
            let _ = writeln!(
                text,
                "      <TerminalMemberVariable variableName=\"{variable}\" memberName=\"{member}\" variableKind=\"{kind}\"/>"
            );
        };
        for what in ["s", "v", "a"] {
            member(&format!("{name}.{what}"), what, "signal");
        }
        if let Some((input, level)) = driving_input(body) {
            member(&input, &format!("{level}.input"), "signal");
        }
        let of_body = |load: &&vibro_machine::description::Load| load.body == i && load.force.input;
        for (k, load) in machine.loads.iter().filter(of_body).enumerate() {
            let what = if k == 0 { "f".to_owned() } else { format!("f{}", k + 1) };
            member(&format!("load.{}.input", load.name), &what, "inflow");
        }
        text += "    </Terminal>\n";
    }
    text + "  </Terminals>\n</fmiTerminalsAndIcons>\n"
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Bodies driven by inputs at each level, and a body with a load.
    const DRIVEN: &str = "name = \"Driven\"\n[body.a]\nmotion = { input = true }\n[body.b]\nmotion = { rate = { input = true } }\n\
        [body.c]\ndimension = \"rotation\"\nmotion = { acceleration = { input = true } }\n[body.d]\nmass = 1.0\n[load.push]\non = \"d\"\n\
        input = true\n";

    #[test]
    fn golden_each_input_of_a_body_is_a_member_of_its_terminal() {
        let plan = Plan::new(DRIVEN.into(), vibro_machine_component::FILE).unwrap();
        let text = xml(&plan);
        let mut found = Vec::new();
        for terminal in text.split("<Terminal ").skip(1) {
            let value = |from: &str, key: &str| {
                from.split_once(&format!("{key}=\"")).map(|rest| rest.1.split('"').next().unwrap().to_owned())
            };
            let body = value(terminal, "name").unwrap();
            let members = terminal.split("<TerminalMemberVariable").skip(1);
            found.extend(members.filter_map(|member| {
                let variable = value(member, "variableName").filter(|name| name.ends_with(".input"))?;
                Some(format!("{body} {} {variable}", value(member, "memberName").unwrap()))
            }));
        }
        let expected = [
            "a s.input body.a.motion.input",
            "b v.input body.b.motion.rate.input",
            "c a.input body.c.motion.acceleration.input",
            "d f load.push.input",
        ];
        assert_eq!(found, expected);
        assert_eq!(plan.table.inputs.len(), expected.len());
        assert!(
            plan.table.inputs.iter().all(|&input| text.contains(&plan.table.rows[input as usize - 1].name))
        );
    }
}
