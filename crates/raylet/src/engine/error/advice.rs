//! Warnings and hints that follow from the plans, before a run.

use crate::engine::chain::arriving_light::{chief, incidence};
use crate::engine::error::crossing::crossings;
use crate::engine::error::missed_light::{beside_opening, missed_light};
use crate::engine::error::part_advice::{Leaving, beside_pixels, evanescent, in_glass};
use crate::engine::monte_carlo::tangent_patch_error::TangentPatchError;
use crate::engine::plan::hop_method::HopMethod;
use crate::engine::plan::hop_plan::Plan;
use crate::engine::plan::settings::Settings;
use crate::engine::rims::rim_screens::Rimmed;
use crate::math::vec3::Vec3;
use crate::optics::doe::Doe;
use crate::optics::phase::smooth_orders::smooth_orders;
use crate::optics::pixels::pixel_grid::PixelForm;
use crate::optics::ray::Loss;
use crate::optics::screen::ScreenKind;
use crate::optics::surface::without_edges;
use crate::optics::system::{Hop, System};

/// One finding about a hop.
#[derive(Clone, Debug, PartialEq)]
pub struct Advice {
    /// Number of the hop.
    pub hop: usize,
    /// Whether results may be other than expected; a mere note otherwise.
    pub warning: bool,
    /// The finding.
    pub text: String,
}

/// Places along each axis of a screen, and directions along each axis at a place, of the rays tried.
const PLACES: usize = 5;
const DIRECTIONS: usize = 9;

/// Places along each axis of the first screen at which the light of the source is compared with pixels.
const FINE: usize = 101;

/// Most rays that are followed from one screen on.
const MOST_RAYS: usize = 300;

/// Light is small against a target below this share of its width, in per cent.
const SMALL: f64 = 25.0;

/// Pixels are few where they cover less of the aperture than this, in per cent.
const BARE: f64 = 50.0;

/// Findings about a system as it was given, and about its hops as they are run, which are carried by these methods.
pub fn advice(
    given: &System,
    rimmed: &Rimmed,
    methods: &[HopMethod],
    settings: &Settings,
) -> Vec<Advice> {
    let found = crossings(given).into_iter();
    let own = found.map(|(number, text)| Advice {
        hop: rimmed.hop_of_given(number),
        warning: true,
        text,
    });
    let missed = missed_light(&rimmed.system).map(|text| Advice {
        hop: 0,
        warning: false,
        text,
    });
    let mut list: Vec<Advice> = own.chain(missed).collect();
    list.extend(advice_on_hops(&rimmed.system, methods, settings));
    list
}

/// Findings about the hops of a system.
fn advice_on_hops(system: &System, methods: &[HopMethod], settings: &Settings) -> Vec<Advice> {
    let (mut direction, _) = incidence(system);
    let mut rays = launch(system);
    let mut list = Vec::new();
    for (number, (hop, method)) in system.hops().zip(methods).enumerate() {
        let light = Light::follow(&hop, &rays);
        let mut say = |warning: bool, text: Option<String>| {
            list.extend(text.map(|text| Advice {
                hop: number,
                warning,
                text,
            }));
        };
        say(true, evanescent(&hop, &orders_behind(&hop, &rays)));
        say(false, beside_opening(&hop, &plain_rays(&hop, &rays)));
        say(true, in_glass(&hop, system.screens[0].index));
        let (warning, text) = without_pixels(system, number, &hop, &rays);
        say(warning, text);
        say(true, clipping(&light));
        say(false, aliasing(&hop, &light));
        if let Some((warning, text)) = smallness(&hop, &light) {
            say(warning, Some(text));
        }
        say(false, orders(&hop, direction));
        say(
            true,
            TangentPatchError::of(&hop, method).and_then(|flat| flat.warning()),
        );
        if let HopMethod::WholeField(Plan::Beamlets(beamlets)) = method {
            let [eta, left] = [beamlets.eta, beamlets.eta_corrected];
            let text = format!(
                "aberration inside beamlets would cost {eta:.1e}; the correction leaves {left:.1e}"
            );
            say(false, beamlets.correct.then_some(text));
            let expected = beamlets.expected_error();
            let tails = if beamlets.dropped > 0.5 * expected {
                format!(
                    ", {:.1e} of it in tails too aberrated to count",
                    beamlets.dropped
                )
            } else {
                String::new()
            };
            let text = format!(
                "aberration inside beamlets and their windows are expected to cost {expected:.1e}{tails}, \
                 more than the target error {:.1e}; no width of beamlets does better, and thresholds \
                 finer than {:.1e} would gain nothing",
                settings.target_error, beamlets.target_error
            );
            say(true, (expected > settings.target_error).then_some(text));
            let text =
                "σ is at the end of the widths tried; another may do better (settings.sigma_um)";
            say(false, beamlets.at_limit.then(|| text.to_owned()));
        }
        direction = chief(&hop, direction);
        rays = light.arrived;
    }
    list
}

