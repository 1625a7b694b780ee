//! Motions of described machines, with their derivatives.

use crate::arrays::{Array1, Array2, column, numbers, plane, table};
use crate::background::{Control, compute, each_of};
use crate::designs::{GivenAssemblies, start_of};
use crate::failure::Failure;
use crate::machine::{Described, Numbers};
use numpy::PyReadonlyArray1;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use vibro_machine::derivative::VariedObserver;
use vibro_machine::motion::Event;
use vibro_machine::{Differentiated, Motion};
use vibro_studies::{NamedEvent, Start, named, values};

/// A sampled motion with its events, as a dictionary.
#[derive(IntoPyObject)]
pub struct RunArrays<'py> {
    values: Array2<'py, f64>,
    t: Array1<'py, f64>,
    kind: Vec<&'static str>,
    element: Vec<String>,
    value: Array1<'py, f64>,
    stops: Array1<'py, i32>,
    energy: Array2<'py, f64>,
    /// Derivatives by sample, column and parameter, and whether each exists.
    derivatives: Varied<'py>,
    /// Derivatives of the times of events, by event and parameter.
    event_derivatives: Varied<'py>,
    /// For each parameter: the reason why its derivatives cease to exist at some time. The text is
    /// empty if they exist throughout.
    lost: Vec<String>,
    /// The state at the end, as a start.
    end: Numbers,
}

/// Array of numbers, and array of flags: whether each number exists. A missing number is 0.
type Varied<'py> = (Array2<'py, f64>, Array2<'py, bool>);

fn varied<'py>(
    py: Python<'py>,
    all: &[Option<f64>],
    (rows, columns): (usize, usize),
) -> PyResult<Varied<'py>> {
    let numbers: Vec<f64> = all.iter().map(|x| x.unwrap_or(0.0)).collect();
    let known: Vec<bool> = all.iter().map(Option::is_some).collect();
    Ok((plane(py, &numbers, rows, columns)?, plane(py, &known, rows, columns)?))
}

/// A motion, with or without its derivatives.
enum Follower {
    Alone(Box<Motion>),
    Varied(Box<Differentiated>),
}

impl Follower {
    /// The motion of a machine from a start. `observer` is called for impacts at the start.
    fn new(
        machine: &Described,
        start: &Start,
        parameters: &[String],
        observer: &mut VariedObserver,
    ) -> Result<Self, Failure> {
        let assembly = machine.assembly()?;
        if parameters.is_empty() {
            let motion = start.motion_observed(assembly, &mut |event| observer(event, &[]))?;
            return Ok(Self::Alone(Box::new(motion)));
        }
        let names: Vec<&str> = parameters.iter().map(String::as_str).collect();
        Ok(Self::Varied(Box::new(start.differentiated(assembly, &names, observer)?)))
    }

    fn motion(&self) -> &Motion {
        match self {
            Self::Alone(motion) => motion,
            Self::Varied(varied) => varied.motion(),
        }
    }

    /// The derivatives of all columns with respect to all of `count` parameters.
    fn derivatives(&self, count: usize) -> Vec<Option<f64>> {
        let Self::Varied(varied) = self else { return Vec::new() };
        let quantities = varied.motion().assembly().description.quantities();
        quantities.flat_map(|q| (0..count).map(move |p| varied.derivative(q, p))).collect()
    }

    fn lost(&self, count: usize) -> Vec<String> {
        let Self::Varied(varied) = self else { return Vec::new() };
        (0..count).map(|p| varied.lost(p).map_or(String::new(), ToString::to_string)).collect()
    }

    fn advance(&mut self, time: f64, tell: &mut VariedObserver) -> Result<(), Failure> {
        match self {
            Self::Alone(motion) => motion.advance_observed(time, &mut |event| tell(event, &[]))?,
            Self::Varied(varied) => varied.advance_observed(time, tell)?,
        }
        Ok(())
    }
}

/// A sampled motion.
#[derive(Clone, Default)]
pub struct Sampled {
    count: usize,
    columns: usize,
    /// A row for each sample.
    values: Vec<f64>,
    energies: Vec<[f64; 3]>,
    derivatives: Vec<Option<f64>>,
    /// An entry for each event.
    times: Vec<f64>,
    told: Vec<NamedEvent>,
    event_derivatives: Vec<Option<f64>>,
    lost: Vec<String>,
    end: Numbers,
}

