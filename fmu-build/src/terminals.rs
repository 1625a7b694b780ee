//! `terminalsAndIcons/` (FMI 3.0.2, 2.4.9) of the archives of FMI 3.0: one mechanical terminal for
//! each body, and the pictures of both.

use crate::archive::Content;
use crate::error::Result;
use crate::icon::Icon;
use std::fmt::Write;
use vibro_figures::canvas::palette::{BLOCK, BOX, SECONDARY};
use vibro_figures::canvas::{self, Canvas, Drawing};
use vibro_paper_component::component::variables::{Causality, VARIABLES, Variable};

/// Names of the terminals, which are the bodies' prefixes of variable names, and their positions on
/// the icon's lower edge.
const BODIES: [(&str, &str, i32); 3] = [
    ("box", "The box: its motion out, a force on it in", -70),
    ("block", "The block: its motion out, a force on it in", 0),
    ("secondary", "The secondary oscillator: its motion out, a force on it in", 70),
];

/// Members of a terminal: displacement and force as in a flange of Modelica's translational
/// mechanics (whose kind is not claimed), with velocity and acceleration. The flow variable is the
/// force on the body.
const MEMBERS: [(&str, &str); 4] = [("s", "signal"), ("v", "signal"), ("a", "signal"), ("f", "inflow")];

/// Kind of the terminals; a kind that a tool defines begins with an underscore and the tool's name.
pub const KIND: &str = "_VibroImpact3DOF_TranslationalFlange";

/// The folder's files by their names in it.
///
/// # Errors
/// [`Error::Picture`](crate::Error::Picture).
pub fn files() -> Result<Content> {
    Ok(Content::from([
        ("terminalsAndIcons.xml".to_owned(), xml().into_bytes()),
        ("icon.png".to_owned(), canvas::png(&Icon)?),
        ("icon.svg".to_owned(), canvas::svg(&Icon)?.into_bytes()),
        ("flange.png".to_owned(), canvas::png(&Flange)?),
        ("flange.svg".to_owned(), canvas::svg(&Flange)?.into_bytes()),
    ]))
}

/// `terminalsAndIcons.xml`. The matching rule is `bus`, since the connected terminal may have only
/// displacement and force.
pub fn xml() -> String {
    let mut text = String::from(concat!(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n",
        "<fmiTerminalsAndIcons fmiVersion=\"3.0\">\n",
        "  <GraphicalRepresentation>\n",
        "    <CoordinateSystem x1=\"-100\" y1=\"-100\" x2=\"100\" y2=\"100\" suggestedScalingFactorTo_mm=\"0.1\"/>\n",
        "    <Icon x1=\"-100\" y1=\"-100\" x2=\"100\" y2=\"100\"/>\n",
        "  </GraphicalRepresentation>\n",
        "  <Terminals>\n",
    ));
    for ((body, description, x), colour) in BODIES.into_iter().zip([BOX, BLOCK, SECONDARY]) {
        // Writing to a String cannot fail.
        let _ = writeln!(
            text,
            "    <Terminal name=\"{body}\" matchingRule=\"bus\" terminalKind=\"{KIND}\" description=\"{description}\">"
        );
        for (member, kind) in MEMBERS {
            let _ = writeln!(
                text,
                "      <TerminalMemberVariable variableName=\"{body}.{member}\" memberName=\"{member}\" variableKind=\"{kind}\"/>"
            );
        }
        let canvas::Colour(red, green, blue) = colour;
        let _ = writeln!(
            text,
            "      <TerminalGraphicalRepresentation defaultConnectionColor=\"{red} {green} {blue}\" x1=\"{}\" y1=\"-110\" x2=\"{}\" y2=\"-90\" \
             iconBaseName=\"flange\"/>\n    </Terminal>",
            x - 10,
            x + 10
        );
    }
    text + "  </Terminals>\n</fmiTerminalsAndIcons>\n"
}

/// The variables of the terminals' members.
pub fn members() -> Vec<&'static Variable> {
    let names = BODIES.iter().flat_map(|(body, ..)| MEMBERS.map(|(member, _)| format!("{body}.{member}")));
    let found = names.filter_map(|name| VARIABLES.iter().find(|v| v.name == name));
    found.filter(|v| matches!(v.causality, Causality::Input | Causality::Output)).collect()
}

/// Picture of a terminal: a flange.
struct Flange;

impl Drawing for Flange {
    fn size(&self) -> (u32, u32) {
        (192, 192)
    }

    fn draw(&self, canvas: &mut Canvas) {
        canvas.rectangles(&[[(16.0, 16.0), (176.0, 176.0)]], SECONDARY);
    }
}
