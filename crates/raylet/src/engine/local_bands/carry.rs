//! The loop over hops: the light of a source to the sensor, and cotangents back to the pixels of elements.

use std::ops::ControlFlow;
use std::time::Instant;

use ndarray::Array2;
use num_complex::Complex64;

use crate::engine::error::hop_statistics::HopStatistics;
use crate::engine::local_bands::held_light::{ArrivingLight, HeldBeamlets};
use crate::engine::local_bands::hop_changes::HopChanges;
use crate::engine::local_bands::hop_cotangents::{Back, Bars};
use crate::engine::local_bands::hop_step::{HopStep, Work};
use crate::engine::local_bands::local_band_error::LocalBandError;
use crate::engine::local_bands::settings::{LocalBandPlan, LocalBandSettings};
use crate::engine::progress::{Pulse, uncancelled};
use crate::engine::trace::ray_sensitivity::Variation;
use crate::optics::screen::ScreenKind;
use crate::optics::system::{Hop, System};
use crate::wave::beamlet::beamlet_kernel::Moments;
use crate::wave::beamlet::direction_sectors::{SectorBar, SectorSum};
use crate::wave::beamlet::wavelet::Arrival;
use crate::wave::grid::field::{Field, Grid};
use crate::wave::grid::raster::Raster;

/// The report on one hop of a run.
#[derive(Clone, Debug)]
pub struct LocalBandHop {
    /// Names of its screens.
    pub screens: [String; 2],
    /// The width, distance and number of its windows.
    pub plan: LocalBandPlan,
    /// Counts and energies.
    pub statistics: HopStatistics,
    /// Bytes of the beamlets that are held while it runs: those that arrived and those that leave.
    pub held: usize,
    /// Seconds it took.
    pub seconds: f64,
}

/// How far a run has come.
#[derive(Clone, Copy, Debug)]
pub struct LocalBandProgress {
    /// Index of the hop.
    pub hop: usize,
    /// Share of its tiles that are done, 0 to 1.
    pub done: f64,
}

/// The field on the sensor, and what each hop did.
#[derive(Clone, Debug)]
pub struct LocalBandOutcome {
    /// Complex field at the sensor's pixel centres.
    pub field: Field,
    /// The hops.
    pub hops: Vec<LocalBandHop>,
}

/// The record of a hop that has run, for the adjoint.
#[derive(Clone, Debug)]
pub struct KeptHop {
    /// The beamlets that arrived at its first screen; nothing where the source lights it.
    arrived: Option<HeldBeamlets>,
    weakest: f64,
}

/// The gradient of a loss L by the pixels and parameters of a system.
#[derive(Clone, Debug)]
pub struct LocalBandGradient {
    /// For each screen but the last the cotangent of the pixels of its element, [y, x]; `None` where it has no pixels.
    pub pixels: Vec<Option<Array2<Complex64>>>,
    /// ∂L/∂q for each parameter q, in one over the unit of q.
    pub parameters: Vec<f64>,
}

/// The input of the adjoint: the cotangent of the field on the sensor, and the parameters.
#[derive(Clone, Copy)]
pub struct LocalBandCotangent<'a> {
    /// ∂L/∂Re U + i ∂L/∂Im U at the sensor's pixel centres.
    pub field: &'a Field,
    /// The parameters: perturbed systems of the same screens and surfaces.
    pub variations: &'a [Variation],
    /// Called after each chunk of work.
    pub pulse: &'a Pulse<'a>,
}

/// Carries the light of a system to its sensor.
///
/// # Errors
/// When a screen has no edge or reflects into another medium, an element has layers of another kind, a width is
/// missing, the last screen is no sensor, or no light is left.
pub fn carry(
    system: &System,
    settings: &LocalBandSettings,
) -> Result<LocalBandOutcome, LocalBandError> {
    carry_with(system, settings, &|_| uncancelled())
}

