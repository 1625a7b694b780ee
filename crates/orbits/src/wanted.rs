//! Words of orbits as users write them: `impact steel, press buffer`.

use super::word::Word;
use std::collections::BTreeSet;
use vibro_machine::Assembly;
use vibro_studies::{Error, Result};

/// Kinds of events of rigid stops, compliant stops, springs, and friction.
const RIGID: &[&str] = &["impact", "chatter", "close", "open"];
const COMPLIANT: &[&str] = &["press", "free", "cap"];
const SPRING: &[&str] = &["corner"];
const FRICTION: &[&str] = &["stick", "slip", "level"];
/// Kinds that a word always names; a word may omit all events of any other kind.
const NAMED: &[&str] = &["impact", "chatter", "press"];
/// Pairs of kinds: an event of the second kind ends an event of the first.
const PAIRS: &[([&str; 2], &str)] =
    &[(["press", "press"], "free"), (["close", "chatter"], "open"), (["stick", "stick"], "slip")];

/// One event: its reports, each with kind and element.
type WantedLetter = BTreeSet<(String, String)>;

/// A word that an orbit must have, up to a cyclic shift. Events of kinds that it does not mention
/// are ignored, except impacts and first contacts.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct WantedWord {
    text: String,
    letters: Vec<WantedLetter>,
}

impl std::fmt::Display for WantedWord {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&self.text)
    }
}

fn refused(text: &str, problem: String) -> Error {
    Error::Described { problem: format!("word `{text}`: {problem}") }
}

/// The last part of a dotted name.
fn plain(name: &str) -> &str {
    name.rsplit('.').next().unwrap_or(name)
}

/// The elements of a machine that have events of a kind; `None` for a kind that does not exist.
fn elements(kind: &str, assembly: &Assembly) -> Option<Vec<String>> {
    let system = assembly.system();
    let stops = |rigid: bool| {
        let all = system.stops.iter().enumerate();
        all.filter(move |(i, stop)| !system.is_corner(*i) && stop.restitution().is_some() == rigid)
            .map(|(i, _)| assembly.name_of_stop(i))
            .collect()
    };
    match kind {
        _ if RIGID.contains(&kind) => Some(stops(true)),
        _ if COMPLIANT.contains(&kind) => Some(stops(false)),
        _ if SPRING.contains(&kind) => {
            let springs = (0..system.stops.len()).filter(|i| system.is_corner(*i));
            let names: BTreeSet<String> = springs.map(|i| assembly.name_of_stop(i)).collect();
            Some(names.into_iter().collect())
        }
        _ if FRICTION.contains(&kind) => {
            let frictions = (0..system.frictions.len()).map(|i| assembly.name_of_friction(i));
            // Sliders of springs and of contacts have no level that begins to act.
            let sliders = system.branches.iter().enumerate().filter(|own| own.1.level.is_some());
            let sliders = sliders.filter(|_| kind != "level").map(|own| assembly.name_of_branch(own.0));
            Some(frictions.chain(sliders).collect())
        }
        _ => None,
    }
}

impl WantedWord {
    /// Parses a word: events separated by commas, each with kind and element; simultaneous events
    /// are joined by ` + `.
    ///
    /// # Errors
    /// [`Error::Described`] for an unknown kind or element, with the choices, and for a word that
    /// no motion can repeat: what begins must end before it begins again.
    ///
    /// # Examples
    ///
    /// ```
    /// use vibro_machine::{Assembly, file};
    /// use vibro_orbits::WantedWord;
    ///
    /// let text = r#"
    ///     name = "Box"
    ///     body.block = { mass = "350 g" }
    ///     stop.steel = { between = ["ground", "block"], gap = "4 mm", restitution = 0.7 }
    ///     stop.buffer = { between = ["block", "ground"], gap = "6 mm", stiffness = "2 MN/m" }
    /// "#;
    /// let assembly = Assembly::new(file::parse(text, "box.toml", &file::no_records)?)?;
    /// let word = WantedWord::parse("impact steel, press buffer", &assembly)?;
    /// assert_eq!(word.to_string(), "impact steel, press buffer");
    /// assert!(WantedWord::parse("impact buffer", &assembly).is_err()); // a compliant stop
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn parse(text: &str, assembly: &Assembly) -> Result<Self> {
        let mut letters = Vec::new();
        for letter in text.split(',') {
            let mut own = WantedLetter::new();
            for event in letter.split('+') {
                own.insert(event_of(event.trim(), text, assembly)?);
            }
            letters.push(own);
        }
        let wanted = Self { text: text.trim().to_owned(), letters };
        wanted.check_closes()?;
        Ok(wanted)
    }