impl Sampled {
    /// The motion of a machine from a start, with its derivatives with respect to parameters.
    /// `each` is called before each sample.
    fn new(
        (machine, start): (&Described, &Numbers),
        times: &[f64],
        parameters: &[String],
        each: &mut dyn FnMut() -> Result<(), Failure>,
    ) -> Result<Self, Failure> {
        let (mut events, mut found) = (Vec::<Event>::new(), Self::default());
        let mut tell = |event: &Event, by: &[Option<f64>]| {
            if !event.is_listed() {
                return;
            }
            events.push(event.clone());
            found.event_derivatives.extend_from_slice(by);
        };
        let mut follower = Follower::new(machine, &machine.start_of(start)?, parameters, &mut tell)?;
        (found.count, found.columns) = (parameters.len(), machine.description().quantities().count());
        // A result that does not fit into memory is refused before the motion begins.
        found.values.try_reserve_exact(times.len().saturating_mul(found.columns))?;
        found.energies.try_reserve_exact(times.len())?;
        let derivatives = found.count.saturating_mul(found.columns);
        found.derivatives.try_reserve_exact(times.len().saturating_mul(derivatives))?;
        for &time in times {
            each()?;
            follower.advance(time, &mut tell)?;
            let motion = follower.motion();
            found.values.extend(values(motion));
            let (kinetic, stored) = motion.kinetic_and_stored();
            found.energies.push([kinetic, stored, motion.energy().balance()]);
            found.derivatives.extend(follower.derivatives(found.count));
        }
        let motion = follower.motion();
        found.end = Start::of(motion).numbers();
        found.told = events.iter().map(|event| named(motion.assembly(), &event.kind)).collect();
        found.times = events.iter().map(|event| event.time).collect();
        found.lost = follower.lost(found.count);
        Ok(found)
    }

    fn into_run(self, py: Python<'_>) -> PyResult<RunArrays<'_>> {
        let (told, samples) = (self.told, self.energies.len());
        Ok(RunArrays {
            values: plane(py, &self.values, samples, self.columns)?,
            t: column(py, &self.times),
            kind: told.iter().map(|e| e.kind).collect(),
            value: column(py, &told.iter().map(|e| e.value.unwrap_or(0.0)).collect::<Vec<_>>()),
            stops: column(py, &told.iter().map(|e| e.stops.unwrap_or(0) as i32).collect::<Vec<_>>()),
            element: told.into_iter().map(|e| e.element).collect(),
            energy: table(py, &self.energies)?,
            derivatives: varied(py, &self.derivatives, (samples, self.count * self.columns))?,
            event_derivatives: varied(py, &self.event_derivatives, (self.times.len(), self.count))?,
            lost: self.lost,
            end: self.end,
        })
    }
}

impl<'py> IntoPyObject<'py> for Sampled {
    type Target = PyDict;
    type Output = Bound<'py, PyDict>;
    type Error = PyErr;

    fn into_pyobject(self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        self.into_run(py)?.into_pyobject(py)
    }
}

/// The motion from a start at ascending times (s), with its events up to the last time, and with
/// its derivatives with respect to parameters.
#[pyfunction]
#[pyo3(signature = (machine, start, t, parameters, progress = None))]
pub fn simulate<'py>(
    py: Python<'py>,
    machine: &Described,
    start: Numbers,
    t: PyReadonlyArray1<'_, f64>,
    parameters: Vec<String>,
    progress: Option<&Bound<'_, PyAny>>,
) -> PyResult<RunArrays<'py>> {
    let (own, times) = (machine.clone(), numbers(&t)?);
    let found = compute(py, progress, move |control| {
        let mut each = || {
            control.add(1);
            control.check()
        };
        Sampled::new((&own, &start), &times, &parameters, &mut each)
    })?;
    found.into_run(py)
}

