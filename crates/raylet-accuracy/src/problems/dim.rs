//! Tilted lenses that send little of the light to their sensor: random pixels in a disc 100λ across, a plano-convex
//! lens 220λ across 340λ behind them, tilted and decentred, and a small sensor 1000 to 2400λ behind the lens.
//!
//! Lengths are in wavelengths. The light goes by direct sum to the lens's first face, by plane waves of the lens's
//! own frame through the glass, and by direct sum from its second face to the sensor; both rims are hard.

use ndarray::Array2;
use num_complex::Complex64;
use raylet::engine::plan::settings::Settings;
use raylet::math::vec3::Vec3;
use raylet::optics::aperture::Aperture;
use raylet::optics::doe::{Doe, Layer};
use raylet::optics::frame::Frame;
use raylet::optics::phase::placement::Placement;
use raylet::optics::pixels::active_area::ActiveArea;
use raylet::optics::pixels::pixel_grid::{PixelForm, Pixels as DoePixels};
use raylet::optics::refraction::Coating;
use raylet::optics::screen::ScreenKind;
use raylet::optics::surface::Surface;
use raylet::optics::system::System;
use raylet_testkit::parts::{on_axis, plane_wave, screen};

use crate::estimates::nodes::{Fineness, rectangle_in_disc};
use crate::problems::problem::{Problem, face, random_pixels, sensor};
use crate::problems::strong::Effort;
use crate::problems::tilted::{sensor_points, standing};
use crate::references::direct::SampledSurface;
use crate::references::interface::{plane_to_surface, surface_to_plane};
use crate::references::spectrum::{Lattice, Slab};
use crate::references::surface::{Sag, SurfaceSamples};

/// Radius of the disc of pixels, their pitch, and the highest frequency of what they send to the lens and of the
/// light that meets them.
const DISC: f64 = 50.0;
const PITCH: f64 = 4.35;
const FREQUENCY: f64 = 0.5;

/// The lens: radius of its first face, thickness, index, radius of both rims, and its distance.
const RADIUS: f64 = 3582.0;
const THICKNESS: f64 = 86.2;
const INDEX: f64 = 1.8406;
const RIM: f64 = 110.0;
const GAP: f64 = 342.0;

/// Points of the sensor along each axis, and their distance.
const SENSOR: (usize, f64) = (29, 1.47);

/// How exactly the reference is computed: converged to some 1e-4.
pub const USUAL: Effort = Effort {
    period: 400.0,
    density: 2.5,
};

/// A tilted and decentred lens that sends little light to the sensor.
#[derive(Clone, Copy, Debug)]
pub struct DimLens {
    /// Tilts of the lens about x and y in degrees.
    pub tilt: [f64; 2],
    /// Decentre of the lens along x.
    pub decentre: f64,
    /// Distance of the sensor from the second face's vertex plane, and of its middle from the axis.
    pub sensor: [f64; 3],
}

/// The systems of the report.
pub const DIM_LENSES: [DimLens; 6] = [
    DimLens {
        tilt: [7.9, 4.85],
        decentre: -13.2,
        sensor: [0.0, 0.0, 2382.0],
    },
    DimLens {
        tilt: [-5.0, 9.0],
        decentre: 8.0,
        sensor: [0.0, 0.0, 2382.0],
    },
    DimLens {
        tilt: [7.9, 4.85],
        decentre: -13.2,
        sensor: [120.0, -60.0, 2382.0],
    },
    DimLens {
        tilt: [12.0, 0.0],
        decentre: 0.0,
        sensor: [0.0, 40.0, 1500.0],
    },
    DimLens {
        tilt: [3.0, -12.0],
        decentre: 20.0,
        sensor: [-80.0, 0.0, 1000.0],
    },
    DimLens {
        tilt: [0.0, 15.0],
        decentre: -25.0,
        sensor: [200.0, 100.0, 2000.0],
    },
];

