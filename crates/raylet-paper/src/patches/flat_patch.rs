//! What a flat patch costs on a curved mirror: the error of the field against its size and the radius, and
//! the picture of it.

#![expect(
    clippy::indexing_slicing,
    reason = "systems, windows and rows are made here, with these screens and sizes"
)]

use std::time::Instant;

use raylet::engine::chain::reference::{ReferenceError, ReferenceOptions, reference};
use raylet::engine::chain::simulate::simulate;
use raylet::engine::free::free_method::Approach;
use raylet::engine::plan::settings::{Method, Paper, Positions, Sag, Sampler, Settings};
use raylet::wave::grid::metrics::{field_error, shape_error};
use raylet_plot::chart_panel::Series;
use raylet_plot::figure::{Figure, Panel};
use raylet_plot::panel::FigureError;

use crate::mirrors::conformal_mirror::spherical_patch;

/// Samples along each axis of the sensor.
const POINTS: usize = 16;

/// Period of a patch over its side.
const PADDING: f64 = 4.0;

/// One patch on one sphere.
#[derive(Clone, Copy, Debug)]
pub struct Bent {
    /// Side D in wavelengths.
    pub side: f64,
    /// Radius R in wavelengths.
    pub radius: f64,
    /// The bound arcsin(D/2R) in rad.
    pub angle: f64,
    /// Phase error at the middle of an edge, 2k·D²/8R in rad.
    pub phase: f64,
    /// Field error, and error of its shape alone, of the plane that touches the middle.
    pub tangent: [f64; 2],
    /// The two errors where the incident light meets the true surface.
    pub incident: [f64; 2],
    /// The two errors with the height of the surface for incident and leaving light.
    pub whole: [f64; 2],
}

/// The study.
#[derive(Clone, Debug)]
pub struct FlatPatches {
    /// All patches, those of one radius together.
    pub found: Vec<Bent>,
    /// Rays followed.
    pub rays: u64,
    /// Seconds it took.
    pub seconds: f64,
}

/// All modes of one patch as large as the mirror.
fn settings(side: f64, sag: Sag) -> Settings {
    Settings {
        method: Method::Paper,
        paper: Paper {
            rays: 1,
            patch: Some(side),
            padding: PADDING,
            positions: Positions::Grid,
            sampler: Sampler::All,
            orders: 3,
            sag,
            ..Paper::default()
        },
        ..Settings::default()
    }
}

impl FlatPatches {
    /// Measures patches of these sides on spheres of these radii, in wavelengths, against the direct
    /// Rayleigh–Sommerfeld sum over the sphere.
    ///
    /// # Errors
    /// As [`reference()`].
    pub fn measure(sides: &[usize], radii: &[f64]) -> Result<Self, ReferenceError> {
        let clock = Instant::now();
        let (mut found, mut rays) = (Vec::new(), 0);
        let choice = ReferenceOptions {
            approach: Approach::RayleighSommerfeld,
            ..ReferenceOptions::default()
        };
        for &radius in radii {
            for &side in sides {
                let system = spherical_patch(side, radius, POINTS);
                let exact = reference(&system, &Settings::default(), choice, &|_| {})?;
                let exact = exact.field.values;
                let mut errors = |sag| {
                    let settings = settings(side as f64 * system.wavelength, sag);
                    let outcome = simulate(&system, &settings, &|_| {})?;
                    rays += outcome.hops[0].tally.total_rays();
                    let ours = outcome.field.values;
                    let all = field_error(ours.view(), exact.view()).unwrap_or(f64::NAN);
                    let shape = shape_error(ours.view(), exact.view());
                    Ok::<_, ReferenceError>([all, shape.map_or(f64::NAN, |shape| shape.error)])
                };
                let side = side as f64;
                found.push(Bent {
                    side,
                    radius,
                    angle: (0.5 * side / radius).min(1.0).asin(),
                    phase: std::f64::consts::TAU * side * side / (4.0 * radius),
                    tangent: errors(Sag::Tangent)?,
                    incident: errors(Sag::Incident)?,
                    whole: errors(Sag::True)?,
                });
            }
        }
        Ok(Self {
            found,
            rays,
            seconds: clock.elapsed().as_secs_f64(),
        })
    }

    /// Error over the side of the patch, with the bound by the angle; and error over the phase error.
    ///
    /// # Errors
    /// A picture that cannot be drawn.
    pub fn png(&self, title: &str) -> Result<Vec<u8>, FigureError> {
        let mut over_side = Vec::new();
        let mut bounds = Vec::new();
        for radius in self.radii() {
            let of = |value: fn(&Bent) -> f64| -> Vec<[f64; 2]> {
                let here = self.found.iter().filter(|bent| bent.radius == radius);
                here.map(|bent| [bent.side, value(bent)]).collect()
            };
            over_side.push(Series::line(
                &format!("R = {radius:.0} λ"),
                of(|bent| bent.tangent[0]),
            ));
            bounds.push(Series::dashed(
                &format!("R = {radius:.0} λ"),
                of(|bent| bent.angle),
            ));
        }
        let errors = Panel::lines(over_side)
            .title("Error of the field of flat patches")
            .x_axis("side D of the patch", "λ")
            .y_axis("relative error of the field", "")
            .log_x()
            .log_y();
        let bounds = Panel::lines(bounds)
            .title("The paper's bound, an angle")
            .x_axis("side D of the patch", "λ")
            .y_axis("arcsin(D/2R)", "rad")
            .log_x()
            .log_y();
        let over_phase = |value: fn(&Bent) -> f64| -> Vec<[f64; 2]> {
            self.found
                .iter()
                .map(|bent| [bent.phase, value(bent)])
                .collect()
        };
        let phases = Panel::lines(vec![
            Series::dots("plane", over_phase(|bent| bent.tangent[0])),
            Series::dots(
                "incident light on the surface",
                over_phase(|bent| bent.incident[0]),
            ),
            Series::dots("with the height", over_phase(|bent| bent.whole[0])),
        ])
        .title("All radii: the field error follows the phase error")
        .x_axis("2k·D²/8R", "rad")
        .y_axis("relative error of the field", "")
        .log_x()
        .log_y();
        Figure::new(
            vec![vec![errors.into(), bounds.into()], vec![phases.into()]],
            title,
        )
        .to_png(1.5)
    }

    /// The radii in the order of their measurement.
    fn radii(&self) -> Vec<f64> {
        let mut radii: Vec<f64> = self.found.iter().map(|bent| bent.radius).collect();
        radii.dedup();
        radii
    }
}

#[cfg(test)]
mod tests {
    use crate::patches::flat_patch::FlatPatches;

    /// The error of a plane is that of its phase k(x² + y²)/R, whose root mean square over a square is
    /// √(7/180)·kD²/R; less than that, as the sensor's middle sees more of the patch's. Half of it is left
    /// where the light that comes meets the surface, none with the height.
    #[test]
    fn errors_of_planes_are_those_of_their_phase_slow() {
        let study = FlatPatches::measure(&[10, 20], &[400.0]).unwrap();
        assert_eq!(study.found.len(), 2);
        for bent in &study.found {
            let expected = 4.0 * bent.phase * f64::sqrt(7.0 / 180.0);
            let ratio = bent.tangent[0] / expected;
            assert!((0.45..1.0).contains(&ratio), "{bent:?}");
            let half = bent.incident[0] / bent.tangent[0];
            assert!((0.4..0.6).contains(&half), "{bent:?}");
            assert!(bent.whole[0] < 0.05, "{bent:?}");
        }
        assert!(study.png("Flat patches").unwrap().starts_with(b"\x89PNG"));
    }
}