/// [`carry`] with progress: `progress` is called after each chunk of work.
///
/// # Errors
/// As [`carry`]; when `progress` cancels the run.
pub(crate) fn carry_with(
    system: &System,
    settings: &LocalBandSettings,
    progress: &(dyn Fn(&LocalBandProgress) -> ControlFlow<()> + Sync),
) -> Result<LocalBandOutcome, LocalBandError> {
    run_hops(system, settings, progress, Keep::Latest, drop)
}

/// [`carry`] that also returns the record for the adjoint: the beamlets on all screens, hop by hop.
///
/// # Errors
/// As [`carry`]; when `progress` cancels the run.
pub fn carry_kept(
    system: &System,
    settings: &LocalBandSettings,
    progress: &(dyn Fn(&LocalBandProgress) -> ControlFlow<()> + Sync),
) -> Result<(LocalBandOutcome, Vec<KeptHop>), LocalBandError> {
    let mut kept = Vec::new();
    let outcome = run_hops(system, settings, progress, Keep::All, |hop| kept.push(hop))?;
    Ok((outcome, kept))
}

/// The windows of each hop.
///
/// # Errors
/// As [`carry`], except that light which does not arrive is no error.
pub(crate) fn planned(
    system: &System,
    settings: &LocalBandSettings,
) -> Result<Vec<LocalBandPlan>, LocalBandError> {
    let hops = system.hops().enumerate();
    hops.map(|(number, hop)| Ok(HopStep::new(system, settings, number, hop)?.plan()))
        .collect()
}

/// The gradient of a real function of the field on the sensor, from its cotangent there: of a run whose carriers, plane
/// waves and corrections are held constant. With respect to pixels it is the conjugate transpose of [`carry_kept`].
///
/// # Errors
/// As [`carry`]; when the pulse cancels the work.
pub fn carry_kept_adjoint(
    system: &System,
    settings: &LocalBandSettings,
    kept: &[KeptHop],
    back: &LocalBandCotangent,
) -> Result<LocalBandGradient, LocalBandError> {
    let hops: Vec<Hop> = system.hops().collect();
    let mut gradient = LocalBandGradient {
        pixels: vec![None; hops.len()],
        parameters: vec![0.0; back.variations.len()],
    };
    let bar = SectorBar::new(raster_of(&back.field.grid), &back.field.values);
    let mut sent: Option<(&HeldBeamlets, Vec<Moments>)> = None;
    for ((number, hop), kept) in hops.into_iter().enumerate().zip(kept).rev() {
        let through = Back {
            bars: match &sent {
                None => Bars::Sensor(&bar),
                Some((held, bars)) => Bars::Beamlets(held, bars),
            },
            changes: HopChanges::new(back.variations, number, hop)?,
            weakest: kept.weakest,
            pulse: back.pulse,
        };
        let step = HopStep::new(system, settings, number, hop)?;
        let light = arriving(system, &hop, kept.arrived.as_ref());
        let found = step.carry_adjoint(&light, &through)?;
        gradient.pixels[number] = found.pixels;
        let total = gradient.parameters.iter_mut();
        total
            .zip(found.parameters)
            .for_each(|(total, part)| *total += part);
        sent = kept.arrived.as_ref().map(|held| (held, found.arriving));
    }
    Ok(gradient)
}

/// The light that arrives at the first screen of a hop: beamlets, or that of the source.
fn arriving<'a>(
    system: &'a System,
    hop: &Hop<'a>,
    held: Option<&'a HeldBeamlets>,
) -> ArrivingLight<'a> {
    match held {
        Some(held) => ArrivingLight::Beamlets(held),
        None => ArrivingLight::Source(&system.source, hop.from, system.wavenumber()),
    }
}

/// Which beamlets are held.
#[derive(Clone, Copy, PartialEq)]
enum Keep {
    /// Those of one screen, until they are carried on.
    Latest,
    /// Those of all screens, for the adjoint.
    All,
}

impl Keep {
    /// Memory of a beamlet in bytes; where the adjoint follows, with the moments under it.
    fn bytes(self) -> usize {
        match self {
            Self::Latest => size_of::<Arrival>(),
            Self::All => size_of::<Arrival>() + size_of::<Moments>(),
        }
    }
}

