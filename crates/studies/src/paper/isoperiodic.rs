//! The paper's machine as a [`PlaneMachine`]: the simulated motion at each point of the plane,
//! compared with the exact orbit that has two symmetric impacts per period. The motions of several
//! rows run [side by side](Workspace::run).

use super::parameter_set::ParameterSet;
use super::plane::{self, SteadyStateClass};
use super::start::{StartRule, state};
use super::stroboscopic::{dimensionless, moving_block};
use super::trajectories::{MOTIONS, Start, Workspace};
use super::verdict::{Followed, Following, PROLONGED, follow};
use crate::class::{MotionClass, OBSERVED};
use crate::error::{Error, Result};
use crate::isoperiodic::PlaneMachine;
use serde::{Deserialize, Serialize};
use std::ops::Range;
use vibro_impact::parameters::Parameters;
use vibro_impact::simulator::{Simulator, State};

/// Request of an isoperiodic diagram of the paper's machine.
pub type IsoperiodicRequest<M = ParameterSet> = crate::isoperiodic::IsoperiodicRequest<M>;
/// Plane of motions of the paper's machine.
pub type Isoperiodic<P = PlanePoint> = crate::isoperiodic::Isoperiodic<P>;

/// Motion on which a start settles.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct SettledMotion {
    /// Class of the motion.
    pub class: MotionClass,
    /// Impacts per drive period at the upper and at the lower stop.
    pub impacts: [f64; 2],
    /// Whether the block rests at a stop in part of a period.
    pub rests: bool,
    /// Whether the motion is its own mirror image; false for motions without a period.
    pub symmetric: bool,
    /// Largest of the seven exponents, per unit of τ, and its standard error. `None` if exponents
    /// were not requested, and for motions without impacts or with a period. The exponent is not
    /// negative, since one of the seven is zero.
    pub exponent: Option<[f64; 2]>,
    /// Whether the motion has settled on the stable exact orbit.
    pub on_orbit: bool,
}

impl SettledMotion {
    /// Whether the motion is of the exact orbit's kind: symmetric, with one impact at each stop in
    /// each drive period, and without rest.
    pub fn is_two_impact(&self) -> bool {
        self.class == MotionClass::Periodic(1) && self.symmetric && self.impacts == [1.0; 2] && !self.rests
    }
}

/// Point of the plane.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct PlanePoint {
    /// Class of the exact orbit there.
    pub theory: SteadyStateClass,
    /// The simulated motion; `None` if the simulator refuses it.
    pub motion: Option<SettledMotion>,
}

/// Agreement of theory and simulation, in numbers of points.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Agreement {
    /// Points where the exact orbit is stable.
    pub stable: usize,
    /// Number of these points whose simulated motion is on the exact orbit. The other motions
    /// start in the basin of another motion.
    pub reached: usize,
    /// Points whose simulated motion is of the exact orbit's [kind](SettledMotion::is_two_impact).
    pub two_impact: usize,
    /// Number of these points where the exact orbit is stable and the motion is on it. Any other
    /// point contradicts the theory.
    pub predicted: usize,
}

impl Isoperiodic {
    /// Agreement of theory and simulation.
    pub fn agreement(&self) -> Agreement {
        let count = |holds: &dyn Fn(&PlanePoint) -> bool| self.points.iter().filter(|p| holds(p)).count();
        let stable = |p: &PlanePoint| p.theory == SteadyStateClass::Stable;
        let orbit = |p: &PlanePoint| p.motion.is_some_and(|m| m.on_orbit);
        let kind = |p: &PlanePoint| p.motion.is_some_and(|m| m.is_two_impact());
        Agreement {
            stable: count(&stable),
            reached: count(&|p| stable(p) && orbit(p)),
            two_impact: count(&kind),
            predicted: count(&|p| kind(p) && orbit(p)),
        }
    }
}

impl PlaneMachine for ParameterSet {
    type Point = PlanePoint;
    type Workspace = Workspace;
    const IN_PLANE_PART: usize = MOTIONS;

    fn check_plane(&self, request: &IsoperiodicRequest) -> Result<()> {
        let p = self.parameters();
        match &request.start {
            StartRule::State(start) => Ok(Simulator::new(p, &state(p, start), 0.0).map(drop)?),
            StartRule::Orbit => {
                p.check_symmetric()?;
                match [&request.x, &request.y].into_iter().find(|axis| axis.name.is_load()) {
                    None => Ok(()),
                    Some(axis) => Err(Error::Form {
                        text: format!("start orbit, {} on an axis", axis.name.name()),
                        expected: "a start by coordinates: the exact orbit is the orbit without loads",
                    }),
                }
            }
        }
    }

    fn points(
        &self,
        request: &IsoperiodicRequest,
        rows: Range<usize>,
        workspace: &mut Workspace,
    ) -> Vec<PlanePoint> {
        points(self, request, rows, workspace)
    }
}

