//! Result of a fit: machine, errors, residuals and verdict.

use super::beside::{Beside, Followed};
use super::bounds::Bounds;
use super::errors::Uncertainty;
use super::evaluated::{Point, Reach, Solved};
use super::joint::Joint;
use super::loss::Loss;
use super::model::Model;
use super::problem::Problem;
use super::statistics::rms;
use super::unknowns::Made;
use super::verdict::Verdict;
use super::{FitRequest, Fitted, Fresh};
use crate::QuantityName;
use crate::error::Result;
use vibro_machine::{Assembly, Start};

/// Results that all records share.
pub(super) struct Shared<'s> {
    /// Errors of the record's parameters.
    pub uncertainty: Uncertainty,
    /// Parameters of the record at an end of their range, with that end.
    pub at_bounds: Vec<(String, f64)>,
    /// Reason why the point is not certain.
    pub doubt: Option<&'s str>,
    pub cost: f64,
    /// Variance of residuals in units of the squared standard deviations.
    pub variance: f64,
    pub simulations: u32,
}

impl Joint<'_> {
    /// Results of all records at the best point.
    pub fn finish(
        &self,
        requests: &[FitRequest],
        bounds: &Bounds,
        (best, uncertainty, doubt): (&Solved, &Uncertainty, Option<String>),
    ) -> Result<Vec<Fitted>> {
        let variance = self.variance(best.cost, best.point.values.len());
        let reached = bounds.reached(&best.point.values);
        let simulations = self.simulations();
        let one = |(k, request): (usize, &FitRequest)| {
            let (point, reach) = self.local(k, &best.point, &best.reach);
            let places = &self.places[k];
            let names: Vec<String> = request.free.iter().map(|own| own.name.clone()).collect();
            let at_bounds = names.iter().zip(places).filter_map(|(name, place)| {
                let (_, end) = reached.iter().find(|(own, _)| *own == bounds.names[*place])?;
                Some((name.clone(), *end))
            });
            let shared = Shared {
                at_bounds: at_bounds.collect(),
                uncertainty: uncertainty.of_record(places, names),
                doubt: doubt.as_deref(),
                cost: best.cost,
                variance,
                simulations,
            };
            self.models[k].finish(request, &point, &reach, shared)
        };
        let mut all = requests.iter().enumerate().map(one).collect::<Result<Vec<_>>>()?;
        // Shared parameters that fit only one record are not the machine's.
        let misses = |(k, own): (usize, &Fitted)| match &own.verdict {
            Verdict::Fits => None,
            verdict => Some(format!("{} {verdict}", self.names[k])),
        };
        if let Some(why) = all.iter().enumerate().find_map(misses) {
            let fits = all.iter_mut().filter(|own| own.verdict == Verdict::Fits);
            fits.for_each(|own| own.verdict = Verdict::Undecided(why.clone()));
        }
        Ok(all)
    }
}

impl Model<'_> {
    /// Result of one record at a point.
    fn finish(&self, request: &FitRequest, point: &Point, reach: &Reach, shared: Shared) -> Result<Fitted> {
        let beside = self.compared.beside(&self.unknowns, point, reach, true)?;
        let Made { machine, assembly, start, .. } = self.unknowns.with(&point.values)?;
        let columns = &self.measured.columns;
        let of_column =
            |(k, (name, _)): (usize, &(QuantityName, _))| (name.to_string(), rms(beside.residuals(k)));
        let mut sizes: Vec<(String, f64)> = columns.iter().enumerate().map(of_column).collect();
        let mut contacts = Vec::new();
        for (k, (name, _)) in self.measured.contacts.iter().enumerate() {
            let off = self.contacts_off(&beside, k);
            sizes.push((name.clone(), rms(off.iter().copied())));
            let times = &self.measured.contacts[k].1;
            let off = beside.contacts(k).map(|(i, time)| time.map_or(f64::NAN, |time| time - times[i]));
            contacts.push((name.clone(), off.collect()));
        }
        let names: Vec<String> = request.free.iter().map(|own| own.name.clone()).collect();
        let residuals = beside.samples().map(|all| all.iter().map(|(residual, _)| *residual).collect());
        let named =
            |(time, stop): &(f64, usize)| Some((*time, machine.description.stops.get(*stop)?.name.clone()));
        let rounding = self.rounding(request, (point, reach), &beside, shared.variance)?;
        let doubt = self.begins_early(&point.values)?.or(shared.doubt.map(str::to_owned));
        // Derivatives ignore rounding steps, which may have kept the fit from the record's motion.
        let verdict = match (self.verdict(&beside), rounding, doubt) {
            (Verdict::Fits, None, Some(doubt)) => Verdict::Undecided(doubt),
            (Verdict::Fits, Some(rounding), _) => Verdict::Undecided(rounding),
            (Verdict::Misses(why) | Verdict::Undecided(why), Some(rounding), _) => {
                Verdict::Undecided(format!("{rounding}; {why}"))
            }
            (found, None, _) => found,
        };
        Ok(Fitted {
            verdict,
            events: beside.events().filter_map(named).collect(),
            segments: self.segments(&beside, &assembly, point, reach),
            start,
            uncertainty: shared.uncertainty,
            values: names.into_iter().zip(point.values.iter().copied()).collect(),
            machine,
            rms: sizes,
            residuals: residuals.collect(),
            contacts,
            // Outliers, which count little, do not end it.
            near_until: match self.loss {
                Loss::Linear => self.near(&beside, f64::NEG_INFINITY, super::WAYS[0]),
                Loss::SoftL1 | Loss::Huber => reach.end,
            },
            at_bounds: shared.at_bounds,
            lost: beside.lost(),
            simulations: shared.simulations,
            cost: shared.cost,
        })
    }

    /// Segments after the first, with their defects.
    fn segments(&self, beside: &Beside, assembly: &Assembly, point: &Point, reach: &Reach) -> Vec<Fresh> {
        let names = Start::names(assembly);
        let fresh = |((time, state), before): ((&f64, &Vec<f64>), &Followed)| Fresh {
            time: *time,
            state: names.iter().cloned().zip(state.iter().copied()).collect(),
            defect: before.end.iter().zip(state).map(|((end, _), next)| end - next).collect(),
        };
        reach.nodes.iter().zip(&point.states).zip(&beside.0).map(fresh).collect()
    }
}