/// Runs the hops one after another, each handed over when the next has its light.
fn run_hops(
    system: &System,
    settings: &LocalBandSettings,
    progress: &(dyn Fn(&LocalBandProgress) -> ControlFlow<()> + Sync),
    keep: Keep,
    mut done: impl FnMut(KeptHop),
) -> Result<LocalBandOutcome, LocalBandError> {
    let Some(ScreenKind::Sensor(sensor)) = system.screens.last().map(|screen| &screen.kind) else {
        return Err(LocalBandError::NoSensor);
    };
    let k = system.wavenumber();
    let (mut held, mut passed): (Option<HeldBeamlets>, usize) = (None, 0);
    let mut sum = SectorSum::new(Raster::of(sensor));
    let mut hops = Vec::new();
    let mut passing = (keep == Keep::Latest).then(Vec::new);
    for (number, hop) in system.hops().enumerate() {
        let clock = Instant::now();
        let mut step = HopStep::new(system, settings, number, hop)?;
        if passing.as_ref().is_some_and(|tiles| !tiles.is_empty()) {
            step.widen_footprints();
        }
        let light = arriving(system, &hop, held.as_ref());
        let here = |share: f64| {
            progress(&LocalBandProgress {
                hop: number,
                done: share,
            })
        };
        let work = Work {
            sum: &mut sum,
            progress: &here,
            held: light.held() + if keep == Keep::All { passed } else { 0 },
            bytes: keep.bytes(),
            passing: passing.take(),
        };
        let sent = step.carry(&light, work)?;
        if sent.statistics.beamlets() == 0 {
            return Err(LocalBandError::NoLight(hop.to.name.clone()));
        }
        let next = HeldBeamlets::new(sent.tiles, k, step.target.edge);
        hops.push(LocalBandHop {
            screens: [hop.from.name.clone(), hop.to.name.clone()],
            plan: step.plan(),
            statistics: sent.statistics,
            held: (light.held() + next.count()) * size_of::<Arrival>(),
            seconds: clock.elapsed().as_secs_f64(),
        });
        passed += light.held();
        passing = (keep == Keep::Latest).then_some(sent.passing);
        done(KeptHop {
            arrived: held.replace(next),
            weakest: sent.weakest,
        });
    }
    let field = Field {
        grid: Grid::of(sensor),
        values: sum.finish(),
    };
    Ok(LocalBandOutcome { field, hops })
}

/// A uniform grid as a raster.
fn raster_of(grid: &Grid) -> Raster {
    Raster {
        start: [grid.x.start, grid.y.start],
        pitch: [grid.x.pitch, grid.y.pitch],
        size: [grid.x.cells, grid.y.cells],
    }
}

#[cfg(test)]
mod tests {
    use ndarray::Array2;
    use num_complex::Complex64;

    use crate::engine::local_bands::carry::{
        LocalBandCotangent, LocalBandOutcome, carry, carry_kept, carry_kept_adjoint,
    };
    use crate::engine::local_bands::local_band_error::LocalBandError;
    use crate::engine::local_bands::settings::{LocalBandSettings, SourceAperture};
    use crate::engine::progress::uncancelled;
    use crate::fixtures::noise::noise;
    use crate::fixtures::parts::{
        box_pixels, conic, element, face, lit, on_axis, pixel_layer, plane_wave, screen, sensor,
    };
    use crate::math::vec3::Vec3;
    use crate::optics::aperture::Aperture;
    use crate::optics::doe::Layer;
    use crate::optics::frame::Frame;
    use crate::optics::phase::profile::Profile;
    use crate::optics::pixels::pixel_grid::PixelForm;
    use crate::optics::refraction::Coating;
    use crate::optics::screen::{MediumBehind, Screen, ScreenKind};
    use crate::optics::system::System;
    use crate::wave::free::rayleigh::Emitters;
    use crate::wave::grid::field::{Axis, Field, Grid};
    use crate::wave::grid::heights::Heights;
    use crate::wave::grid::sampling::apply_screen;

