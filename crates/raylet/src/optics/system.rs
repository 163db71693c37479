//! A whole optical system at one wavelength: screens joined by trains of surfaces.

use crate::optics::aperture::Aperture;
use crate::optics::screen::{Screen, ScreenKind};
use crate::optics::source::Source;
use crate::optics::surface::{Surface, without_edges};

/// Screens joined by trains; flat and immutable.
///
/// `trains[i]` leads from `screens[i]` to `screens[i + 1]`, so there is one train fewer than screens.
/// The last screen is the sensor.
#[derive(Clone, Debug, PartialEq)]
pub struct System {
    /// Vacuum wavelength in mm.
    pub wavelength: f64,
    /// What lights the first screen.
    pub source: Source,
    /// The screens, in the order light meets them.
    pub screens: Vec<Screen>,
    /// The ordinary surfaces between neighbouring screens; a train may be empty.
    pub trains: Vec<Vec<Surface>>,
}

/// One step of a system: from a screen through a train to the next screen.
#[derive(Clone, Copy, Debug)]
pub struct Hop<'a> {
    /// Vacuum wavelength in mm.
    pub wavelength: f64,
    /// Where the field is known.
    pub from: &'a Screen,
    /// The surfaces between.
    pub train: &'a [Surface],
    /// Where the field is computed.
    pub to: &'a Screen,
}

impl System {
    /// The same system without the edges of its elements, stops and surfaces.
    pub(crate) fn without_edges(&self) -> Self {
        let mut open = self.clone();
        for screen in &mut open.screens {
            match &mut screen.kind {
                ScreenKind::Stop(aperture) => *aperture = Aperture::OPEN,
                ScreenKind::Doe(doe) => doe.aperture = Aperture::OPEN,
                ScreenKind::Sensor(_) => {}
            }
        }
        for train in &mut open.trains {
            *train = without_edges(train);
        }
        open
    }

    /// Power for |U|² = 1 in a medium of this index, relative to the ambient medium.
    pub(crate) fn power_in(&self, index: f64) -> f64 {
        index / self.screens.first().map_or(index, |first| first.index)
    }

    /// The power before the first screen of a hop, behind it and on the second, from ∫|U|² there.
    pub(crate) fn power_along(&self, hop: &Hop, squares: [f64; 3]) -> [Option<f64>; 3] {
        let indices = [hop.from.index, hop.from.index_behind(), hop.to.index];
        std::array::from_fn(|i| Some(squares[i] * self.power_in(indices[i])))
    }

    /// The hops, first to last.
    pub fn hops(&self) -> impl Iterator<Item = Hop<'_>> {
        self.trains
            .iter()
            .zip(self.screens.windows(2))
            .map(|(train, pair)| Hop {
                wavelength: self.wavelength,
                from: &pair[0],
                train,
                to: &pair[1],
            })
    }

    /// Vacuum wavenumber 2π/λ in rad/mm.
    pub fn wavenumber(&self) -> f64 {
        std::f64::consts::TAU / self.wavelength
    }
}

impl Hop<'_> {
    /// Whether rays run alike in another hop: places, shapes and media are the same.
    pub(crate) fn is_same(&self, other: &Hop) -> bool {
        let media = |a: &Screen, b: &Screen| a.index == b.index && a.behind == b.behind;
        let alike =
            |a: &Screen, b: &Screen| a.frame == b.frame && a.shape == b.shape && media(a, b);
        alike(self.from, other.from) && alike(self.to, other.to) && self.train == other.train
    }

    /// Vacuum wavenumber 2π/λ in rad/mm.
    pub fn wavenumber(&self) -> f64 {
        std::f64::consts::TAU / self.wavelength
    }
}
