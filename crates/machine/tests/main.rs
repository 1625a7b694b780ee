//! Motions, derivatives and laws of described machines in one program, so that the engine is
//! linked once. `cargo test -p vibro-machine --test motions closed_forms` runs the tests of one
//! file.

mod accounts;
mod blocks;
mod blocks_rest;
mod box_cone;
mod closed_forms;
mod common;
mod contacts;
mod course;
mod curved;
mod curves_rest;
mod dampers;
mod derivatives;
mod derivatives_adjoint;
mod derivatives_digits;
mod derivatives_extremes;
mod derivatives_named;
mod derivatives_none;
mod derivatives_random;
mod derivatives_rows;
mod derivatives_start;
mod derivatives_under_way;
mod follows;
mod formulas;
mod freewheel;
mod frictional;
mod gallery;
mod gallery_contacts;
mod held_exactly;
mod held_force;
mod instants;
mod jumps;
mod known_figures;
mod ladder;
mod limits;
mod lone_events;
mod many;
mod matrix;
mod metamorphic;
mod modal;
mod paper;
mod pauses;
mod points;
mod points_rest;
mod powers;
mod prescribed;
mod quantum;
mod random;
mod residual;
mod rest;
mod rounding;
mod rubbing;
mod second_method;
mod series;
mod signals_hold;
mod signals_motion;
mod signals_repeat;
mod signals_sweep;
mod sliders;
mod starts;
mod stepped;
mod stiff;
mod stop_laws;
mod table_memory;
mod variations;

/// Every file next to this one is a module of this program, or a separate program.
#[test]
fn invariant_every_file_is_run() {
    const OWN: [&str; 2] = ["main.rs", "allocation.rs"];
    let here = include_str!("main.rs");
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("tests");
    for entry in std::fs::read_dir(folder).unwrap() {
        let name = entry.unwrap().file_name().into_string().unwrap();
        let Some(module) = name.strip_suffix(".rs") else { continue };
        let named = here.lines().any(|line| line == format!("mod {module};"));
        assert!(named || OWN.contains(&name.as_str()), "{name} is not run");
    }
}
