//! Derivatives of a motion with respect to the numbers of its machine, through impacts, contacts
//! and sticking (docs/assembly-law.md, section 14).
//!
//! A machine's numbers enter through rows and matrices, which are differentiated in closed form:
//! `tangent` contains the changes of the machine by a parameter, `mode` the changes of z' = A z.
//! `flight` carries derivatives between events; `crossing` and `impulse` carry them over events;
//! `start` and `rest` begin them. `resting` determines which contacts at rest come to rest again
//! when moved. A [`Differentiated`] motion combines these parts. It drives an ordinary
//! [`Motion`](crate::Motion), which has the same bits as without derivatives.

mod adjoint;
mod blocks;
mod bodies;
mod branches;
mod by;
mod columns;
mod crossing;
mod curved;
mod curved_flight;
mod differentiated;
mod extremes;
mod flight;
mod gradient;
mod impulse;
mod jump;
mod lost;
mod machine;
mod mode;
mod passed;
mod residual;
mod residual_rows;
mod rest;
mod resting;
mod rows;
mod samples;
mod series;
mod start;
mod tangent;
mod values;
mod weights;

pub use by::{By, has_derivative};
pub use differentiated::{Differentiated, VariedObserver};
pub use extremes::{Extreme, Extremes};
pub use gradient::Gradient;
pub use lost::{Cause, Lost};
