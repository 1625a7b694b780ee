//! Several records of one machine fitted together. Some free parameters are shared, others belong
//! to one record.
//!
//! The segments of all records are in sequence, record after record. The first segment of a record
//! begins with the start of its own motion and has no tie to the previous record.

use super::FitRequest;
use super::beside::Compared;
use super::bounds::Bounds;
use super::directions::Directions;
use super::evaluated::{Evaluated, NEXT_RECORD, Point, Reach, Solved};
use super::loss::Loss;
use super::model::Model;
use super::problem::Problem;
use crate::error::{Error, Result};
use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;
use std::sync::Arc;

/// Degrees of freedom with which a record's residuals estimate its noise.
const FREEDOM: usize = 8;
/// Smallest number of residuals beyond the number of free numbers for a verdict without given
/// deviations: with fewer of them errors are wrong by factors.
const FEWEST: usize = 3;
/// Singular value, relative to the largest, below which a merged combination keeps the first
/// record's values.
const SINGULAR: f64 = 1e-9;

/// The records of a fit.
pub(super) struct Joint<'a> {
    pub models: Vec<Model<'a>>,
    /// Name of each record in messages.
    pub names: Vec<String>,
    /// Joint indices of each record's free parameters.
    pub places: Vec<Vec<usize>>,
    /// Number of joint parameters.
    count: usize,
    /// Number of states of each record's machine.
    states: Vec<usize>,
}

/// Name of a record in messages, from its index and its request.
fn named((k, request): (usize, &FitRequest)) -> String {
    if request.name.is_empty() { format!("record {}", k + 1) } else { format!("record {}", request.name) }
}

/// Error if records differ in a setting that all of them share.
fn check(requests: &[FitRequest], names: &[String]) -> Result<()> {
    let refused = |problem: String| Err(Error::Described { problem });
    let Some(first) = requests.first() else {
        return refused("no record; expected at least one".into());
    };
    for (own, record) in requests.iter().zip(names) {
        let same = |what| refused(format!("{record}: {what} differs from {}", names[0]));
        match () {
            () if own.free != first.free => return same("the list of free parameters"),
            () if own.loss != first.loss => return same("the loss"),
            () if own.segments != first.segments => return same("the choice of segments"),
            () if own.starts != first.starts => return same("the number of further starts"),
            () if own.sigma.is_some() != first.sigma.is_some() => {
                return refused(format!(
                    "{record}: standard deviations must be given for all records or for none"
                ));
            }
            () => {}
        }
    }
    Ok(())
}

impl<'a> Joint<'a> {
    /// Joint problem of several requests.
    ///
    /// # Errors
    /// [`Error::Described`] for requests that differ in shared settings, and the errors of a
    /// single record.
    pub fn new(requests: &'a [FitRequest]) -> Result<Self> {
        let names: Vec<String> = requests.iter().enumerate().map(named).collect();
        check(requests, &names)?;
        let mut models = requests.iter().map(Model::new).collect::<Result<Vec<_>>>()?;
        let watch = models[0].watch.clone();
        for model in &mut models {
            model.watch = watch.clone();
            model.is_part = requests.len() > 1;
        }
        let free = &requests[0].free;
        let (mut places, mut count) = (vec![Vec::new(); models.len()], 0);
        for own in free {
            let is_own = own.is_own || own.name.starts_with("record.");
            for (k, places) in places.iter_mut().enumerate() {
                places.push(count + if is_own { k } else { 0 });
            }
            count += if is_own { models.len() } else { 1 };
        }
        let states = models.iter().map(Model::states).collect::<Result<_>>()?;
        Ok(Self { models, names, places, count, states })
    }

    /// Ranges and initial values of the joint parameters.
    ///
    /// # Errors
    /// [`Error::Described`] for invalid ranges, and for a shared parameter with different initial
    /// values.
    pub fn bounds(&self, requests: &[FitRequest]) -> Result<Bounds> {
        let all = requests.iter().zip(&self.models);
        let all = all.map(|(request, model)| Bounds::of(request, model)).collect::<Result<Vec<_>>>()?;
        Bounds::joint(&all, (&self.places, self.count), (&self.names, self.rows()))
    }

