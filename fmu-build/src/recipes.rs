//! The recipes of `docs/paper-machine.md` in the documentation page: the subject of each recipe,
//! and its block for the FMU. The blocks for the command line and for Rust are left out, since a
//! user of the FMU may have neither.

use pulldown_cmark::{Event, HeadingLevel, Parser, Tag, TagEnd, html};

static PAGE: &str = include_str!("../../docs/paper-machine.md");

/// Heading of the section of recipes, the last of the page.
const RECIPES: &str = "\n## Recipes\n";

/// Fourth-level heading of the blocks that are shown.
const SHOWN: &str = "FMU";

/// The recipes as HTML, each with a heading of the third level.
pub fn recipes() -> String {
    // The text before the first recipe is about the command line.
    let section = PAGE.split_once(RECIPES).map_or("", |(_, section)| section);
    let start = section.find("\n### ").map_or(0, |i| i + 1);
    // Paths are relative to the archive, not to the folder of the build.
    let text = section[start..].replace("\"target/", "\"");
    let mut shown: Vec<Event<'_>> = Vec::new();
    let mut hidden = false;
    let mut heading = None;
    for event in Parser::new(&text) {
        match event {
            Event::Start(Tag::Heading { level, .. }) => heading = Some((level, String::new())),
            Event::End(TagEnd::Heading(_)) => {
                let Some((level, words)) = heading.take() else { continue };
                hidden = level == HeadingLevel::H4 && words != SHOWN;
                if level == HeadingLevel::H3 {
                    shown.push(Event::Html(
                        format!("<h3>{}</h3>\n", vibro_figures::html::escape(&words)).into(),
                    ));
                }
            }
            Event::Text(words) | Event::Code(words) if heading.is_some() => {
                heading = heading.take().map(|(level, before)| (level, before + &words));
            }
            // The targets of links are not in the archive.
            Event::Start(Tag::Link { .. }) | Event::End(TagEnd::Link) => {}
            event if !hidden => shown.push(event),
            _ => {}
        }
    }
    let mut page = String::new();
    html::push_html(&mut page, shown.into_iter());
    page
}
