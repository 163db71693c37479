//! How the light on a screen changes with a parameter of the system: through its source, and through its element.
//!
//! The forward steps are in [`crate::engine::chain::arriving_light`] and [`crate::wave::grid::sampling`]; the derivatives are
//! differences between two perturbed systems.

use crate::engine::chain::arriving_light::illuminate;
use crate::engine::trace::complex_rate::pull_rate;
use crate::engine::trace::ray_sensitivity::Variation;
use crate::optics::screen::Screen;
use crate::optics::system::System;
use crate::wave::grid::field::Field;
use crate::wave::grid::sampling::apply_screen;

/// The whole fields of a run on one screen, before and behind it.
#[derive(Clone, Debug)]
pub struct ScreenFields {
    /// The field that arrived, at the nodes.
    pub arrived: Field,
    /// The field behind the screen.
    pub behind: Field,
}

/// The derivative that the light of the source brings on the first screen, when that or the source moves.
pub(crate) fn pull_light(variation: &Variation, passed: &ScreenFields, arrived_bar: &Field) -> f64 {
    let (below, above) = (&variation.below, &variation.above);
    if !variation.moves_light() {
        return 0.0;
    }
    let light = |system: &System| illuminate(system, passed.arrived.grid.clone());
    pull_rate(
        [&light(below).values, &light(above).values],
        &passed.arrived.values,
        &arrived_bar.values,
        variation.distance,
    )
}

/// The derivative that an element brings whose transmission changes.
pub(crate) fn pull_act(
    variation: &Variation,
    number: usize,
    passed: &ScreenFields,
    behind_bar: &Field,
) -> f64 {
    let [below, above] = [&variation.below, &variation.above].map(|s| &s.screens[number]);
    if below.kind == above.kind {
        return 0.0;
    }
    let behind = |screen: &Screen| {
        let mut field = passed.arrived.clone();
        apply_screen(screen, &mut field);
        field
    };
    pull_rate(
        [&behind(below).values, &behind(above).values],
        &passed.behind.values,
        &behind_bar.values,
        variation.distance,
    )
}
