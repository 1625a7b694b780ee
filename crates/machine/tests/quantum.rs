//! Derivatives of sampled blocks that round their inputs to a quantum: a rounded input keeps its
//! multiple.

use crate::blocks::check_derivatives;
use crate::common::*;
use std::sync::Arc;
use vibro_machine::derivative::{By, Cause};
use vibro_machine::{Assembly, Differentiated, Quantity, What};

/// Roundings of a sum over twenty samples.
const ROUNDING: f64 = 1e-13;

/// A cart under a digital spring that reads its coordinate in multiples of 1 mm.
fn encoder(start: &str) -> String {
    format!(
        "name = \"Encoder\"\n[body.cart]\nmass = 1.0\nstart = {{ s = {start}, v = 0.2 }}\n[block.pd]\n\
         inputs = [\"cart.s\"]\nd = [[-40.0]]\noutputs = [\"u\"]\nsample = \"10 ms\"\n\
         quantum = {{ \"cart.s\" = 0.001 }}\n[load.motor]\non = \"cart\"\nfrom = \"pd.u\"\nfactor = \"1 N\"\n"
    )
}

fn by_place(text: &str) -> Differentiated {
    let columns: Vec<By> = vec!["body.cart.start.s".into()];
    let mut motion = Differentiated::new(Arc::new(Assembly::new(machine(text)).unwrap()), &columns).unwrap();
    motion.advance_to(0.2).unwrap();
    motion
}

#[test]
fn closed_form_a_cart_under_a_rounded_reading_moves_as_far_as_its_start() {
    // The force is a multiple of 40 mN, even while the cart moves between two multiples of 1 mm.
    let motion = by_place(&encoder("0.0137"));
    let [s, v] = [What::S, What::V].map(|what| motion.derivative(Quantity::of_body(0, what), 0).unwrap());
    near(s, 1.0, ROUNDING);
    near(v, 0.0, ROUNDING);
}

#[test]
fn second_method_derivatives_through_a_rounded_reading_by_differences() {
    // A change of 1e-8 does not move any reading to another multiple; a difference has an error of
    // 1e-16 of the coordinate divided by 1e-8.
    let names = ["body.cart.start.v", "block.pd.d[0][0]", "block.pd.quantum.cart.s", "load.motor.factor"];
    check_derivatives(&encoder("0.0137"), &names, 0.2, &["cart.s", "cart.v"], 1e-8, 1e-6);
}

#[test]
fn closed_form_a_reading_halfway_between_two_multiples_has_no_derivative() {
    let motion = by_place(&encoder("0.0125"));
    let lost = motion.lost(0).unwrap();
    assert_eq!((lost.time, &lost.element[..], lost.cause), (0.0, "block.pd", Cause::Limit));
}