/// Machine at a point of a row, before simulation.
struct Site {
    theory: SteadyStateClass,
    /// State of the stable exact orbit at time 0.
    orbit: Option<State>,
    /// `None` if the values do not make a machine.
    start: Option<Start>,
}

fn site(set: &ParameterSet, request: &IsoperiodicRequest, column: usize, row: usize) -> Site {
    let none = Site { theory: SteadyStateClass::Undefined, orbit: None, start: None };
    let row = set.with(request.y.name, request.y.value(row));
    let Ok(set) = row.and_then(|row| row.with(request.x.name, request.x.value(column))) else { return none };
    let parameters = *set.parameters();
    let (theory, orbit) = plane::exact(&parameters).unwrap_or((SteadyStateClass::Undefined, None));
    let orbit = orbit.map(|o| o.initial_state()).map(|o| State { x: o.x, v: o.v });
    let state = match (&request.start, orbit) {
        (StartRule::State(start), _) => state(&parameters, start),
        (StartRule::Orbit, Some(orbit)) => orbit,
        (StartRule::Orbit, None) => moving_block(&parameters),
    };
    Site { theory, orbit, start: Some(Start { parameters, state }) }
}

/// The points of some rows. Neighbours in a row have similar motions, which take similar times
/// when they run side by side.
fn points(
    set: &ParameterSet,
    request: &IsoperiodicRequest,
    rows: Range<usize>,
    workspace: &mut Workspace,
) -> Vec<PlanePoint> {
    let sites = rows.flat_map(|j| (0..request.x.count).map(move |i| (i, j)));
    let sites: Vec<Site> = sites.map(|(i, j)| site(set, request, i, j)).collect();
    let mut points: Vec<PlanePoint> =
        sites.iter().map(|site| PlanePoint { theory: site.theory, motion: None }).collect();
    let there: Vec<(usize, Start)> =
        sites.iter().enumerate().filter_map(|(index, site)| Some((index, site.start?))).collect();
    let starts: Vec<Start> = there.iter().map(|(_, start)| *start).collect();
    let following = Following {
        discard: request.discard,
        exponent: request.exponents,
        // Without exponents, following chaos further would not show anything.
        limit: if request.exponents.is_some() { PROLONGED } else { 0 },
    };
    follow(workspace, &starts, &following, &mut |number, outcome, _| {
        let (index, start) = there[number];
        let orbit = sites[index].orbit.as_ref();
        let seen_again = outcome.as_ref().is_ok_and(|found| found.periods > OBSERVED);
        points[index].motion = outcome.ok().map(|found| motion(&start.parameters, found, orbit));
        // A quasi-periodic class needs a second observation (`MotionClass::is_final`).
        points[index].motion.is_none_or(|m| m.class.is_final() || seen_again && m.class.is_decided())
    });
    points
}

fn motion(p: &Parameters, followed: &Followed, orbit: Option<&State>) -> SettledMotion {
    let found = &followed.attractor;
    let exponent = followed.exponent.map(|e| [e.value, e.error].map(|rate| rate / p.box_frequency()));
    let symmetric = found.period.is_some() && found.is_symmetric();
    SettledMotion {
        class: followed.class,
        impacts: found.impacts,
        rests: found.rests,
        symmetric,
        exponent: exponent.map(|[value, error]| [value.max(0.0), error]),
        on_orbit: found.period == Some(1)
            && symmetric
            && orbit.is_some_and(|o| found.passes(&dimensionless(p, o))),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::isoperiodic::isoperiodic;
    use crate::paper::find_group;
    use crate::paper::plane::ParameterAxis;
    use crate::parts::Task;

    #[test]
    fn second_method_beyond_a_doubling_there_is_one_orbit() {
        // Above 2.8022 the orbit of one drive period is unstable, but so weakly that motions leave
        // it slowly and look quasi-periodic for thousands of periods. The orbit of two periods is
        // stable there, as the branches of `vibro-orbits` show.
        let x = ParameterAxis::new(find_group("f10").unwrap(), (2.8035, 2.808), 60).unwrap();
        let y = ParameterAxis::new(find_group("kappa").unwrap(), (0.7499, 0.7501), 2).unwrap();
        let start = "x1=-0.6,v1=0.3,v2=0.4,x3=0.2".parse().unwrap();
        let request = IsoperiodicRequest { x, y, start, discard: 300, exponents: Some(4000) };
        let found = isoperiodic(&ParameterSet::basic(), &request, &Task::ALL).unwrap().unwrap();
        let classes = found.points.iter().map(|point| point.motion.map(|motion| motion.class));
        for (index, class) in classes.enumerate() {
            assert_eq!(class, Some(MotionClass::Periodic(2)), "f10 = {}", request.x.value(index % 60));
        }
    }
}
