//! The loop over hops and tiles: the light of a source to the sensor.

use std::time::Instant;

use rayon::prelude::*;

use crate::engine::local_bands::account::HopAccount;
use crate::engine::local_bands::emission::{Emission, Emitted};
use crate::engine::local_bands::held_light::{ArrivingLight, HeldBeamlets};
use crate::engine::local_bands::settings::{LocalBandSettings, SOURCE_STEP, SourceOpening};
use crate::engine::local_bands::source_windows::SourceWindows;
use crate::engine::local_bands::target::Target;
use crate::engine::local_bands::tile_plan::TileRun;
use crate::optics::screen::{Act, Screen, Sensor};
use crate::optics::system::{Hop, System};
use crate::wave::beamlet::beamlet_sum::Canvas;
use crate::wave::beamlet::wavelet::Arrival;
use crate::wave::grid::field::{Axis, Field, Grid};
use crate::wave::grid::raster::Raster;
use crate::wave::local_bands::element_samples::Element;
use crate::wave::local_bands::tiling::{Tile, Tiling, WindowShape};

/// Why local bands cannot carry the light of a system.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum LocalBandError {
    /// A screen has no edge.
    #[error("screen '{0}' has no edge; give its element an aperture")]
    Boundless(String),
    /// A screen is curved.
    #[error("screen '{0}' is curved; local bands need plane screens")]
    Curved(String),
    /// An element has layers that are neither phases nor pixels of one lattice.
    #[error("the layers of screen '{0}' are not all phases and pixels of one lattice")]
    Layers(String),
    /// No width of windows is given for a screen.
    #[error("no width of windows is given for screen '{0}'")]
    NoWidth(String),
    /// The last screen is no sensor.
    #[error("the last screen is no sensor")]
    NoSensor,
    /// Nothing is left of the light.
    #[error("no light reaches screen '{0}'")]
    NoLight(String),
}

/// What one hop did.
#[derive(Clone, Debug)]
pub struct LocalBandHop {
    /// Names of its screens.
    pub screens: [String; 2],
    /// Counts and energies.
    pub account: HopAccount,
    /// Bytes of the beamlets that are held while it runs: those that arrived and those that leave.
    pub held: usize,
    /// Seconds it took.
    pub seconds: f64,
}

/// The field on the sensor, and what each hop did.
#[derive(Clone, Debug)]
pub struct LocalBandOutcome {
    /// Complex field at the sensor's pixel centres.
    pub field: Field,
    /// The hops.
    pub hops: Vec<LocalBandHop>,
}

/// How far beyond an opening light is wanted, in σ of its windows: the sinc sums of its edge need it.
const MARGIN: f64 = 2.5;

/// Beamlets of a smooth source end at this share of the threshold: each of them counts in full.
const SOURCE_EDGE: f64 = 0.1;

/// Tiles that are worked on between two sums.
const CHUNK: usize = 64;

/// Tiles from which the light that reaches the target is estimated.
const SAMPLE: usize = 32;

/// Carries the light of a system of plane screens to its sensor.
///
/// # Errors
/// When a screen is curved or has no edge, an element has layers of another kind, a width is missing, the last screen is
/// no sensor, or no light is left.
pub fn carry(
    system: &System,
    settings: &LocalBandSettings,
) -> Result<LocalBandOutcome, LocalBandError> {
    let Some(Act::Sensor(sensor)) = system.screens.last().map(|screen| &screen.act) else {
        return Err(LocalBandError::NoSensor);
    };
    let k = system.wavenumber();
    let first = system.screens.first().ok_or(LocalBandError::NoSensor)?;
    let mut light = ArrivingLight::Source(&system.source, first, k);
    let mut canvas = Canvas::new(Raster::of(sensor));
    let mut hops = Vec::new();
    for (number, hop) in system.hops().enumerate() {
        let clock = Instant::now();
        let step = HopStep::new(system, settings, number, hop)?;
        let (account, tiles) = step.carry(&light, &mut canvas);
        if account.beamlets == 0 {
            return Err(LocalBandError::NoLight(hop.to.name.clone()));
        }
        let next = HeldBeamlets::new(tiles.into_iter(), k, step.target.edge);
        hops.push(LocalBandHop {
            screens: [hop.from.name.clone(), hop.to.name.clone()],
            account,
            held: (light.held() + next.count()) * size_of::<Arrival>(),
            seconds: clock.elapsed().as_secs_f64(),
        });
        light = ArrivingLight::Beamlets(next);
    }
    let field = Field {
        grid: sensor_grid(sensor),
        values: canvas.finish(),
    };
    Ok(LocalBandOutcome { field, hops })
}

