//! Sections of `CHANGELOG.md`, which has the form of Keep a Changelog: `## [Unreleased]`,
//! `## [0.1.0] - 2026-01-31`.

/// One section.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ChangelogSection {
    /// Name in the brackets: a version or "Unreleased".
    pub name: String,
    /// Day of the release, as 2026-01-31.
    pub date: Option<String>,
    /// The text under the heading, without empty lines before and after it.
    pub text: String,
}

const UNRELEASED: &str = "Unreleased";

/// The section of a version. For a preview, "Unreleased" if the version has no section.
///
/// # Errors
/// A sentence if the section is missing, if it has no day or no text, if it is below the section
/// of another version, or if there are changes that are not assigned to the version.
pub fn of(changelog: &str, version: &str, preview: bool) -> Result<ChangelogSection, String> {
    let sections = sections(changelog);
    let find = |name: &str| sections.iter().find(|s| s.name == name).filter(|s| !s.text.is_empty());
    let waiting = find(UNRELEASED);
    let Some(own) = sections.iter().position(|s| s.name == version) else {
        return waiting.filter(|_| preview).cloned().ok_or_else(|| {
            format!(
                "CHANGELOG.md: no section `## [{version}] - YYYY-MM-DD`: give the changes under [{UNRELEASED}] this heading, or ask \
                 for `--preview`, whose notes say that nothing is released"
            )
        });
    };
    let section = &sections[own];
    if let Some(newer) = sections[..own].iter().find(|s| s.name != UNRELEASED) {
        return Err(format!("CHANGELOG.md: [{version}] is below [{}], a later version", newer.name));
    }
    if !section.date.as_deref().is_some_and(is_day) {
        return Err(format!("CHANGELOG.md: [{version}] has no day: expected `## [{version}] - YYYY-MM-DD`"));
    }
    if section.text.is_empty() {
        return Err(format!("CHANGELOG.md: [{version}] has no text"));
    }
    match waiting {
        Some(_) if !preview => Err(format!(
            "CHANGELOG.md: [{UNRELEASED}] has changes, which are in the sources: move them under [{version}], or raise the version"
        )),
        _ => Ok(section.clone()),
    }
}

/// All sections, in order.
fn sections(changelog: &str) -> Vec<ChangelogSection> {
    let mut found: Vec<ChangelogSection> = Vec::new();
    for line in changelog.lines() {
        if let Some(heading) = line.strip_prefix("## ") {
            let (name, date) = match heading.split_once(" - ") {
                Some((name, date)) => (name, Some(date.trim().to_owned())),
                None => (heading, None),
            };
            let name = name.trim().trim_matches(['[', ']']).to_owned();
            found.push(ChangelogSection { name, date, text: String::new() });
        } else if let Some(section) = found.last_mut() {
            section.text += line;
            section.text.push('\n');
        }
    }
    for section in &mut found {
        section.text = section.text.trim().to_owned();
    }
    found
}

/// Whether a text has the form of a day: 2026-01-31.
fn is_day(text: &str) -> bool {
    let parts: Vec<&str> = text.split('-').collect();
    let number = |part: &str, digits: usize, most: u32| {
        part.len() == digits && part.parse().is_ok_and(|n: u32| (1..=most).contains(&n))
    };
    matches!(parts[..], [year, month, day] if number(year, 4, 9999) && number(month, 2, 12) && number(day, 2, 31))
}