    /// Refuses a word that cannot close.
    fn check_closes(&self) -> Result<()> {
        for (begins, ends) in PAIRS {
            let kinds = |(kind, _): &&(String, String)| begins.contains(&kind.as_str()) || kind == ends;
            let events: Vec<&(String, String)> = self.letters.iter().flatten().filter(kinds).collect();
            if !events.iter().any(|(kind, _)| kind == ends) {
                continue;
            }
            let names: BTreeSet<&String> = events.iter().map(|(_, element)| element).collect();
            for name in names {
                let own: Vec<&str> =
                    events.iter().filter(|(_, of)| of == name).map(|(kind, _)| kind.as_str()).collect();
                let name = plain(name);
                let again = |k: usize| begins.contains(&own[k]) && begins.contains(&own[(k + 1) % own.len()]);
                if let Some(k) = (0..own.len()).find(|k| again(*k)) {
                    let first = own[k];
                    let problem = format!(
                        "the word cannot repeat: {first} {name} requires {ends} {name} before the \
                         next one; add it, or leave out every `{ends}`"
                    );
                    return Err(refused(&self.text, problem));
                }
                if *ends != "slip" && !own.iter().any(|kind| begins.contains(kind)) {
                    let begin = begins[0];
                    let problem =
                        format!("the word cannot repeat: {ends} {name} requires {begin} {name} before it");
                    return Err(refused(&self.text, problem));
                }
            }
        }
        Ok(())
    }

    /// Whether an orbit has this word, up to a cyclic shift.
    pub(super) fn is(&self, word: &Word, assembly: &Assembly) -> bool {
        let mentioned: BTreeSet<&str> = NAMED
            .iter()
            .copied()
            .chain(self.letters.iter().flatten().map(|(kind, _)| kind.as_str()))
            .collect();
        let read = |text: String| -> WantedLetter {
            let events = text.split(" + ").filter_map(|event| event.split_once(' '));
            let own: Vec<(String, String)> =
                events.map(|(kind, name)| (kind.to_owned(), name.to_owned())).collect();
            let own = own.into_iter().filter(|(kind, _)| mentioned.contains(kind.as_str()));
            without_first_impact(own.collect())
        };
        let found: Vec<WantedLetter> = word
            .letters
            .iter()
            .map(|letter| read(letter.in_words(assembly)))
            .filter(|l| !l.is_empty())
            .collect();
        let plainly = |letter: &WantedLetter| {
            without_first_impact(
                letter.iter().map(|(kind, name)| (kind.clone(), plain(name).to_owned())).collect(),
            )
        };
        let wanted: Vec<WantedLetter> = self.letters.iter().map(plainly).collect();
        let count = wanted.len();
        found.len() == count
            && (0..count).any(|first| (0..count).all(|k| wanted[k] == found[(first + k) % count]))
    }
}

/// An event without the impact that begins a run of impacts.
fn without_first_impact(letter: WantedLetter) -> WantedLetter {
    let runs: Vec<String> =
        letter.iter().filter(|(kind, _)| kind == "chatter").map(|(_, name)| name.clone()).collect();
    letter.into_iter().filter(|(kind, name)| kind != "impact" || !runs.contains(name)).collect()
}

/// Parses an event; its element becomes a dotted name.
fn event_of(event: &str, word: &str, assembly: &Assembly) -> Result<(String, String)> {
    let kinds = || [RIGID, COMPLIANT, SPRING, FRICTION].concat().join(", ");
    let Some((kind, name)) = event.split_once(' ').map(|(kind, name)| (kind, name.trim())) else {
        let problem = format!(
            "`{event}` is not an event; expected a kind and an element, e.g. `impact steel, press \
             buffer`; kinds: {}",
            kinds()
        );
        return Err(refused(word, problem));
    };
    let Some(all) = elements(kind, assembly) else {
        return Err(refused(word, format!("`{kind}` is not a kind of event; expected one of {}", kinds())));
    };
    match all.iter().find(|own| *own == name || plain(own) == name) {
        Some(found) => Ok((kind.into(), found.clone())),
        None => {
            let names: Vec<&str> = all.iter().map(|own| plain(own)).collect();
            let names = if names.is_empty() { "none in this machine".into() } else { names.join(", ") };
            let problem =
                format!("no element with the event `{kind}` is called `{name}`; such elements: {names}");
            Err(refused(word, problem))
        }
    }
}
