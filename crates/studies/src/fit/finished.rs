//! The fitted machine with its errors, residuals and verdict.

use super::beside::{Beside, Followed};
use super::errors::Uncertainty;
use super::evaluated::{Point, Reach};
use super::loss::Loss;
use super::model::Model;
use super::statistics::rms;
use super::unknowns::Made;
use super::verdict::Verdict;
use super::{FitRequest, Fitted, Fresh};
use crate::QuantityName;
use crate::error::Result;
use vibro_machine::{Assembly, Start};

impl Model<'_> {
    /// The machine fitted at a point.
    pub fn finish(
        &self,
        request: &FitRequest,
        point: &Point,
        reach: &Reach,
        cost: f64,
        doubt: Option<String>,
    ) -> Result<Fitted> {
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
        let at = self.evaluated(&beside, point, reach);
        let residuals = beside.samples().map(|all| all.iter().map(|(residual, _)| *residual).collect());
        let all = beside.0.iter().flat_map(|own| &own.events);
        let named =
            |(time, stop): &(f64, usize)| Some((*time, machine.description.stops.get(*stop)?.name.clone()));
        let variance = self.variance(cost, point.values.len());
        let rounding = self.rounding(request, (point, reach), &beside, variance)?;
        let doubt = self.lacks_noise().or(self.begins_early(&point.values)?).or(doubt);
        // Steps that derivatives do not see may have kept the fit from a motion that is the
        // record's.
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
            events: all.filter_map(named).collect(),
            segments: self.segments(&beside, &assembly, point, reach),
            start,
            uncertainty: Uncertainty::of(&at, &names, &point.values, (self.loss, self.has_sigma)),
            values: names.into_iter().zip(point.values.iter().copied()).collect(),
            machine,
            rms: sizes,
            residuals: residuals.collect(),
            contacts,
            // Outliers that count little do not end it.
            near_until: match self.loss {
                Loss::Linear => self.near(&beside, f64::NEG_INFINITY, super::WAYS[0]),
                Loss::SoftL1 | Loss::Huber => reach.end,
            },
            at_bounds: Vec::new(),
            lost: beside.lost(),
            simulations: self.compared.simulations(),
            cost,
        })
    }

    /// Where segments begin anew, and by how much the ones before miss it.
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
