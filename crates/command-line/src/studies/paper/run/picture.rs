//! The picture of a run: histories with impacts marked, the phase portrait between the stops,
//! impact speeds, loads. A long run is drawn by envelopes, and its end is drawn in detail. The
//! caption states quantities that do not change.

use super::envelope::{Extremes, constant, envelope, thinned};
use super::history::{History, RunImpact, RunInstant};
use super::short;
use crate::studies::PANEL;
use crate::studies::paper::lengths::LengthUnit;
use vibro_figures::canvas::palette::{BLACK, BLOCK, BOX, GREY, RELATIVE, SECONDARY};
use vibro_figures::chart::{Axis, Colour, Dash, Figure, Layer, MARK, Mark, Panel, Path, THIN};
use vibro_impact::load::Load;
use vibro_impact::simulator::Contact;
use vibro_studies::paper::ParameterSet;

/// Limit for a run drawn in detail as a whole, in drive periods. Curves of a longer run would fill
/// the panel.
const DRAWN: f64 = 40.0;
/// Number of drive periods drawn in detail, at the end of a longer run.
const DETAIL: f64 = 10.0;
/// Number of drive periods in the phase portrait, at the end of a longer run.
const PORTRAIT: f64 = 60.0;
/// Largest number of instants of a portrait.
const INSTANTS: usize = 12_000;
/// Largest number of marks of a panel. For more impacts only extreme speeds are drawn.
const MARKS: usize = 1500;
/// Largest number of marks of the usual size. More marks are drawn smaller.
const MANY: usize = 200;
/// Half the size of the marks of impacts.
const SMALL: u32 = 8;
/// Opacity of the area of an envelope.
const AREA: f64 = 0.3;

/// The bodies: symbol, name, colour.
const BODIES: [(&str, &str, Colour); 3] =
    [("x₁", "box", BOX), ("x₂", "block", BLOCK), ("x₃", "secondary", SECONDARY)];

/// The picture of a run while it is drawn.
struct RunPicture<'a> {
    history: &'a History,
    set: &'a ParameterSet,
    unit: LengthUnit,
    /// Unit of length for rates.
    rate: LengthUnit,
    gap: f64,
    period: f64,
    /// Indices of the bodies that move.
    moving: Vec<usize>,
    /// Sentences on the quantities that are not drawn because they do not change.
    left_out: Vec<String>,
}

/// A panel and its title without the letter.
type Titled = (String, Panel);

fn titled(title: impl Into<String>, x: Axis, y: Axis, layers: Vec<Layer>) -> Titled {
    (title.into(), Panel { title: String::new(), x, y, layers })
}

/// Layers of an envelope: area and both edges; the name belongs to the edges.
fn enveloped(name: &str, colour: Colour, pieces: Vec<Vec<Extremes>>) -> Vec<Layer> {
    let edge = |pick: fn(&Extremes) -> (f64, f64)| pieces.iter().map(move |p| p.iter().map(pick).collect());
    let edges: Vec<Path> = edge(|p| (p.0, p.2)).chain(edge(|p| (p.0, p.1))).collect();
    let areas = pieces.iter().map(|p| Layer::band("", colour, AREA, p.clone()));
    areas.chain([Layer::lines("", colour, Dash::Solid, edges).stroke(THIN).labelled(name)]).collect()
}

impl<'a> RunPicture<'a> {
    fn new(set: &'a ParameterSet, history: &'a History) -> Self {
        let p = set.parameters();
        let unit = LengthUnit::of(set);
        let fastest = history.instants().map(|i| i.v[3].abs()).fold(0.0, f64::max);
        let (rate, gap) = (unit.of_rates(fastest), p.stop_gap);
        let largest = history.instants().flat_map(|i| i.x).map(f64::abs).fold(0.0, f64::max);
        let still = |i: usize| constant(history.instants().map(|instant| instant.x[i]), largest);
        let moving = (0..3).filter(|i| still(*i).is_none()).collect();
        let mut shown =
            Self { history, set, unit, rate, gap, period: p.period(), moving, left_out: Vec::new() };
        let told: Vec<String> = (0..3).filter_map(|i| Some(shown.told_still(i, still(i)?))).collect();
        shown.left_out.extend(told);
        shown
    }

    /// A length with its unit, to four digits.
    fn length(&self, metres: f64) -> String {
        format!("{} {}", short4(self.unit.per_metre * metres), self.unit.symbol)
    }

