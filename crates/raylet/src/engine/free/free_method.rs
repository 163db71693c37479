//! Which method without rays carries a hop, and why the others do not.

use serde::Deserialize;

use crate::engine::plan::hop_plan::free_hop;
use crate::engine::plan::plan_error::BYTES_OF_DIRECTION;
use crate::engine::plan::settings::Settings;
use crate::math::vec3::Vec3;
use crate::optics::paraxial::Abcd;
use crate::optics::screen::Screen;
use crate::optics::system::Hop;
use crate::wave::free::free_plan::FreePlan;
use crate::wave::free::propagate::FreeHop;

/// A method that needs no beamlets.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Approach {
    /// The first of the others that applies, hop by hop.
    #[default]
    Auto,
    /// Band-limited angular spectrum: parallel screens with at most plane-parallel plates between.
    AngularSpectrum,
    /// Rayleigh–Sommerfeld direct sum: nothing between the screens, at any tilt.
    RayleighSommerfeld,
    /// Collins' integral: centred trains, without their aberrations and rims.
    Collins,
    /// The generalised law of refraction: smooth elements, any train, no diffraction.
    #[serde(rename = "gsl")]
    Refraction,
}

impl Approach {
    /// The name used in reports and messages.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Approach::Auto => "auto",
            Approach::AngularSpectrum => "angular spectrum",
            Approach::RayleighSommerfeld => "Rayleigh–Sommerfeld sum",
            Approach::Collins => "Collins integral",
            Approach::Refraction => "generalised law of refraction",
        }
    }
}

/// How one hop is carried.
#[derive(Clone, Debug)]
pub(crate) enum FreeMethod {
    /// By plane waves.
    AngularSpectrum(FreeHop, FreePlan),
    /// By direct sum.
    RayleighSommerfeld(LinesOfSight),
    /// By the train's ray matrix.
    Collins(Abcd),
}

/// Every line of sight between two screens.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct LinesOfSight {
    /// Largest optical direction cosines along the first screen's axes.
    pub leaving: [f64; 2],
    /// Largest optical direction cosines along the second screen's axes.
    pub arriving: [f64; 2],
}

impl FreeMethod {
    /// Its method.
    pub(crate) fn approach(&self) -> Approach {
        match self {
            FreeMethod::AngularSpectrum(..) => Approach::AngularSpectrum,
            FreeMethod::RayleighSommerfeld(_) => Approach::RayleighSommerfeld,
            FreeMethod::Collins(_) => Approach::Collins,
        }
    }

    /// Largest |p| that matters behind the first screen, and brought to the second, whose outlines are `from`
    /// and `to`.
    pub(crate) fn reach(&self, hop: &Hop, from: [f64; 4], to: [f64; 4]) -> ([f64; 2], [f64; 2]) {
        match self {
            FreeMethod::AngularSpectrum(_, plan) => {
                let largest = plan.largest();
                (largest, largest.map(|p| p.min(hop.to.index)))
            }
            FreeMethod::RayleighSommerfeld(sight) => (sight.leaving, sight.arriving),
            FreeMethod::Collins(train) => {
                // p = (x′ − A x)/B and p′ = (D x′ − x)/B.
                let half = |b: [f64; 4], a: usize| b[2 * a].abs().max(b[2 * a + 1].abs());
                let bound = |s: f64, x: f64| (s + x) / train.b.abs();
                (
                    [0, 1].map(|a| bound(half(to, a), train.a.abs() * half(from, a))),
                    [0, 1].map(|a| bound(train.d.abs() * half(to, a), half(from, a))),
                )
            }
        }
    }
}

/// The route of a hop, and why it is taken.
#[derive(Clone, Debug)]
pub(crate) struct Route {
    /// How the hop is carried.
    pub method: FreeMethod,
    /// Why: that it was chosen, or what stands against the methods before it.
    pub why: String,
}

/// The route of a hop whose incident light has direction `chief`; otherwise the reasons why there is
/// none.
///
/// # Errors
/// What stands against the approach, or against every approach.
pub(crate) fn free_method(
    hop: &Hop,
    approach: Approach,
    chief: [f64; 2],
    [from, to]: [[f64; 4]; 2],
    settings: &Settings,
) -> Result<Route, String> {
    let spectrum = || angular_spectrum(hop, chief, from, to, settings);
    let sum = || sight(hop, from, to).map(FreeMethod::RayleighSommerfeld);
    if !hop.to.is_plane() {
        return Err(format!(
            "'{}' is curved, and light is summed on planes",
            hop.to.name
        ));
    }
    let curved = !hop.from.is_plane();
    let only_sums = || Err(format!("'{}' is curved", hop.from.name));
    let spectrum = || if curved { only_sums() } else { spectrum() };
    let collins = || {
        if curved {
            return only_sums();
        }
        let train = Abcd::between(hop).map_err(|error| error.to_string())?;
        match train.b == 0.0 {
            true => Err(String::from("the train images one screen onto the other")),
            false => Ok(FreeMethod::Collins(train)),
        }
    };
    let found = match approach {
        Approach::AngularSpectrum => spectrum(),
        Approach::RayleighSommerfeld => sum(),
        Approach::Collins => collins(),
        Approach::Refraction => Err(String::from("it carries whole systems, not single hops")),
        Approach::Auto => return first_of(&[&spectrum, &sum, &collins]),
    };
    let why = String::from("chosen by the user");
    found.map(|method| Route { method, why })
}

