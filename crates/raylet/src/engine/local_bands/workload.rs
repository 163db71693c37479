//! What a run by local bands will take, and whether its windows are narrow enough, by rays of the source.

use crate::engine::local_bands::chirped_beamlet::ChirpedStart;
use crate::engine::local_bands::hop_step::HopStep;
use crate::engine::local_bands::local_band_error::LocalBandError;
use crate::engine::local_bands::settings::LocalBandSettings;
use crate::engine::local_bands::window_directions::window_directions;
use crate::engine::local_bands::window_widths::{expected_aberration, leaving_carriers};
use crate::engine::plan::cost_model::local_bands::{
    NODE, OPERATION, PRODUCT, SMOOTH_WINDOW, SURFACE, VALUE, WAVE, WINDOW,
};
use crate::optics::screen::{ScreenKind, Sensor};
use crate::optics::system::System;
use crate::wave::local_bands::carrier::Carrier;
use crate::wave::local_bands::local_band::{sample_pitch, window_half_band};
use crate::wave::local_bands::tiling::REACH;

/// Nodes of a pixel along an axis.
const NODES: f64 = 2.0;

/// Widths of windows that are tried, as parts of the widest.
const NARROWER: [f64; 5] = [1.0, 0.7, 0.5, 0.35, 0.25];

/// What a hop by local bands will take.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LocalBandWorkload {
    /// Seconds on one core, about.
    pub seconds: f64,
    /// The error to expect from the aberration inside beamlets.
    pub aberration: f64,
    /// The error to expect from all causes but rims.
    pub error: f64,
}

/// The workload of each hop of a system.
///
/// # Errors
/// As a run, except that light which does not arrive is no error.
pub(crate) fn workload(
    system: &System,
    settings: &LocalBandSettings,
) -> Result<Vec<LocalBandWorkload>, LocalBandError> {
    let leaving = leaving_carriers(system, settings.aperture)?;
    let hops = system.hops().enumerate().zip(&leaving);
    hops.map(|((number, hop), carriers)| {
        let step = HopStep::new(system, settings, number, hop)?;
        let plan = step.plan();
        let aberration = expected_aberration(&hop, carriers, &plan);
        // A smooth source has no plane waves to leave out.
        let (seconds, dropped) = match plan.smooth {
            true => {
                let [nx, ny] = plan.windows.map(|count| count as f64);
                (nx * ny * SMOOTH_WINDOW, 0.0)
            }
            false => {
                let window = seconds_a_window(&step, carriers, settings);
                let dropped = settings.dropped.unwrap_or(settings.threshold);
                (step.lit_windows() as f64 * window, dropped)
            }
        };
        Ok(LocalBandWorkload {
            seconds,
            aberration,
            error: aberration.hypot(plan.window_error(0.0)).hypot(dropped),
        })
    })
    .collect()
}

/// The mean over carriers of the seconds that a window takes.
fn seconds_a_window(step: &HopStep, carriers: &[Carrier], settings: &LocalBandSettings) -> f64 {
    let one = |carrier: &Carrier| {
        let start = ChirpedStart {
            carrier: *carrier,
            sigma: step.plan().sigma,
        };
        seconds_of(step, &start, settings)
    };
    carriers.iter().map(one).sum::<f64>() / carriers.len().max(1) as f64
}