    fn speed(&self, speed: f64) -> String {
        format!("{} {}/s", short4(self.rate.per_metre * speed), self.rate.symbol)
    }

    /// A body at rest, in words.
    fn told_still(&self, body: usize, place: f64) -> String {
        let (symbol, name, _) = BODIES[body];
        let why = if body == 2 && self.set.parameters().coupling_stiffness == 0.0 {
            ", to which nothing couples the block"
        } else {
            ""
        };
        format!("{symbol}, the {name}{why}, stays at {}", self.length(place))
    }

    fn end(&self) -> f64 {
        self.history.duration
    }

    /// Whether the run is too long to be drawn as a whole.
    fn is_long(&self) -> bool {
        self.end() > DRAWN * self.period * (1.0 + 1e-9)
    }

    /// Start time of the last `periods` drive periods; 0 for a run drawn as a whole.
    fn last(&self, periods: f64) -> f64 {
        if self.is_long() { self.end() - periods * self.period } else { 0.0 }
    }

    fn instants(&self, from: f64) -> impl Iterator<Item = &RunInstant> {
        self.history.instants().filter(move |i| i.time >= from)
    }

    fn time(&self, from: f64) -> Axis {
        Axis::over("time (s)", from, self.end())
    }

    fn lengths(&self, name: &str) -> String {
        format!("{name} ({})", self.unit.symbol)
    }

    /// The bodies that move, in words.
    fn names(&self) -> String {
        let names: Vec<&str> = self.moving.iter().map(|i| BODIES[*i].1).collect();
        let words = match &names[..] {
            [all @ .., last] if !all.is_empty() => format!("{} and {last}", all.join(", ")),
            names => names.join(""),
        };
        let mut letters = words.chars();
        letters.next().map_or(String::new(), |first| first.to_uppercase().chain(letters).collect())
    }

    /// The displacements of the bodies that move, by envelopes over the whole run.
    fn whole(&self) -> Option<Titled> {
        let size = |i: &usize| self.history.extent(*i).amplitude;
        let mut bodies = self.moving.clone();
        // The largest is drawn first, below the others.
        bodies.sort_by(|a, b| size(b).total_cmp(&size(a)));
        let body = |i: usize| {
            let (symbol, name, colour) = BODIES[i];
            let points = self.instants(0.0).map(move |k| (k.time, self.unit.per_metre * k.x[i]));
            enveloped(&format!("{symbol}, {name}"), colour, envelope(points, self.period, self.end()))
        };
        let layers: Vec<Layer> = bodies.into_iter().flat_map(body).collect();
        let title = format!("{}, the whole run: least and largest", self.names());
        (!layers.is_empty())
            .then(|| titled(title, self.time(0.0), Axis::new(self.lengths("displacement")), layers))
    }

    /// The displacements of the bodies that move, as curves.
    fn displacements(&self, from: f64) -> Option<Titled> {
        let curve = |i: &usize| {
            let (symbol, name, colour) = BODIES[*i];
            let path = self.instants(from).map(|k| (k.time, self.unit.per_metre * k.x[*i])).collect();
            Layer::line("", colour, Dash::Solid, thinned(path))
                .stroke(THIN)
                .labelled(format!("{symbol}, {name}"))
        };
        let layers: Vec<Layer> = self.moving.iter().map(curve).collect();
        let title = self.names() + &self.of_the_last(DETAIL);
        (!layers.is_empty())
            .then(|| titled(title, self.time(from), Axis::new(self.lengths("displacement")), layers))
    }

    /// Addition to a title if only the end of the run is shown.
    fn of_the_last(&self, periods: f64) -> String {
        if self.is_long() { format!(", the last {periods} drive periods") } else { String::new() }
    }

    /// Panels of the block in the box; empty if it does not move there, which the caption then
    /// states.
    fn relative(&mut self) -> Vec<Titled> {
        if let Some(w) = constant(self.instants(0.0).map(|i| i.x[3]), self.gap) {
            let rests = self.instants(0.0).all(|i| i.contact != Contact::Flight);
            let why = if rests { ": the block rests at a stop" } else { "" };
            self.left_out.push(format!("w = x₂ − x₁ stays at {}{why}", self.length(w)));
            return Vec::new();
        }
        vec![self.gap_history(), self.portrait()]
    }