/// A way to find a method, or what stands against it.
type Attempt<'a> = dyn Fn() -> Result<FreeMethod, String> + 'a;

/// The methods that `auto` tries, in this order.
const ORDER: [Approach; 3] = [
    Approach::AngularSpectrum,
    Approach::RayleighSommerfeld,
    Approach::Collins,
];

/// The first method that applies, and why those before it do not.
fn first_of(attempts: &[&Attempt; 3]) -> Result<Route, String> {
    let mut against: Vec<String> = Vec::new();
    for (approach, attempt) in ORDER.iter().zip(attempts) {
        match attempt() {
            Ok(method) => {
                let why = match against.is_empty() {
                    true => String::from("parallel screens with at most plates between"),
                    false => against.join("; "),
                };
                return Ok(Route { method, why });
            }
            Err(reason) => against.push(format!("{}: {reason}", approach.name())),
        }
    }
    Err(against.join("; "))
}

fn angular_spectrum(
    hop: &Hop,
    chief: [f64; 2],
    from: [f64; 4],
    to: [f64; 4],
    settings: &Settings,
) -> Result<FreeMethod, String> {
    let Some(free) = free_hop(hop, from, to, chief, settings) else {
        return Err(match hop.train.len() {
            0 => String::from("the screens are not parallel"),
            _ => String::from(
                "what stands between is more than plates parallel to both screens, wider than them",
            ),
        });
    };
    let plan = free.plan(from, to);
    let [nx, ny] = [0, 1].map(|a| plan.bands[a].count);
    // As many as in a run: they and one intermediate array fit.
    let needed = nx.saturating_mul(ny).saturating_mul(BYTES_OF_DIRECTION);
    if needed > settings.memory_limit {
        let allowed = settings.memory_limit / BYTES_OF_DIRECTION;
        let enough = needed.div_ceil(1_000_000);
        return Err(format!(
            "it needs {nx} × {ny} plane waves, more than the {allowed} allowed (settings.memory_limit_mb = {enough} \
             allows them)"
        ));
    }
    Ok(FreeMethod::AngularSpectrum(free, plan))
}

/// Points along each axis of a screen from which lines of sight are drawn.
const STATIONS: usize = 5;

/// The lines of sight from screen to screen, when nothing stands between and the whole of the second
/// screen lies in front of the first.
fn sight(hop: &Hop, from: [f64; 4], to: [f64; 4]) -> Result<LinesOfSight, String> {
    if !hop.train.is_empty() {
        return Err(format!("{} surface(s) stand between", hop.train.len()));
    }
    let (starts, ends) = (stations(hop.from, from), stations(hop.to, to));
    let mut sight = LinesOfSight {
        leaving: [0.0; 2],
        arriving: [0.0; 2],
    };
    for start in &starts {
        for end in &ends {
            let flight = *end - *start;
            let (out, back) = (
                hop.from.frame.direction_to_local(flight),
                hop.to.frame.direction_to_local(flight),
            );
            if out.z * hop.from.leaves() <= 0.0 || back.z * hop.to.arrives <= 0.0 {
                return Err(String::from(
                    "part of the second screen lies behind the first, or is lit from behind",
                ));
            }
            let scale = hop.from.index_behind() / flight.norm();
            for (most, v) in [(&mut sight.leaving, out), (&mut sight.arriving, back)] {
                *most = [
                    most[0].max(scale * v.x.abs()),
                    most[1].max(scale * v.y.abs()),
                ];
            }
        }
    }
    Ok(sight)
}

/// Global points spread over a screen's outline.
fn stations(screen: &Screen, [x0, x1, y0, y1]: [f64; 4]) -> Vec<Vec3> {
    let along =
        |low: f64, high: f64, i: usize| low + (high - low) * i as f64 / (STATIONS as f64 - 1.0);
    (0..STATIONS * STATIONS)
        .map(|n| {
            let (x, y) = (along(x0, x1, n % STATIONS), along(y0, y1, n / STATIONS));
            let z = screen.height([x, y]).map_or(0.0, |here| here.z);
            screen.frame.to_global(Vec3::new(x, y, z))
        })
        .collect()
}
