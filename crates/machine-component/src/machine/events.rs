//! Events in words.

use fmi_doors::log::{Category, Log};
use vibro_machine::Assembly;
use vibro_machine::motion::{Event, EventKind};

/// Logs an event if this is requested. Samples are left out, as there may be thousands a second.
pub(super) fn tell(machine: &Assembly, event: &Event, log: &mut dyn Log) {
    if event.is_listed() && log.wants(Category::Events) {
        log.log(Category::Events, &in_words(machine, event));
    }
}

fn in_words(machine: &Assembly, event: &Event) -> String {
    let stop = |i: usize| machine.name_of_stop(i);
    let friction = |i: usize| machine.name_of_friction(i);
    let output = |block: usize, output: usize| machine.description.name_of_output((block, output));
    let text = match event.kind {
        EventKind::Impact { stop: i, speed, impulse, .. } => {
            format!("{} is hit, closing with {speed} (SI), impulse {impulse} (SI)", stop(i))
        }
        EventKind::Close { stop: i } => format!("{} closes", stop(i)),
        EventKind::Open { stop: i } => format!("{} opens", stop(i)),
        EventKind::Press { stop: i, speed } => format!("{} is pressed, closing with {speed} (SI)", stop(i)),
        EventKind::Free { stop: i, .. } => format!("{} is free", stop(i)),
        EventKind::Cap { stop: i, acts } => {
            format!(
                "{} {}",
                stop(i),
                if acts { "comes to its dashpot's cap" } else { "leaves its dashpot's cap" }
            )
        }
        EventKind::Corner { corner, rate } => {
            format!("{} passes a corner with {rate} (SI)", stop(corner))
        }
        EventKind::Stick { friction: i } => format!("{} sticks", friction(i)),
        EventKind::Slip { friction: i, direction, .. } => {
            format!("{} slips {}", friction(i), if direction > 0.0 { "upwards" } else { "downwards" })
        }
        EventKind::Level { friction: i, acts } => {
            format!("{} {}", friction(i), if acts { "acts" } else { "no longer acts" })
        }
        EventKind::Yield { slider: i, direction, .. } => {
            let direction = if direction > 0.0 { "upwards" } else { "downwards" };
            format!("{} slips {direction}", machine.name_of_branch(i))
        }
        EventKind::Hold { slider: i, .. } => format!("{} sticks", machine.name_of_branch(i)),
        EventKind::Knot => "a signal's knot".into(),
        EventKind::Limit { block, output: own, side, .. } if side != 0.0 => {
            format!(
                "{} comes to its {} limit",
                output(block, own),
                if side > 0.0 { "upper" } else { "lower" }
            )
        }
        EventKind::Limit { block, output: own, .. } => format!("{} leaves its limit", output(block, own)),
        EventKind::Sample { action } => {
            format!("block.{} is sampled", machine.description.blocks[action.block].name)
        }
    };
    format!("{text} at t = {} s", event.time)
}