    fn gap_history(&self) -> Titled {
        let (from, stop) = (self.last(DETAIL), self.unit.per_metre * self.gap);
        let line = |y: f64| vec![(from, y), (self.end(), y)];
        let hits = self.history.impacts.iter().filter(|i| i.time >= from);
        let marks: Path = hits.rev().take(MARKS).map(|i| (i.time, f64::from(i.side) * stop)).collect();
        let path = self.instants(from).map(|i| (i.time, self.unit.per_metre * i.x[3])).collect();
        let mut layers = vec![
            Layer::lines("", GREY, Dash::Dashed, vec![line(stop), line(-stop)]).stroke(THIN),
            Layer::line("w", RELATIVE, Dash::Solid, thinned(path)).stroke(THIN),
        ];
        if !marks.is_empty() {
            layers.push(Layer::marks("impact", BLACK, Mark::Disc, marks).stroke(SMALL));
        }
        let title = format!("Block in the box, w = x₂ − x₁{}; dashed: stops", self.of_the_last(DETAIL));
        let y = Axis::over(self.lengths("w"), -1.15 * stop, 1.15 * stop);
        titled(title, self.time(from), y, layers)
    }

    fn portrait(&self) -> Titled {
        let (stop, from) = (self.unit.per_metre * self.gap, self.last(PORTRAIT));
        let mut count = 0;
        let mut pieces: Vec<Path> = Vec::new();
        for piece in self.history.pieces.iter().rev() {
            let shown = piece.iter().filter(|i| i.time >= from);
            let path: Path =
                shown.map(|i| (self.unit.per_metre * i.x[3], self.rate.per_metre * i.v[3])).collect();
            // A motion without events is a single piece.
            let skip = path.len().saturating_sub(INSTANTS);
            count += path.len();
            pieces.push(path[skip..].to_vec());
            if count > INSTANTS {
                break;
            }
        }
        let top = pieces.iter().flatten().map(|p| p.1.abs()).fold(0.0, f64::max).max(f64::MIN_POSITIVE);
        let line = |x: f64| vec![(x, -1.1 * top), (x, 1.1 * top)];
        let title = format!("Phase portrait between the stops (dashed){}", self.of_the_last(PORTRAIT));
        let x = Axis::over(self.lengths("w"), -1.15 * stop, 1.15 * stop);
        let y = Axis::over(format!("dw/dt ({}/s)", self.rate.symbol), -1.1 * top, 1.1 * top);
        let layers = vec![
            Layer::lines("", GREY, Dash::Dashed, vec![line(stop), line(-stop)]).stroke(THIN),
            Layer::lines("", RELATIVE, Dash::Solid, pieces).stroke(2).labelled("w"),
        ];
        titled(title, x, y, layers)
    }

    /// The speeds at a stop over time.
    fn speeds_at(&self, side: i8) -> Path {
        let at = |i: &&RunImpact| i.side == side;
        let point = |i: &RunImpact| (i.time, self.rate.per_metre * i.speed);
        self.history.impacts.iter().filter(at).map(point).collect()
    }

    /// Panel of the impact speeds. `None` if the speeds at each stop are equal, which the caption
    /// then states.
    fn speeds(&mut self) -> Option<Titled> {
        let sides = [1, -1].map(|side| self.speeds_at(side));
        let top = sides.iter().flatten().map(|p| p.1).fold(0.0, f64::max);
        if sides.iter().all(Vec::is_empty) {
            self.left_out.push("there are no impacts".into());
            return None;
        }
        let same = sides.each_ref().map(|path| constant(path.iter().map(|p| p.1), top));
        if same.iter().zip(&sides).all(|(same, path)| same.is_some() || path.is_empty()) {
            let told = self.told_speeds(same, &sides);
            self.left_out.push(told);
            return None;
        }
        let [upper, lower] = sides;
        let stops = [("upper stop", BLACK, Mark::Triangle, upper), ("lower stop", GREY, Mark::Ring, lower)];
        let count = stops.iter().map(|stop| stop.3.len()).sum::<usize>();
        let (many, size) = (count > MARKS, if count > MANY { SMALL } else { MARK });
        let layer = |(name, colour, mark, path): (&str, Colour, Mark, Path)| {
            if many {
                enveloped(name, colour, envelope(path.into_iter(), self.period, self.end()))
            } else {
                vec![Layer::marks(name, colour, mark, path).stroke(size)]
            }
        };
        let layers = stops.into_iter().flat_map(layer).collect();
        let y = Axis::over(format!("speed ({}/s)", self.rate.symbol), 0.0, 1.1 * top);
        let title = if many { "Impact speeds: least and largest" } else { "Impact speeds" };
        Some(titled(title, self.time(0.0), y, layers))
    }

