//! `terminalsAndIcons.xml` (FMI 3.0.2, 2.4.9) of a described machine: a mechanical terminal for
//! each body, with its motion out and, where a load of it takes an input, the force in.

use std::fmt::Write;
use vibro_assembly::description::Dimension;
use vibro_assembly_fmi::Plan;

/// Kinds of the terminals, of translation and of rotation; kinds of tools begin with an underscore
/// and the tool's name.
const KINDS: [&str; 2] = ["_VibroImpact_TranslationalFlange", "_VibroImpact_RotationalFlange"];

/// The text of the file. The rule is `bus`, since a partner may have displacement and force alone.
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
        let of_body = |load: &&vibro_assembly::description::Load| load.body == i && load.force.input;
        for (k, load) in machine.loads.iter().filter(of_body).enumerate() {
            let what = if k == 0 { "f".to_owned() } else { format!("f{}", k + 1) };
            member(&format!("load.{}.input", load.name), &what, "inflow");
        }
        text += "    </Terminal>\n";
    }
    text + "  </Terminals>\n</fmiTerminalsAndIcons>\n"
}