    /// Index of each record's first segment among all segments.
    fn begins(&self, reach: &Reach) -> Vec<usize> {
        let next = reach.nodes.iter().enumerate().filter(|(_, node)| **node == NEXT_RECORD);
        std::iter::once(0).chain(next.map(|(k, _)| k + 1)).collect()
    }

    /// One record's values among the joint values.
    pub fn values_of(&self, k: usize, values: &[f64]) -> Vec<f64> {
        self.places[k].iter().map(|&place| values[place]).collect()
    }

    /// Point and reach of one record.
    pub fn local(&self, k: usize, point: &Point, reach: &Reach) -> (Point, Reach) {
        let begins = self.begins(reach);
        let nodes = begins[k]..begins.get(k + 1).map_or(reach.nodes.len(), |next| next - 1);
        let before: usize = self.states[..k].iter().sum();
        let weights = reach.weights.get(before..before + self.states[k]).unwrap_or_default();
        let own = Point {
            values: self.values_of(k, &point.values),
            states: point.states.get(nodes.clone()).unwrap_or_default().to_vec(),
        };
        let end = reach.end.min(self.models[k].end());
        (own, Reach { end, nodes: reach.nodes[nodes].to_vec(), weights: weights.to_vec() })
    }

    /// Reach of whole records, each with a single motion.
    fn whole(&self) -> Reach {
        let nodes = vec![NEXT_RECORD; self.models.len() - 1];
        let end = self.models.iter().map(Model::end).fold(f64::NEG_INFINITY, f64::max);
        Reach { nodes, ..Reach::whole(end) }
    }

    /// A single motion of each record with joint values.
    pub fn single(&self, values: Vec<f64>) -> Solved {
        let point = Point { values, states: vec![Vec::new(); self.models.len() - 1] };
        Solved { point, reach: self.whole(), cost: f64::INFINITY, is_continuous: true }
    }

    /// Fits of single records combined into one point with the given joint values.
    pub fn together(&self, found: &[Solved], values: Vec<f64>) -> Solved {
        let (mut point, mut reach) = (Point { values, states: Vec::new() }, self.whole());
        reach.nodes.clear();
        for (k, own) in found.iter().enumerate() {
            if k > 0 {
                reach.nodes.push(NEXT_RECORD);
                point.states.push(Vec::new());
            }
            reach.nodes.extend(&own.reach.nodes);
            point.states.extend(own.point.states.iter().cloned());
            let weights = own.reach.weights.iter().copied().chain(std::iter::repeat(1.0));
            reach.weights.extend(weights.take(self.states[k]));
        }
        let is_continuous = found.iter().all(|own| own.is_continuous);
        Solved { point, reach, cost: f64::INFINITY, is_continuous }
    }

    /// Joint values from the fits of single records; shared parameters are from record `of`.
    pub fn values_as(&self, of: usize, found: &[Solved]) -> Vec<f64> {
        let mut values = vec![0.0; self.count];
        let others = (0..found.len()).filter(|k| *k != of).chain(std::iter::once(of));
        for k in others {
            self.places[k].iter().zip(&found[k].point.values).for_each(|(&place, x)| values[place] = *x);
        }
        values
    }