    /// Equal speeds in words.
    fn told_speeds(&self, same: [Option<f64>; 2], sides: &[Path; 2]) -> String {
        let speeds = same.map(|speed| speed.map(|s| self.speed(s / self.rate.per_metre)));
        let number = |path: &Path| path.len();
        match speeds {
            [Some(upper), Some(lower)] if upper == lower => {
                format!("all {} impacts have a speed of {upper}", number(&sides[0]) + number(&sides[1]))
            }
            [upper, lower] => {
                let stops = [("upper", upper, &sides[0]), ("lower", lower, &sides[1])];
                let told = stops.into_iter().filter_map(|(stop, speed, path)| {
                    Some(format!(
                        "all {} impacts at the {stop} stop have a speed of {}",
                        number(path),
                        speed?
                    ))
                });
                told.collect::<Vec<_>>().join(", ")
            }
        }
    }

    /// Panel of the loads that change.
    fn loads(&mut self, loads: &[Load]) -> Option<Titled> {
        let mut layers = Vec::new();
        for load in loads {
            let points = || self.history.instants().map(|i| (i.time, load.force(i.time)));
            let (name, colour) = (load.body().name(), BODIES[load.body() as usize].2);
            let largest = points().map(|p| p.1.abs()).fold(0.0, f64::max);
            if let Some(force) = constant(points().map(|p| p.1), largest) {
                self.left_out.push(format!("the load on the {name} stays at {} N", short4(force)));
            } else if self.is_long() {
                layers.extend(enveloped(
                    &format!("on {name}"),
                    colour,
                    envelope(points(), self.period, self.end()),
                ));
            } else {
                let curve = Layer::line("", colour, Dash::Solid, thinned(points().collect())).stroke(THIN);
                layers.push(curve.labelled(format!("on {name}")));
            }
        }
        let title = if self.is_long() { "Loads: least and largest" } else { "Loads" };
        (!layers.is_empty()).then(|| titled(title, self.time(0.0), Axis::new("force (N)"), layers))
    }

    /// Sentence on the quantities that are not drawn.
    fn told_left_out(&self) -> Option<String> {
        let words = self.left_out.join("; ");
        (!words.is_empty()).then(|| format!("Not drawn, since it does not change: {words}."))
    }

    /// Sentence on the windows of envelopes.
    fn told_windows(&self) -> Option<String> {
        self.is_long().then(|| {
            format!(
                "{} drive periods. Areas: from the least to the largest value {}.",
                short(self.end() / self.period),
                super::envelope::in_words(self.period, self.end())
            )
        })
    }
}

/// A number with four digits, for captions.
fn short4(value: f64) -> String {
    let rounded: f64 = format!("{value:.3e}").parse().unwrap_or(value);
    short(rounded + 0.0).replace('-', "−")
}

/// The figure of a run; `None` if nothing changes.
pub(super) fn figure(
    set: &ParameterSet,
    history: &History,
    loads: &[Load],
    beginning: String,
) -> Option<Figure> {
    let mut shown = RunPicture::new(set, history);
    let mut found = Vec::new();
    if shown.is_long() {
        found.extend(shown.whole());
    }
    found.extend(shown.displacements(shown.last(DETAIL)));
    found.extend(shown.relative());
    found.extend(shown.speeds());
    found.extend(shown.loads(loads));
    let several = found.len() > 1;
    let lettered = |(letter, (title, panel)): (char, Titled)| {
        let title = if several { format!("({letter}) {title}") } else { title };
        Panel { title, ..panel }
    };
    let panels: Vec<Panel> = ('a'..).zip(found).map(lettered).collect();
    let mut caption = vec![format!("Run: {beginning}.")];
    caption.extend(shown.told_windows());
    caption.extend(shown.told_left_out());
    caption.push(set.caption());
    (!panels.is_empty()).then(|| Figure {
        title: "A motion of the machine".into(),
        caption,
        columns: panels.len().min(2),
        panels,
        panel: PANEL,
        shared_legend: false,
    })
}