/// A ray that arrives on a screen.
#[derive(Clone, Copy)]
struct ScreenRay {
    /// Where it arrives, in mm.
    at: [f64; 2],
    /// Its optical direction cosines there.
    cosines: [f64; 2],
}

/// What a hop does to the rays that stand on its first screen.
#[derive(Default)]
struct Light {
    /// Rays that would land on the target if every surface were large enough, and those of them that
    /// an aperture stops.
    landing: usize,
    clipped: usize,
    /// Lowest and highest p on arrival within the target, along x and y.
    cosines: Option<[f64; 4]>,
    /// The box that the rays land in, and how much diffraction by the first screen's edge widens it.
    landings: Option<[f64; 4]>,
    blur: [f64; 2],
    /// The rays that arrive on the target.
    arrived: Vec<ScreenRay>,
}

impl Light {
    fn follow(hop: &Hop, rays: &[ScreenRay]) -> Self {
        let mut light = Self::default();
        let (Some(from), Some(to)) = (hop.from.bounds(), hop.to.bounds()) else {
            return light;
        };
        let train = without_edges(hop.train);
        let open = Hop {
            train: &train,
            ..*hop
        };
        let stride = rays.len().div_ceil(MOST_RAYS).max(1);
        for &ScreenRay { at, cosines } in rays.iter().step_by(stride) {
            for p in leaving(hop, at, cosines) {
                if let Ok((landing, j)) = open.jacobian(at, p) {
                    light.widen(landing.at);
                    for (a, row) in j.iter().take(2).enumerate() {
                        let width = from[2 * a + 1] - from[2 * a];
                        let blur = 2.0 * hop.wavelength / width * row[2].hypot(row[3]);
                        light.blur[a] = light.blur[a].max(blur);
                    }
                    if inside(to, landing.at) {
                        light.arrive(hop, at, p);
                    }
                }
            }
        }
        light
    }

    fn widen(&mut self, [x, y]: [f64; 2]) {
        let [x0, x1, y0, y1] = self.landings.unwrap_or([x, x, y, y]);
        self.landings = Some([x0.min(x), x1.max(x), y0.min(y), y1.max(y)]);
    }

    /// Notes a ray that lands on the target unless an aperture stops it.
    fn arrive(&mut self, hop: &Hop, at: [f64; 2], p: [f64; 2]) {
        self.landing += 1;
        match hop.trace(at, p, &mut ()) {
            Err(Loss::Clipped) => self.clipped += 1,
            Ok(landing) => {
                let [px, py] = landing.cosines;
                let [x0, x1, y0, y1] = self.cosines.unwrap_or([px, px, py, py]);
                self.cosines = Some([x0.min(px), x1.max(px), y0.min(py), y1.max(py)]);
                self.arrived.push(ScreenRay {
                    at: landing.at,
                    cosines: landing.cosines,
                });
            }
            Err(_) => {}
        }
    }
}

fn inside([x0, x1, y0, y1]: [f64; 4], [x, y]: [f64; 2]) -> bool {
    x0 <= x && x <= x1 && y0 <= y && y <= y1
}

/// The source's rays on a lattice of places across the first screen.
fn launch(system: &System) -> Vec<ScreenRay> {
    let screen = &system.screens[0];
    let Some([x0, x1, y0, y1]) = screen.bounds() else {
        return Vec::new();
    };
    let place =
        |i: usize, low: f64, high: f64| low + (high - low) * (i as f64 + 0.5) / PLACES as f64;
    let places =
        (0..PLACES * PLACES).map(|n| [place(n % PLACES, x0, x1), place(n / PLACES, y0, y1)]);
    places
        .map(|at| {
            let here = screen.frame.to_global(Vec3::new(at[0], at[1], 0.0));
            let d = screen
                .frame
                .direction_to_local(system.source.direction(here));
            let cosines = [d.x * screen.index, d.y * screen.index];
            ScreenRay { at, cosines }
        })
        .collect()
}