    const RADIUS: f64 = 0.3;
    const DISTANCE: f64 = 20.0;

    /// A lens and a vortex in a hard aperture, under tilted light, and a sensor in its focus.
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
                screen(Frame::GLOBAL, ScreenKind::Doe(doe)),
                screen(on_axis(DISTANCE), sensor(24, 8e-3)),
            ],
            trains: vec![Vec::new()],
        }
    }

    /// The direct sum over the aperture.
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
        apply_screen(&system.screens[0], &mut field);
        let place = |i: usize| (i as f64 - 11.5) * 8e-3;
        let points: Vec<[f64; 3]> = (0..24 * 24)
            .map(|n| [place(n % 24), place(n / 24), DISTANCE])
            .collect();
        Emitters::new(&field, &Heights::flat(&field.grid)).field_at(&points, system.wavelength)
    }

    #[test]
    fn a_vortex_in_a_hard_aperture_agrees_with_the_direct_sum_slow() {
        let system = vortex();
        let exact = summed(&system);
        let norm: f64 = exact.iter().map(|u| u.norm_sqr()).sum();
        for sigma in [0.02, 0.04] {
            let settings = LocalBandSettings {
                aperture: SourceAperture::Hard,
                ..LocalBandSettings::new(vec![sigma])
            };
            let outcome = carry(&system, &settings).unwrap();
            let pairs = outcome.field.values.iter().zip(&exact);
            let off: f64 = pairs.map(|(a, b)| (a - b).norm_sqr()).sum();
            let error = (off / norm).sqrt();
            assert!(error < 2e-3, "σ {sigma}: {error:e}");
        }
    }

    /// Light of a smooth source that does not touch the edge of a bare aperture passes it as it is; windows there bring the same
    /// field, and far more beamlets.
    #[test]
    fn light_that_passes_an_aperture_needs_no_windows_there() {
        let stop =
            |z: f64, radius: f64| screen(on_axis(z), ScreenKind::Stop(Aperture::disc(radius)));
        let mut system = lit(
            vec![
                stop(0.0, 1.5),
                stop(5.0, 1.2),
                screen(on_axis(60.0), sensor(24, 0.08)),
            ],
            vec![vec![], vec![]],
        );
        system.wavelength = 0.5e-3;
        let settings = LocalBandSettings {
            dropped: Some(3e-4),
            threshold: 1e-3,
            ..LocalBandSettings::new(vec![0.03, 0.03])
        };
        let passed = carry(&system, &settings).unwrap();
        let (whole, _) = carry_kept(&system, &settings, &|_| uncancelled()).unwrap();
        let beamlets = |outcome: &LocalBandOutcome| outcome.hops[1].statistics.beamlets();
        assert!(4 * beamlets(&passed) < 3 * beamlets(&whole));
        let norm = |values: &Array2<Complex64>| values.iter().map(|v| v.norm_sqr()).sum::<f64>();
        let (passed, whole) = (passed.field.values, whole.field.values);
        let error = (norm(&(&passed - &whole)) / norm(&whole)).sqrt();
        assert!(error < 4e-4, "{error:e}");
    }

    #[test]
    fn any_number_of_threads_gives_the_same_bits_slow() {
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
        if let ScreenKind::Doe(doe) = &mut system.screens[0].kind {
            doe.reflect = true;
        }
        system.screens[0].behind = Some(MediumBehind {
            index: 1.5,
            coating: Coating::Ideal,
        });
        assert_eq!(refused(&system), LocalBandError::Mirror("element".into()));
        let mut system = vortex();
        let open: Screen = screen(on_axis(3.0), ScreenKind::Stop(Aperture::disc(1.0)));
        system.screens.insert(1, open);
        system.trains.push(Vec::new());
        assert_eq!(refused(&system), LocalBandError::NoWidth("stop".into()));
        system.screens.truncate(2);
        system.trains.truncate(1);
        assert_eq!(refused(&system), LocalBandError::NoSensor);
        let mut system = vortex();
        system.screens[0].kind = ScreenKind::Stop(Aperture::OPEN);
        assert_eq!(
            refused(&system),
            LocalBandError::Boundless("element".into())
        );
    }

    /// Pixels on two screens with a lens between them: the field is linear in the pixels of each.
    #[test]
    fn carry_kept_dot_product() {
        let pixels = |purpose: u32| noise((8, 7), purpose);
        let lens = vec![
            face(on_axis(2.0), conic(0.05, 0.0), [1.0, 1.5]),
            face(on_axis(3.0), conic(-0.03, 0.0), [1.5, 1.0]),
        ];
        let layer = pixel_layer(pixels(0), 0.02, PixelForm::Box);
        let round = element(layer, Aperture::disc(0.06));
        let system = System {
            wavelength: 0.5e-3,
            source: plane_wave([0.01, -0.005]),
            screens: vec![
                screen(Frame::GLOBAL, ScreenKind::Doe(round)),
                screen(on_axis(8.0), box_pixels(pixels(1), 0.025)),
                screen(on_axis(20.0), sensor(8, 0.01)),
            ],
            trains: vec![lens, Vec::new()],
        };
        let settings = LocalBandSettings {
            threshold: 3e-2,
            ..LocalBandSettings::new(vec![0.06, 0.06])
        };
        assert_pixels_transposed(&system, &settings, &[pixels(0), pixels(1)]);
    }

    /// Light of pixels that the edge of a prism sends to a sensor far aside.
    #[test]
    fn carry_kept_at_an_edge_dot_product() {
        let pixels = noise((8, 7), 0);
        let layer = pixel_layer(pixels.clone(), 0.02, PixelForm::Box);
        let first = element(layer, Aperture::disc(0.06));
        let gradient = [-400.0, 0.0];
        let prism = element(
            Layer::Phase(Profile::Linear { gradient }),
            Aperture::disc(0.2),
        );
        let aside = Frame {
            origin: Vec3::new(2.4, 0.0, 20.0),
            ..on_axis(20.0)
        };
        let system = System {
            wavelength: 0.5e-3,
            source: plane_wave([0.0; 2]),
            screens: vec![
                screen(Frame::GLOBAL, ScreenKind::Doe(first)),
                screen(on_axis(8.0), ScreenKind::Doe(prism)),
                screen(aside, sensor(8, 0.01)),
            ],
            trains: vec![Vec::new(), Vec::new()],
        };
        let settings = LocalBandSettings {
            threshold: 3e-2,
            ..LocalBandSettings::new(vec![0.06, 0.02])
        };
        assert_pixels_transposed(&system, &settings, &[pixels]);
    }

    /// The field is linear in the pixels of each screen, and their cotangents are the transpose.
    fn assert_pixels_transposed(
        system: &System,
        settings: &LocalBandSettings,
        pixels: &[Array2<Complex64>],
    ) {
        let (outcome, kept) = carry_kept(system, settings, &|_| uncancelled()).unwrap();
        let field = outcome.field;
        let bar = Field {
            grid: field.grid.clone(),
            values: noise((8, 8), 2),
        };
        let cotangent = LocalBandCotangent {
            field: &bar,
            variations: &[],
            pulse: &uncancelled,
        };
        let backs = carry_kept_adjoint(system, settings, &kept, &cotangent).unwrap();
        let inner = |a: &Array2<Complex64>, b: &Array2<Complex64>| -> Complex64 {
            a.iter().zip(b).map(|(a, b)| a.conj() * b).sum()
        };
        let forward = inner(&bar.values, &field.values);
        for (number, (back, pixels)) in backs.pixels.iter().zip(pixels).enumerate() {
            let reverse = inner(back.as_ref().unwrap(), pixels);
            let error = (forward - reverse).norm() / forward.norm();
            assert!(error < 1e-11, "{number}: {forward} {reverse} {error:e}");
        }
    }
}