/// The seconds that one window takes.
fn seconds_of(step: &HopStep, start: &ChirpedStart, settings: &LocalBandSettings) -> f64 {
    let (hop, plan) = (&step.hop, step.plan());
    let k = hop.wavenumber();
    let Some(directions) = window_directions(hop, start, &step.target) else {
        return WINDOW;
    };
    let band = window_half_band(plan.step, settings.threshold) / (k * plan.sigma);
    let samples = 2.0 * REACH * plan.sigma / sample_pitch(band, hop.wavelength);
    let pixels = step.pixel_pitch();
    let limit = if pixels.is_some() {
        f64::INFINITY
    } else {
        band
    };
    let spacing = hop.wavelength / (plan.period * plan.sigma);
    let waves = [0, 1].map(|a| {
        let [low, high] = [
            directions.bounds[2 * a].max(-limit),
            directions.bounds[2 * a + 1].min(limit),
        ];
        ((high - low) / spacing).max(0.0) + 1.0
    });
    let nodes = pixels.map_or([samples; 2], |pitch| {
        pitch.map(|pitch| NODES * 2.0 * REACH * plan.sigma / pitch)
    });
    let products = waves[1] * nodes[0] * nodes[1] + waves[0] * waves[1] * nodes[0];
    let transform = match pixels {
        Some(pitch) => {
            let folded = pitch.map(|pitch| NODES * plan.period * plan.sigma / pitch);
            let to_nodes = 0.5 * samples * nodes[0] * (samples + nodes[1]);
            PRODUCT * to_nodes
                + NODE * nodes[0] * nodes[1]
                + (OPERATION * folded_operations(folded, waves[0])).min(PRODUCT * products)
        }
        None => PRODUCT * products,
    };
    let beamlets = waves[0] * waves[1];
    let traced = WAVE + SURFACE * (hop.train.len() + 1) as f64;
    WINDOW + transform + beamlets * (traced + VALUE * values(step, start))
}

/// Operations of the fast transforms of a window with so many folded nodes along x and y and plane waves along x.
fn folded_operations([x, y]: [f64; 2], waves: f64) -> f64 {
    let line = |folded: f64| 5.0 * folded * folded.log2().max(1.0);
    y * line(x) + waves * line(y)
}

/// Narrower windows in place of these widths, for elements of pixels that send light to a wide target, where that takes less
/// time: they send fewer plane waves past the element's edges. The aberration inside beamlets, which grows where windows are only
/// wavelengths wide, stays within a target error of each hop.
///
/// # Errors
/// When a screen has no edge or layers of another kind, or no ray of the source meets an aperture.
pub(crate) fn quickest_widths(
    system: &System,
    settings: &LocalBandSettings,
    error: f64,
) -> Result<Vec<f64>, LocalBandError> {
    let leaving = leaving_carriers(system, settings.aperture)?;
    let mut sigmas = settings.sigmas.clone();
    for ((number, hop), carriers) in system.hops().enumerate().zip(&leaving) {
        let mut best = f64::INFINITY;
        for narrower in NARROWER {
            let mut tried = settings.clone();
            let Some(sigma) = tried.sigmas.get_mut(number) else {
                continue;
            };
            *sigma *= narrower;
            let sigma = *sigma;
            // Narrower windows may be too many.
            let Ok(step) = HopStep::new(system, &tried, number, hop) else {
                break;
            };
            if step.pixel_pitch().is_none() {
                break;
            }
            let aberration = expected_aberration(&hop, carriers, &step.plan());
            if narrower < 1.0 && aberration > error {
                break;
            }
            let seconds = step.lit_windows() as f64 * seconds_a_window(&step, carriers, &tried);
            if seconds < best {
                best = seconds;
                if let Some(chosen) = sigmas.get_mut(number) {
                    *chosen = sigma;
                }
            }
        }
    }
    Ok(sigmas)
}

/// Pixels of the sensor under one beamlet; none where it goes to another screen.
fn values(step: &HopStep, start: &ChirpedStart) -> f64 {
    let ScreenKind::Sensor(Sensor { pixels, pitch }) = step.hop.to.kind else {
        return 0.0;
    };
    let Ok(arrival) = start.launch(&step.hop, [0.0; 2]) else {
        return 0.0;
    };
    let reach = arrival.footprint(step.hop.wavenumber(), step.target.edge);
    let along = |a: usize| (2.0 * reach[a] / pitch[a]).min(pixels[a] as f64);
    along(0) * along(1)
}