/// Places on the first screen of a hop that the light meets, with its intensity there: of the source on a fine lattice, or
/// rays that arrived.
fn lit(system: &System, number: usize, rays: &[ScreenRay]) -> Vec<([f64; 2], f64)> {
    let screen = &system.screens[number];
    let Some([x0, x1, y0, y1]) = screen.bounds().filter(|_| number == 0) else {
        return rays.iter().map(|ray| (ray.at, 1.0)).collect();
    };
    let k = system.wavenumber() * screen.index;
    let place = |i: usize, low: f64, high: f64| low + (high - low) * (i as f64 + 0.5) / FINE as f64;
    let lattice = (0..FINE * FINE).map(|n| [place(n % FINE, x0, x1), place(n / FINE, y0, y1)]);
    let intensity = |[x, y]: [f64; 2]| {
        let point = screen.frame.to_global(Vec3::new(x, y, 0.0));
        ([x, y], system.source.field(point, k).norm_sqr())
    };
    lattice.map(intensity).collect()
}

/// Directions in which a ray leaves a screen: behind a smooth element the one there is, behind pixels
/// all that their lattice makes.
fn leaving(hop: &Hop, at: [f64; 2], p: [f64; 2]) -> Vec<[f64; 2]> {
    let ScreenKind::Doe(doe) = &hop.from.kind else {
        return vec![p];
    };
    let k = hop.wavenumber();
    if let Some([gx, gy]) = doe.phase_gradient(at[0], at[1]) {
        return vec![[p[0] + gx / k, p[1] + gy / k]];
    }
    let reach = turning(doe, hop.wavelength);
    let place =
        |i: usize, a: usize| p[a] + reach[a] * (2.0 * i as f64 / (DIRECTIONS - 1) as f64 - 1.0);
    (0..DIRECTIONS * DIRECTIONS)
        .map(|n| [place(n % DIRECTIONS, 0), place(n / DIRECTIONS, 1)])
        .collect()
}

/// The rays that leave a stop or a smooth element, as places and directions; none behind pixels, which send light everywhere.
fn plain_rays(hop: &Hop, rays: &[ScreenRay]) -> Vec<([f64; 2], [f64; 2])> {
    let goes_on = |ray: &&ScreenRay| match &hop.from.kind {
        ScreenKind::Stop(aperture) => aperture.contains(ray.at[0], ray.at[1]),
        ScreenKind::Doe(doe) => {
            let [x, y] = ray.at;
            doe.aperture.contains(x, y) && doe.phase_gradient(x, y).is_some()
        }
        ScreenKind::Sensor(_) => false,
    };
    let directions = |ray: &ScreenRay| leaving(hop, ray.at, ray.cosines);
    let own = rays.iter().filter(goes_on);
    own.flat_map(|ray| directions(ray).into_iter().map(|p| (ray.at, p)))
        .collect()
}

/// The light that leaves a plane element without pixels, order by order; none behind pixels, stops and curved elements.
fn orders_behind(hop: &Hop, rays: &[ScreenRay]) -> Vec<Leaving> {
    let ScreenKind::Doe(doe) = &hop.from.kind else {
        return Vec::new();
    };
    if !hop.from.is_plane() {
        return Vec::new();
    }
    let (k, mut list) = (hop.wavenumber(), Vec::new());
    let open = (rays.iter()).filter(|ray| doe.aperture.contains(ray.at[0], ray.at[1]));
    for ScreenRay { at, cosines } in open {
        let orders = smooth_orders(doe, *at).unwrap_or_default();
        list.extend(orders.iter().map(|order| Leaving {
            at: *at,
            cosines: [0, 1].map(|a| cosines[a] + order.gradient[a] / k),
            share: order.share,
        }));
    }
    list
}

/// Orders of a system that do not propagate, at the first element that has such.
pub(crate) fn lost_orders(system: &System) -> Option<String> {
    let mut rays = launch(system);
    system.hops().find_map(|hop| {
        let text = evanescent(&hop, &orders_behind(&hop, &rays));
        rays = Light::follow(&hop, &rays).arrived;
        text
    })
}

/// How far an element turns light along x and y, in optical direction cosines: half the lattice order of
/// its pixels and its steepest analytic phase.
pub(crate) fn turning(doe: &Doe, wavelength: f64) -> [f64; 2] {
    let steep = doe.bounds().map_or([0.0; 2], |bounds| doe.steepest(bounds));
    let pixels = doe.pixels().map(|pixels| pixels.pitch);
    [0, 1].map(|a| {
        let smooth = steep[a] * wavelength / std::f64::consts::TAU;
        smooth + pixels.map_or(0.0, |pitch| 0.5 * wavelength / pitch[a])
    })
}

/// Light that clear apertures cut off.
fn clipping(light: &Light) -> Option<String> {
    (light.clipped > 0).then(|| {
        let share = 100.0 * light.clipped as f64 / light.landing as f64;
        format!(
            "clear apertures of the surfaces stop {share:.0} % of the rays that would land on the \
             target; they are cut ray by ray, without diffraction at the edge; a stop element \
             diffracts"
        )
    })
}