/// Like [`simulate`], for many machines, each from its start, on all threads.
#[pyfunction]
#[pyo3(signature = (machines, starts, t, parameters, progress = None))]
pub fn follow_many(
    py: Python<'_>,
    machines: GivenAssemblies<'_>,
    starts: Vec<Numbers>,
    t: PyReadonlyArray1<'_, f64>,
    parameters: Vec<String>,
    progress: Option<&Bound<'_, PyAny>>,
) -> PyResult<Vec<Sampled>> {
    let (machines, times) = (machines.owned()?, numbers(&t)?);
    let count = machines.len();
    let one = move |control: &Control, index: usize| {
        let of = (&machines.machine(index)?, start_of(&starts, index));
        Sampled::new(of, &times, &parameters, &mut || control.check())
    };
    each_of(py, count, progress, one)
}

/// Final states of many motions: a row for each motion, and the reason if the motion has no final
/// state; its row then contains zeros.
pub type Ends<'py> = (Array2<'py, f64>, Vec<Option<String>>);

/// Simulates one motion of each of many machines until a time (s), and returns the final states.
/// Each motion has its own start, or all have a common one; all machines have the same columns. If
/// `in_rows`, a failed motion has a reason in its row instead of ending the computation.
#[pyfunction]
#[pyo3(signature = (machines, starts, until, in_rows, progress = None))]
pub fn simulate_many<'py>(
    py: Python<'py>,
    machines: GivenAssemblies<'_>,
    starts: Vec<Numbers>,
    until: f64,
    in_rows: bool,
    progress: Option<&Bound<'_, PyAny>>,
) -> PyResult<Ends<'py>> {
    let machines = machines.owned()?;
    let (count, columns) = (machines.len(), machines.columns());
    let ended = move |index: usize| -> Result<Vec<f64>, Failure> {
        let own = machines.machine(index)?;
        let start = own.start_of(start_of(&starts, index))?;
        let mut motion = start.motion(own.assembly()?)?.without_energy_accounts();
        motion.advance_to(until)?;
        Ok(values(&motion))
    };
    let one = move |_: &Control, index: usize| match ended(index) {
        Ok(row) => Ok((row, None)),
        Err(failure) if in_rows => Ok((vec![0.0; columns], Some(failure.reason()?))),
        Err(failure) => Err(failure),
    };
    let (rows, reasons): (Vec<_>, Vec<_>) = each_of(py, count, progress, one)?.into_iter().unzip();
    Ok((plane(py, &rows.concat(), rows.len(), columns)?, reasons))
}

/// The derivatives of a motion's final state with respect to its initial state.
#[derive(IntoPyObject)]
pub struct Transition<'py> {
    /// Names of the numbers of the state.
    names: Vec<String>,
    /// The start with all its numbers.
    start: Numbers,
    end: Numbers,
    /// Element (i, j): derivative of number i of the final state with respect to number j of the
    /// initial state.
    matrix: Varied<'py>,
    /// For each number of the initial state: the reason why derivatives with respect to it do not
    /// exist, or an empty text.
    lost: Vec<String>,
}

/// The derivatives of the state at a time (s) with respect to the state at the start.
#[pyfunction]
#[pyo3(signature = (machine, start, until, progress = None))]
pub fn transition<'py>(
    py: Python<'py>,
    machine: &Described,
    start: Numbers,
    until: f64,
    progress: Option<&Bound<'_, PyAny>>,
) -> PyResult<Transition<'py>> {
    let own = machine.clone();
    let (names, start, end, rows, lost) = compute(py, progress, move |_| {
        let (assembly, start) = (own.assembly()?, own.start_of(&start)?);
        let names = Start::names(&assembly);
        let state = start.state(&assembly)?;
        let whole = std::iter::once(("time".to_owned(), start.time));
        let whole: Numbers = whole.chain(names.iter().cloned().zip(state)).collect();
        let mut motion = start.transition(assembly)?;
        motion.advance_to(until)?;
        let columns: Vec<_> = (0..names.len()).map(|p| motion.state_derivative(p)).collect();
        let row = |i: usize| columns.iter().map(|column| column.as_ref().map(|c| c[i])).collect::<Vec<_>>();
        let rows: Vec<_> = (0..names.len()).map(row).collect();
        let lost = (0..names.len()).map(|p| motion.lost(p).map_or(String::new(), ToString::to_string));
        Ok((names, whole, Start::of(motion.motion()).numbers(), rows, lost.collect()))
    })?;
    let count = names.len();
    Ok(Transition { names, start, end, matrix: varied(py, &rows.concat(), (rows.len(), count))?, lost })
}
