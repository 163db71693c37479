//! How the light on a screen changes with a number of the system: through its source, and through its element.
//!
//! The forward steps are in [`crate::engine::chain::simulate`] and [`crate::wave::grid::sampling`]; the derivatives are
//! differences between two perturbed systems.

use num_complex::Complex64;

use crate::engine::chain::arriving_light::illuminate;
use crate::engine::trace::ray_sensitivity::Variation;
use crate::optics::screen::Screen;
use crate::optics::system::System;
use crate::wave::grid::field::Field;
use crate::wave::grid::sampling::act;

/// What a run leaves on one screen.
#[derive(Clone, Debug)]
pub struct ScreenFields {
    /// The field that arrived, at the nodes.
    pub arrived: Field,
    /// The field behind the screen.
    pub behind: Field,
}

/// d(value)/dq from the values a little below and above: through the logarithm, whose steps a phase makes
/// evenly, unless one of them is dark.
fn rate(below: Complex64, here: Complex64, above: Complex64, distance: f64) -> Complex64 {
    if below == Complex64::ZERO || above == Complex64::ZERO {
        return (above - below) / distance;
    }
    here * (above / below).ln() / distance
}

/// The derivative that the light of the source brings on the first screen, when that or the source moves.
pub(crate) fn pull_light(variation: &Variation, passed: &ScreenFields, arrived_bar: &Field) -> f64 {
    let (below, above) = (&variation.below, &variation.above);
    let still = below.source == above.source
        && below.screens[0].frame == above.screens[0].frame
        && below.screens[0].index == above.screens[0].index;
    if still {
        return 0.0;
    }
    let light = |system: &System| illuminate(system, passed.arrived.grid.clone());
    pull_rate(
        [light(below), light(above)],
        &passed.arrived,
        arrived_bar,
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
    if below.act == above.act {
        return 0.0;
    }
    let behind = |screen: &Screen| {
        let mut field = passed.arrived.clone();
        act(screen, &mut field);
        field
    };
    pull_rate(
        [behind(below), behind(above)],
        &passed.behind,
        behind_bar,
        variation.distance,
    )
}

/// Re Σ bar*·d(field)/dq.
fn pull_rate([below, above]: [Field; 2], here: &Field, bar: &Field, distance: f64) -> f64 {
    let terms = below.values.iter().zip(&above.values);
    let terms = terms.zip(here.values.iter().zip(&bar.values));
    let each =
        |((below, above), (here, bar)): ((&Complex64, &Complex64), (&Complex64, &Complex64))| {
            (bar.conj() * rate(*below, *here, *above, distance)).re
        };
    terms.map(each).sum()
}