impl DimLens {
    /// The problem for raylet.
    pub fn problem(self) -> Problem {
        let [x, y, z] = self.sensor;
        let frame = on_axis(GAP + THICKNESS + z).moved(Vec3::new(x, y, 0.0));
        let pixels = random_pixels(23, PITCH);
        let element = Doe {
            layers: vec![Layer::Pixels(DoePixels {
                pitch: [PITCH; 2],
                values: pixels.transmission,
                form: PixelForm::Box,
                active: ActiveArea::WHOLE,
                placement: Placement::NONE,
            })],
            aperture: Aperture::disc(DISC),
            reflect: false,
        };
        Problem {
            name: format!(
                "random 4.35λ pixels, lens tilted {:?}° and {}λ off, small sensor at ({x}, {y}, {z})λ",
                self.tilt, self.decentre
            ),
            reference: "direct sums and surface integrals",
            system: System {
                wavelength: 1.0,
                source: plane_wave([0.0; 2]),
                screens: vec![
                    screen(on_axis(0.0), ScreenKind::Doe(element)),
                    standing(sensor(0.0, SENSOR.0, SENSOR.1), frame),
                ],
                trains: vec![self.faces()],
            },
            settings: Settings::default(),
            exact: Box::new(move || self.exact(frame, USUAL)),
        }
    }

    /// The frame of its first face.
    fn frame(&self) -> Frame {
        let [a, b] = self.tilt.map(f64::to_radians);
        on_axis(GAP)
            .moved(Vec3::new(self.decentre, 0.0, 0.0))
            .tilted([a, b, 0.0])
    }

    fn faces(&self) -> Vec<Surface> {
        let frame = self.frame();
        let first = face(0.0, RADIUS, RIM, Coating::Unit, [1.0, INDEX]);
        let second = face(0.0, f64::INFINITY, RIM, Coating::Unit, [INDEX, 1.0]);
        let behind = frame.moved(Vec3::new(0.0, 0.0, THICKNESS));
        vec![
            Surface { frame, ..first },
            Surface {
                frame: behind,
                ..second
            },
        ]
    }

    /// The exact field on a sensor in `frame`, indexed [y, x].
    pub fn exact(&self, frame: Frame, effort: Effort) -> Array2<Complex64> {
        let own = self.frame();
        let samples = (effort.density * effort.period).round() as usize;
        let first = SurfaceSamples::new(effort.period, samples, RIM, 6, Sag::Sphere(RADIUS));
        let second = SurfaceSamples::new(effort.period, samples, RIM, 6, Sag::Flat);
        let place = |points: &[[f64; 3]], lift: f64| -> Vec<Vec3> {
            let global = |[x, y, z]: &[f64; 3]| own.to_global(Vec3::new(*x, *y, z + lift));
            points.iter().map(global).collect()
        };

        // To the first face, through the glass, and to the second.
        let on_first = element().radiate(1.0, &place(&first.points, 0.0));
        let lattice = Lattice::new(1.0, effort.period, 1.0);
        let glass = surface_to_plane(&on_first, &first, lattice, INDEX, 6.0);
        let slab = Slab {
            index: INDEX,
            thickness: THICKNESS,
        };
        #[expect(
            clippy::unreachable,
            reason = "an instrument that is set up wrongly must stop"
        )]
        let Ok(arrived) = glass.through(&[slab], RIM) else {
            unreachable!("the period is chosen long enough");
        };
        let on_second = plane_to_surface(&arrived, &second, 6.0);

        // From there to the sensor.
        let pitch = effort.period / samples as f64;
        let areas = second
            .weights
            .iter()
            .map(|weight| own.z * (weight * pitch * pitch));
        let sheet = SampledSurface {
            points: place(&second.points, THICKNESS),
            areas: areas.collect(),
            field: on_second,
        };
        let field = sheet.radiate(1.0, &sensor_points(&frame, SENSOR.0, SENSOR.1));
        Array2::from_shape_fn((SENSOR.0, SENSOR.0), |(j, i)| field[j * SENSOR.0 + i])
    }
}

/// The pixels within the disc, lit from behind.
fn element() -> SampledSurface {
    let pixels = random_pixels(23, PITCH);
    let (rows, columns) = pixels.transmission.dim();
    let fine = Fineness {
        frequency: FREQUENCY,
        effort: 1.0,
    };
    let mut sheet = SampledSurface::default();
    for ((row, column), value) in pixels.transmission.indexed_iter() {
        let low = |place: usize, count: usize| (place as f64 - 0.5 * count as f64) * PITCH;
        let (x, y) = (low(column, columns), low(row, rows));
        for ([x, y], area) in rectangle_in_disc([x, x + PITCH, y, y + PITCH], DISC, fine) {
            sheet.points.push(Vec3::new(x, y, 0.0));
            sheet.areas.push(Vec3::new(0.0, 0.0, area));
            sheet.field.push(*value);
        }
    }
    sheet
}