/// Whether pixels leave most of the aperture dark, or what light falls beside them; the former is a warning.
fn without_pixels(
    system: &System,
    number: usize,
    hop: &Hop,
    rays: &[ScreenRay],
) -> (bool, Option<String>) {
    match uncovered(hop) {
        Some(text) => (true, Some(text)),
        None => (false, beside_pixels(hop, &lit(system, number, rays))),
    }
}

/// Pixels that leave most of the aperture dark: a unit taken for another, perhaps.
fn uncovered(hop: &Hop) -> Option<String> {
    let ScreenKind::Doe(doe) = &hop.from.kind else {
        return None;
    };
    let (pixels, open) = (doe.pixels()?.bounds(), doe.aperture.bounds()?);
    let area = |[x0, x1, y0, y1]: [f64; 4]| (x1 - x0).max(0.0) * (y1 - y0).max(0.0);
    let common = [
        pixels[0].max(open[0]),
        pixels[1].min(open[1]),
        pixels[2].max(open[2]),
        pixels[3].min(open[3]),
    ];
    let share = 100.0 * area(common) / area(open);
    (share < BARE).then(|| {
        let name = &hop.from.name;
        format!("the pixels of '{name}' cover {share:.2} % of its aperture; beside them it is dark")
    })
}

/// A sensor too coarse for the field: about the middle direction of its light, the field has the cosines ±NA.
fn aliasing(hop: &Hop, light: &Light) -> Option<String> {
    let ScreenKind::Sensor(sensor) = &hop.to.kind else {
        return None;
    };
    let [x0, x1, y0, y1] = light.cosines?;
    let apertures = [0.5 * (x1 - x0), 0.5 * (y1 - y0)];
    let finest = apertures.map(|na| hop.wavelength / (2.0 * na.max(1e-12)));
    let coarse = (0..2).find(|&a| sensor.pitch[a] > 1.001 * finest[a])?;
    Some(format!(
        "the sensor's pitch of {} µm along {} is coarser than λ/(2 NA) = {:.3} µm for light of NA {:.4}: values are right \
         where they stand, but detail between the pixels is not seen",
        round(sensor.pitch[coarse] * 1e3),
        ["x", "y"][coarse],
        finest[coarse] * 1e3,
        apertures[coarse],
    ))
}

/// A number without the noise of its last digits.
fn round(value: f64) -> f64 {
    (value * 1e9).round() * 1e-9
}

/// A target that the light misses, or that is much larger than the light.
fn smallness(hop: &Hop, light: &Light) -> Option<(bool, String)> {
    let to = hop.to.bounds()?;
    let landings = light.landings?;
    let name = &hop.to.name;
    let [x, y] = [0, 1].map(|a| {
        let (low, high) = (
            landings[2 * a] - light.blur[a],
            landings[2 * a + 1] + light.blur[a],
        );
        let common = high.min(to[2 * a + 1]) - low.max(to[2 * a]);
        100.0 * common.max(0.0) / (to[2 * a + 1] - to[2 * a])
    });
    if x == 0.0 || y == 0.0 {
        let text = format!("by rays, all light lands beside '{name}'; only diffraction reaches it");
        return Some((true, text));
    }
    (x < SMALL && y < SMALL).then(|| {
        let text = format!(
            "'{name}' is much larger than the light, which covers about {x:.0} % × {y:.0} % of it"
        );
        (false, text)
    })
}

/// Orders of the pixel lattice that miss the sensor.
fn orders(hop: &Hop, chief: [f64; 2]) -> Option<String> {
    let (ScreenKind::Doe(doe), ScreenKind::Sensor(_)) = (&hop.from.kind, &hop.to.kind) else {
        return None;
    };
    let pixels = doe.pixels().filter(|p| p.form != PixelForm::BandLimited)?;
    let pitch = pixels.pitch;
    let to = hop.to.bounds()?;
    let turns = [0, 1].map(|a| hop.wavelength / pitch[a]);
    let missed = (0..4).all(|n| {
        let mut p = chief;
        p[n / 2] += if n % 2 == 0 {
            turns[n / 2]
        } else {
            -turns[n / 2]
        };
        !hop.trace([0.0, 0.0], p, &mut ()).is_ok_and(|landing| {
            let [x, y] = landing.at;
            (to[0]..=to[1]).contains(&x) && (to[2]..=to[3]).contains(&y)
        })
    });
    missed.then(|| {
        let angle = |p: f64| p.min(1.0).asin().to_degrees();
        format!(
            "the first orders of the pixel lattice of '{}' (±{:.2}° along x, ±{:.2}° along y) miss the \
             sensor: their light is not simulated",
            hop.from.name,
            angle(turns[0]),
            angle(turns[1])
        )
    })
}