/// One hop, ready to run.
struct HopStep<'a> {
    system: &'a System,
    settings: &'a LocalBandSettings,
    hop: Hop<'a>,
    /// What stands on its first screen; nothing where a smooth source has one beamlet a window.
    element: Option<Element<'a>>,
    shape: WindowShape,
    tiling: Tiling,
    target: Target,
}

impl<'a> HopStep<'a> {
    fn new(
        system: &'a System,
        settings: &'a LocalBandSettings,
        number: usize,
        hop: Hop<'a>,
    ) -> Result<Self, LocalBandError> {
        for screen in [hop.from, hop.to] {
            if !screen.is_plane() {
                return Err(LocalBandError::Curved(screen.name.clone()));
            }
        }
        let missing = |screen: &Screen| LocalBandError::NoWidth(screen.name.clone());
        let boundless = |screen: &Screen| LocalBandError::Boundless(screen.name.clone());
        let mut shape = settings.windows(number).ok_or_else(|| missing(hop.from))?;
        let margin = match settings.windows(number + 1) {
            Some(next) => MARGIN * next.sigma,
            None if matches!(hop.to.act, Act::Sensor(_)) => 0.0,
            None => return Err(missing(hop.to)),
        };
        let stop = matches!(hop.from.act, Act::Stop(_));
        let soft = number == 0 && stop && settings.opening == SourceOpening::Soft;
        let mut edge = settings.threshold;
        let element = if soft {
            shape.step = SOURCE_STEP;
            edge *= SOURCE_EDGE;
            None
        } else {
            let layers = || LocalBandError::Layers(hop.from.name.clone());
            Some(Element::of(hop.from).ok_or_else(layers)?)
        };
        let bounds = hop.from.bounds().ok_or_else(|| boundless(hop.from))?;
        Ok(Self {
            system,
            settings,
            hop,
            element,
            shape,
            tiling: Tiling::over(bounds, shape, settings.tile),
            target: Target::of(hop.to, margin, edge).ok_or_else(|| boundless(hop.to))?,
        })
    }

    /// Carries the light over the hop: to the canvas where it ends at the sensor, otherwise tile by tile.
    fn carry(&self, light: &ArrivingLight, canvas: &mut Canvas) -> (HopAccount, Vec<Vec<Arrival>>) {
        let Some(element) = &self.element else {
            let windows = SourceWindows {
                source: &self.system.source,
                hop: &self.hop,
                target: &self.target,
                tiling: &self.tiling,
                corrected: self.settings.corrected,
            };
            return self.each_tile(canvas, |tile| windows.tile(tile));
        };
        let run = TileRun {
            hop: &self.hop,
            light,
            element,
            tiling: &self.tiling,
            shape: self.shape,
            target: &self.target,
            settings: self.settings,
        };
        let emission = Emission {
            hop: &self.hop,
            target: &self.target,
            weakest: self.settings.threshold * run.strongest() * self.usual(&run),
            unit: run.unit(),
            corrected: self.settings.corrected,
        };
        self.each_tile(canvas, |tile| run.send(tile, &emission))
    }

    /// Root mean square, over a sample of the windows, of the light that may reach the target.
    fn usual(&self, run: &TileRun) -> f64 {
        let mut tiles = self.tiling.tiles();
        tiles.retain(|tile| !self.tiling.lit(tile, run.element.opening()).is_empty());
        let stride = tiles.len().div_ceil(SAMPLE).max(1);
        let sample: Vec<&Tile> = tiles.iter().skip(stride / 2).step_by(stride).collect();
        let found: Vec<[f64; 2]> = sample
            .into_par_iter()
            .map(|tile| run.energy(tile))
            .collect();
        let sum = |a: usize| found.iter().map(|found| found[a]).sum::<f64>();
        (sum(0) / sum(1).max(1.0)).sqrt()
    }

    /// Works on all tiles, some at a time; what they send is added in their order.
    fn each_tile(
        &self,
        canvas: &mut Canvas,
        send: impl Fn(&Tile) -> Emitted + Sync,
    ) -> (HopAccount, Vec<Vec<Arrival>>) {
        let k = self.hop.wavenumber();
        let ends = matches!(self.hop.to.act, Act::Sensor(_));
        let (mut account, mut tiles) = (HopAccount::default(), Vec::new());
        for chunk in self.tiling.tiles().chunks(CHUNK) {
            let sent: Vec<Emitted> = chunk.par_iter().map(&send).collect();
            for mut emitted in sent {
                account.add(&emitted.account);
                if ends {
                    canvas.add(&emitted.arrivals, k, self.target.edge);
                } else {
                    emitted.arrivals.shrink_to_fit();
                    tiles.push(emitted.arrivals);
                }
            }
        }
        (account, tiles)
    }
}

/// The pixel centres of a sensor.
fn sensor_grid(sensor: &Sensor) -> Grid {
    let axis = |a: usize| Axis::uniform(sensor.pixels[a], sensor.pitch[a], 0.0);
    Grid {
        x: axis(0),
        y: axis(1),
    }
}