    /// Joint values that minimise the sum of the records' quadratic costs: a record weighs on a
    /// parameter by how well it determines it. `None` if a derivative is not finite.
    pub fn merged(&self, found: &[Solved]) -> Option<Vec<f64>> {
        let begin = self.values_as(0, found);
        let mut information = DMatrix::<f64>::zeros(self.count, self.count);
        let mut right = DVector::<f64>::zeros(self.count);
        for (k, own) in found.iter().enumerate() {
            let at = self.models[k].evaluate(&own.point, &own.reach).ok()?;
            let p = own.point.values.len();
            let directions = Directions::of(&self.models[k], &own.point.values, &at)?;
            let square = directions.jacobian.tr_mul(&directions.jacobian);
            let variance = self.models[k].variance(own.cost, p).max(f64::MIN_POSITIVE);
            for i in 0..p {
                let a = self.places[k][i];
                for j in 0..p {
                    let b = self.places[k][j];
                    information[(a, b)] += square[(i, j)] / variance;
                    right[a] += square[(i, j)] / variance * (own.point.values[j] - begin[b]);
                }
            }
        }
        // Scaling by effect makes parameters independent of their units.
        let unit = |j: usize| match information[(j, j)] {
            own if own > 0.0 => own.sqrt().recip(),
            _ => 0.0,
        };
        let units = DVector::from_fn(self.count, |j, _| unit(j));
        let scaled =
            DMatrix::from_fn(self.count, self.count, |i, j| information[(i, j)] * units[i] * units[j]);
        let right = right.component_mul(&units);
        let change = scaled.svd(true, true).solve(&right, SINGULAR).ok()?.component_mul(&units);
        let values: Vec<f64> = begin.iter().zip(change.iter()).map(|(x, dx)| x + dx).collect();
        values.iter().all(|x| x.is_finite()).then_some(values)
    }

    /// Whether the motion of each record fits, or is so near that restarts can reach it.
    pub fn fits(&self, point: &Point, reach: &Reach) -> Result<bool> {
        self.holds(point, reach, Model::fits)
    }

    /// Whether the residuals of all records exceed rounding.
    pub fn is_noisy(&self, point: &Point, reach: &Reach) -> Result<bool> {
        self.holds(point, reach, Model::is_noisy)
    }

    /// Whether a statement holds for all records.
    fn holds(
        &self,
        point: &Point,
        reach: &Reach,
        statement: impl Fn(&Model<'a>, &Point, &Reach) -> Result<bool>,
    ) -> Result<bool> {
        let one = |k: usize| {
            let (point, reach) = self.local(k, point, reach);
            statement(&self.models[k], &point, &reach)
        };
        (0..self.models.len()).try_fold(true, |all, k| Ok(all && one(k)?))
    }

    /// Whether the motion of a record is chaotic.
    pub fn is_chaotic(&self, values: &[f64]) -> bool {
        let mut models = self.models.iter().enumerate();
        models.any(|(k, model)| model.is_chaotic(&self.values_of(k, values)))
    }

    /// Sets the standard deviations of columns and contacts from the residuals at a point.
    pub fn reweigh(&mut self, point: &Point, reach: &Reach) -> Result<()> {
        let all: Vec<_> = (0..self.models.len()).map(|k| self.local(k, point, reach)).collect();
        for (model, (point, reach)) in self.models.iter_mut().zip(&all) {
            model.reweigh(point, reach)?;
        }
        if self.models.len() > 1 {
            self.correct_deviations();
        }
        Ok(())
    }

    /// Number of residuals of a record minus the number of its own parameters.
    fn freedom(&self, k: usize) -> usize {
        let is_own =
            |place: &&usize| !self.places.iter().enumerate().any(|(j, own)| j != k && own.contains(place));
        self.models[k].rows().saturating_sub(self.places[k].iter().filter(is_own).count())
    }

    /// Standard deviations of the records that have enough degrees of freedom to estimate them.
    fn estimated(&self) -> Vec<(String, f64)> {
        let enough = (0..self.models.len()).filter(|&k| self.freedom(k) >= FREEDOM);
        enough.flat_map(|k| self.models[k].named_deviations()).collect()
    }

    /// Corrects the standard deviations of records by their degrees of freedom. A record with few
    /// degrees of freedom takes the deviation of the same column in other records.
    fn correct_deviations(&mut self) {
        let freedom: Vec<usize> = (0..self.models.len()).map(|k| self.freedom(k)).collect();
        let known = self.estimated();
        for (k, model) in self.models.iter_mut().enumerate() {
            if freedom[k] >= FREEDOM {
                model.scale_deviations((model.rows() as f64 / freedom[k] as f64).sqrt());
            } else {
                model.take_deviations(&known);
            }
        }
    }

    /// Message if too few residuals are left to estimate the noise.
    pub fn lacks_noise(&self) -> Option<String> {
        let (rows, free) = (self.rows(), self.count);
        if self.has_sigma() {
            return None;
        }
        if rows <= free {
            let what = "exactly: no residual is left to estimate the noise";
            return Some(format!("{free} parameters fit {rows} samples {what}"));
        }
        if rows < free + FEWEST {
            return Some(format!(
                "{rows} samples for {free} parameters leave too few residuals to estimate the noise"
            ));
        }
        let known = self.estimated();
        let is_known = |name: &String| known.iter().any(|(own, _)| own == name);
        let is_vague = |&k: &usize| {
            let all = self.models[k].named_deviations();
            self.freedom(k) < FREEDOM && !all.iter().all(|(name, _)| is_known(name))
        };
        let vague = (0..self.models.len()).filter(|_| self.models.len() > 1).find(is_vague)?;
        Some(format!("{} has too few samples to estimate its noise", self.names[vague]))
    }

    /// Comparison of each record with the machine.
    pub fn compared(&self) -> Vec<Arc<Compared<'a>>> {
        self.models.iter().map(|model| model.compared.clone()).collect()
    }

