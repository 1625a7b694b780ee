//! The studies made from a bifurcation diagram: branches of periodic orbits over it, spectra at
//! some of its values.

use super::StudiedMachine;
use crate::Result;
use crate::kept_branches::{Behind, PathsInParts};
use crate::studies::{self, Study};
use serde::{Deserialize, Serialize};
use vibro_orbits::paper::TreeOptions;
use vibro_studies::diagram::{DescribedPoint, DiagramRequest};
use vibro_studies::paper::ParameterSet;
use vibro_studies::paper::bifurcation::{Sweep, SweepPoint};
use vibro_studies::{Diagram, Machine};

/// Studies made from a diagram of the paper's machine.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct OverSweep {
    /// Values at which spectra are listed and running exponents shown.
    pub at: Vec<f64>,
    /// Options for following the branches of periodic orbits; `None` if they are not followed.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub orbits: Option<TreeOptions>,
}

impl StudiedMachine for ParameterSet {
    type OverDiagram = OverSweep;

    fn names_over(sweep: &Sweep, over: &OverSweep) -> Vec<&'static str> {
        let spectra = sweep.exponents.is_some() && !over.at.is_empty();
        let all = [("orbits", over.orbits.is_some()), ("spectra", spectra), ("running", spectra)];
        all.into_iter().filter_map(|(name, is)| is.then_some(name)).collect()
    }

    fn over_diagram(
        &self,
        (sweep, diagram): (&Sweep, &Diagram<SweepPoint>),
        OverSweep { at, orbits }: &OverSweep,
        (parts, told): (Behind<'_>, &(dyn Fn(usize, usize) + Sync)),
        name: &str,
    ) -> Result<Vec<Study>> {
        let mut found = Vec::new();
        let told = |done, waiting| told(done, done + waiting);
        let follow =
            |options| studies::paper::DiagramOrbits::new(self, sweep, diagram, options, (&parts, &told));
        let orbits = orbits.as_ref().map(follow).transpose()?;
        if let Some(orbits) = &orbits {
            found.push(orbits.study(self, sweep, diagram, &format!("{name}-orbits"))?);
        }
        if let (Some(options), false) = (&sweep.exponents, at.is_empty()) {
            let spectra = format!("{name}-spectra");
            found.push(studies::paper::spectra(self, sweep, diagram, at, orbits.as_ref(), &spectra)?.1);
            let running = format!("{name}-running");
            found.push(studies::paper::running(self, sweep.axis.name, at, sweep.discard, options, &running)?);
        }
        Ok(found)
    }
}

impl StudiedMachine for Machine {
    /// Whether the branches of periodic orbits are followed.
    type OverDiagram = bool;

    fn names_over(_: &DiagramRequest<Self>, orbits: &bool) -> Vec<&'static str> {
        if *orbits { vec!["orbits"] } else { Vec::new() }
    }

    fn over_diagram(
        &self,
        (request, diagram): (&DiagramRequest<Self>, &Diagram<DescribedPoint>),
        orbits: &bool,
        (parts, told): (Behind<'_>, &(dyn Fn(usize, usize) + Sync)),
        name: &str,
    ) -> Result<Vec<Study>> {
        if !orbits {
            return Ok(Vec::new());
        }
        let paths = PathsInParts::new(parts);
        let (family, branches) = studies::diagram_branches(self, request, &paths, told)?;
        let (found, name) = ((&family, &branches[..]), format!("{name}-orbits"));
        Ok(vec![studies::diagram_orbits(self, request, diagram, found, &name)?])
    }
}