#[cfg(test)]
mod tests {
    use num_complex::Complex64;

    use crate::engine::local_bands::carry::{LocalBandError, carry};
    use crate::engine::local_bands::settings::{LocalBandSettings, SourceOpening};
    use crate::fixtures::parts::{conic, element, on_axis, plane_wave, screen, sensor};
    use crate::optics::aperture::Aperture;
    use crate::optics::doe::Layer;
    use crate::optics::frame::Frame;
    use crate::optics::profile::Profile;
    use crate::optics::screen::{Act, Screen};
    use crate::optics::system::System;
    use crate::wave::free::rayleigh::Emitters;
    use crate::wave::grid::field::{Axis, Field, Grid};
    use crate::wave::grid::heights::Heights;
    use crate::wave::grid::sampling::act;

    const RADIUS: f64 = 0.3;
    const DISTANCE: f64 = 20.0;

    /// A lens and a vortex in a hard opening, under tilted light, and a sensor in its focus.
    fn vortex() -> System {
        let wavelength = 0.5e-3;
        let lens = Profile::Lens {
            focal_length: DISTANCE,
            wavenumber: std::f64::consts::TAU / wavelength,
        };
        let mut doe = element(Layer::Phase(lens), Aperture::disc(RADIUS));
        doe.layers.push(Layer::Phase(Profile::Vortex { charge: 1 }));
        System {
            wavelength,
            source: plane_wave([0.003, -0.002]),
            screens: vec![
                screen(Frame::GLOBAL, Act::Doe(doe)),
                screen(on_axis(DISTANCE), sensor(24, 8e-3)),
            ],
            trains: vec![Vec::new()],
        }
    }

    /// The direct sum over the opening.
    fn summed(system: &System) -> Vec<Complex64> {
        let axis = Axis::gauss(60, 2.0 * RADIUS / 60.0, 0.0, 6);
        let mut field = Field::zeros(Grid {
            x: axis.clone(),
            y: axis.clone(),
        });
        let k = system.wavenumber();
        for ((j, i), value) in field.values.indexed_iter_mut() {
            *value = Complex64::cis(k * (0.003 * axis.node(i) - 0.002 * axis.node(j)));
        }
        act(&system.screens[0], &mut field);
        let place = |i: usize| (i as f64 - 11.5) * 8e-3;
        let points: Vec<[f64; 3]> = (0..24 * 24)
            .map(|n| [place(n % 24), place(n / 24), DISTANCE])
            .collect();
        Emitters::new(&field, &Heights::flat(&field.grid)).shine(&points, system.wavelength)
    }

    #[test]
    fn a_vortex_in_a_hard_opening_agrees_with_the_direct_sum() {
        let system = vortex();
        let exact = summed(&system);
        let norm: f64 = exact.iter().map(|u| u.norm_sqr()).sum();
        for sigma in [0.02, 0.04] {
            let settings = LocalBandSettings {
                opening: SourceOpening::Hard,
                ..LocalBandSettings::new(vec![sigma])
            };
            let outcome = carry(&system, &settings).unwrap();
            let pairs = outcome.field.values.iter().zip(&exact);
            let off: f64 = pairs.map(|(a, b)| (a - b).norm_sqr()).sum();
            let error = (off / norm).sqrt();
            assert!(error < 2e-3, "σ {sigma}: {error:e}");
        }
    }

    #[test]
    fn any_number_of_threads_gives_the_same_bits() {
        let run = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
            let settings = LocalBandSettings::new(vec![0.03]);
            let run = || carry(&vortex(), &settings).unwrap().field.values;
            pool.build().unwrap().install(run)
        };
        assert_eq!(run(1), run(3));
    }

    #[test]
    fn what_cannot_be_carried_is_refused_by_name() {
        let settings = LocalBandSettings::new(vec![0.03]);
        let refused = |system: &System| carry(system, &settings).unwrap_err();
        let mut system = vortex();
        system.screens[1].shape = conic(0.1, 0.0);
        assert_eq!(refused(&system), LocalBandError::Curved("sensor".into()));
        let mut system = vortex();
        let open: Screen = screen(on_axis(3.0), Act::Stop(Aperture::disc(1.0)));
        system.screens.insert(1, open);
        system.trains.push(Vec::new());
        assert_eq!(refused(&system), LocalBandError::NoWidth("stop".into()));
        system.screens.truncate(2);
        system.trains.truncate(1);
        assert_eq!(refused(&system), LocalBandError::NoSensor);
        let mut system = vortex();
        system.screens[0].act = Act::Stop(Aperture::OPEN);
        assert_eq!(
            refused(&system),
            LocalBandError::Boundless("element".into())
        );
    }
}
