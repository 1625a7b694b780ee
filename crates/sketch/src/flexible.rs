//! Bodies with several coordinates, drawn as one box each.

use std::collections::HashMap;
use vibro_machine::Description;
use vibro_machine::description::{Arms, Body, BodyKind, Dimension, Free};
use vibro_numerics::sorting::sort_by_key;

/// The machine with each body of several coordinates and nodes replaced by one body. An element
/// between two nodes of the same body is left out.
pub(crate) fn drawn(machine: &Description) -> Description {
    let mut drawn = machine.clone();
    if !machine.bodies.iter().any(Body::is_inner) {
        return drawn;
    }
    drawn.bodies.clear();
    let (mut place_of, mut of_name) = (Vec::new(), HashMap::new());
    for body in &machine.bodies {
        let is_part = body.is_inner() || matches!(body.kind, BodyKind::Node(_));
        let name = if is_part { body.name.split('.').next().unwrap_or_default() } else { &body.name };
        let place = *of_name.entry((is_part, name)).or_insert(drawn.bodies.len());
        if place == drawn.bodies.len() {
            let free = BodyKind::Free(Free { inertia: 1.0, gravity: 0.0, s: 0.0, v: 0.0 });
            drawn.bodies.push(match is_part {
                true => Body { name: name.into(), dimension: Dimension::Translation, kind: free },
                false => body.clone(),
            });
        }
        place_of.push(place);
    }
    let moved = |arms: &mut Arms| {
        arms.terms.iter_mut().for_each(|term| term.0 = place_of[term.0]);
        let several = arms.terms.len() > 1;
        sort_by_key(&mut arms.terms, |term| term.0);
        arms.terms.dedup_by_key(|term| term.0);
        !several || arms.terms.len() > 1
    };
    // Without `..`, so that a new kind of element is a compile error until its arms are moved.
    let Description {
        springs,
        dampers,
        stops,
        frictions,
        contacts,
        freewheels,
        links,
        loads,
        name: _,
        gravity: _,
        starts_at_rest: _,
        bodies: _,
        modals: _,
        matrices: _,
        sources: _,
        blocks: _,
        feeds: _,
        named: _,
    } = &mut drawn;
    springs.retain_mut(|own| moved(&mut own.arms));
    dampers.retain_mut(|own| moved(&mut own.arms));
    stops.retain_mut(|own| moved(&mut own.arms));
    frictions.retain_mut(|own| moved(&mut own.arms));
    contacts.retain_mut(|own| {
        own.tangents.retain_mut(|tangent| moved(&mut tangent.arms));
        moved(&mut own.normal)
    });
    freewheels.retain_mut(|own| moved(&mut own.arms));
    links.retain_mut(|own| moved(&mut own.arms));
    loads.iter_mut().for_each(|load| load.body = place_of[load.body]);
    drawn
}