    /// Number of simulations so far.
    pub fn simulations(&self) -> u32 {
        self.models.iter().map(|model| model.compared.simulations()).sum()
    }
}

impl Problem for Joint<'_> {
    fn loss(&self) -> Loss {
        self.models[0].loss
    }

    fn has_sigma(&self) -> bool {
        self.models[0].has_sigma
    }

    fn rows(&self) -> usize {
        self.models.iter().map(Model::rows).sum()
    }

    fn has_stops(&self) -> bool {
        self.models.iter().any(Model::has_stops)
    }

    fn is_of_contacts(&self) -> bool {
        self.models.iter().all(Model::is_of_contacts)
    }

    fn simulations(&self) -> u32 {
        Joint::simulations(self)
    }

    fn evaluate(&self, point: &Point, reach: &Reach) -> Result<Evaluated> {
        let one = |k: usize| {
            let (point, reach) = self.local(k, point, reach);
            self.models[k].evaluate(&point, &reach)
        };
        let all = (0..self.models.len()).into_par_iter().map(one).collect::<Result<Vec<_>>>()?;
        let (mut segments, mut columns) = (Vec::new(), 0);
        for (k, own) in all.into_iter().enumerate() {
            for mut segment in own.0 {
                segment.place(k, (&self.places[k], self.count), columns);
                segments.push(segment);
            }
            columns += self.models[k].deviations().len();
        }
        Ok(Evaluated(segments))
    }

    fn cost(&self, solved: &Solved) -> Result<f64> {
        let one = |k: usize| {
            let (point, reach) = self.local(k, &solved.point, &solved.reach);
            self.models[k].cost(&Solved { point, reach, ..*solved })
        };
        (0..self.models.len()).into_par_iter().map(one).sum()
    }

    fn misses(&self, point: &Point, reach: &Reach) -> Result<bool> {
        let one = |k: usize| {
            let (point, reach) = self.local(k, point, reach);
            self.models[k].misses(&point, &reach)
        };
        (0..self.models.len()).try_fold(false, |any, k| Ok(any || one(k)?))
    }

    fn size_of_start(&self, j: usize, values: &[f64]) -> Option<f64> {
        let own = |k: usize| {
            let place = self.places[k].iter().position(|place| *place == j)?;
            self.models[k].size_of_start(place, &self.values_of(k, values))
        };
        (0..self.models.len()).find_map(own)
    }

    fn tell(&self, cost: f64, reach: &Reach) {
        self.models[0].watch.cost(cost, reach.is_whole());
    }
}
