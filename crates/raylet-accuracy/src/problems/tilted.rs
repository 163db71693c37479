//! Tilted and decentred parts, each in a train with one strongly refracting lens or plate.
//!
//! Lengths are in wavelengths. The light goes by direct sum from a plane of pixels, wherever it stands, to
//! the samples of a lens's first face; from there by plane waves of the lens's own frame through the glass,
//! its plane face and the air behind it to the points of a sensor, wherever that stands.

use ndarray::Array2;
use num_complex::Complex64;
use raylet::engine::plan::settings::Settings;
use raylet::math::vec3::Vec3;
use raylet::optics::frame::Frame;
use raylet::optics::refraction::Coating;
use raylet::optics::screen::Screen;
use raylet::optics::source::Source;
use raylet::optics::surface::Surface;
use raylet::optics::system::System;

use crate::numerics::pixels::Pixels;
use crate::problems::problem::{Problem, axis, doe, face, sensor};
use crate::problems::strong::Effort;
use crate::references::direct::SampledSurface;
use crate::references::interface::surface_to_plane;
use crate::references::spectrum::{Lattice, Slab, Spectrum};
use crate::references::surface::{Sag, SurfaceSamples};

/// A piece of glass with a plane face behind, in air; its frame is that of its first face.
#[derive(Clone, Copy, Debug)]
pub struct Glass {
    /// Origin and axes at the vertex of the first face.
    pub frame: Frame,
    /// Radius of the first face; infinite for a plate.
    pub radius: f64,
    /// Radius of the first face's rim; nothing when it is so far out that it does not matter.
    pub rim: Option<f64>,
    /// Thickness.
    pub thickness: f64,
    /// Refractive index.
    pub index: f64,
}

/// Pixels, glass, sensor.
#[derive(Clone)]
pub struct Setup {
    /// Description of the system, as the report shows it.
    pub name: &'static str,
    /// Unit direction of the collimated light, phase zero at the origin.
    pub light: Vec3,
    /// The pixels, and where they stand.
    pub pixels: Pixels,
    /// Their frame.
    pub doe: Frame,
    /// The glass.
    pub glass: Glass,
    /// The sensor's frame.
    pub sensor: Frame,
    /// Points of the sensor along each axis, and their distance.
    pub points: (usize, f64),
    /// Period and sampling of the reference.
    pub effort: Effort,
}

/// Radius of a plate that replaces an endless one, softly blocked over the outer quarter.
const ENDLESS: f64 = 110.0;

/// Gauss nodes along each side of a pixel.
const NODES: usize = 5;

impl Glass {
    /// Its faces for raylet.
    fn faces(&self) -> Vec<Surface> {
        let wide = 1e6;
        let first = face(
            0.0,
            self.radius,
            self.rim.unwrap_or(wide),
            Coating::Unit,
            [1.0, self.index],
        );
        let second = face(0.0, f64::INFINITY, wide, Coating::Unit, [self.index, 1.0]);
        vec![
            Surface {
                frame: self.frame,
                ..first
            },
            Surface {
                frame: self.behind(),
                ..second
            },
        ]
    }

    /// The frame of its second face.
    fn behind(&self) -> Frame {
        self.frame.moved(Vec3::new(0.0, 0.0, self.thickness))
    }

    /// The samples of its first face in its own frame.
    fn samples(&self, effort: Effort) -> SurfaceSamples {
        let sag = if self.radius.is_finite() {
            Sag::Sphere(self.radius)
        } else {
            Sag::Flat
        };
        let samples = (effort.density * effort.period).round() as usize;
        SurfaceSamples::new(effort.period, samples, self.rim.unwrap_or(ENDLESS), 8, sag)
    }

    /// The field at points behind it, from a sheet before it.
    fn carry(&self, sheet: &SampledSurface, effort: Effort, points: &[Vec3]) -> Vec<Complex64> {
        let surface = self.samples(effort);
        let on_face: Vec<Vec3> = surface
            .points
            .iter()
            .map(|[x, y, z]| self.frame.to_global(Vec3::new(*x, *y, *z)))
            .collect();
        let mut field = sheet.radiate(1.0, &on_face);
        if self.rim.is_none() {
            for (value, [x, y, _]) in field.iter_mut().zip(&surface.points) {
                *value *= soft(x.hypot(*y), ENDLESS);
            }
        }
        let lattice = Lattice::new(1.0, effort.period, 1.0);
        let glass = surface_to_plane(&field, &surface, lattice, self.index, 6.0);
        self.behind_glass(glass, points)
    }

    /// The field at points behind it, from its plane waves at the first vertex.
    fn behind_glass(&self, glass: Spectrum, points: &[Vec3]) -> Vec<Complex64> {
        // The points in the frame of the first face, about a plane through their middle.
        let local: Vec<Vec3> = points.iter().map(|p| self.frame.to_local(*p)).collect();
        let deep = local.iter().map(|p| p.z).sum::<f64>() / local.len() as f64;
        let far = |p: &Vec3| p.x.abs().max(p.y.abs());
        let reach = local.iter().map(far).fold(0.0, f64::max);
        let slabs = [
            Slab {
                index: self.index,
                thickness: self.thickness,
            },
            Slab {
                index: 1.0,
                thickness: deep - self.thickness,
            },
        ];
        let width = self.rim.unwrap_or(ENDLESS) + reach;
        #[expect(
            clippy::unreachable,
            reason = "an instrument that is set up wrongly must stop"
        )]
        let Ok(arrived) = glass.through(&slabs, width) else {
            unreachable!("the period is chosen long enough");
        };
        let about: Vec<[f64; 3]> = local.iter().map(|p| [p.x, p.y, p.z - deep]).collect();
        arrived.at_points(&about, 1e-7)
    }
}

/// The points of a square sensor in `frame`, row by row.
pub fn sensor_points(frame: &Frame, count: usize, pitch: f64) -> Vec<Vec3> {
    let at = axis(count, pitch);
    let row = |y: &f64| {
        at.iter()
            .map(|x| Vec3::new(*x, *y, 0.0))
            .collect::<Vec<_>>()
    };
    at.iter()
        .flat_map(row)
        .map(|point| frame.to_global(point))
        .collect()
}

/// One in the middle, zero at `half` and beyond, smooth over the outer quarter.
pub fn soft(at: f64, half: f64) -> f64 {
    let t = ((half - at.abs()) / (half / 4.0)).clamp(0.0, 1.0);
    t * t * t * (10.0 + t * (6.0 * t - 15.0))
}

/// A screen moved to a frame.
pub fn standing(screen: Screen, frame: Frame) -> Screen {
    Screen { frame, ..screen }
}

impl Setup {
    /// The problem for raylet.
    pub fn problem(self) -> Problem {
        let (count, pitch) = self.points;
        let origin = Vec3::new(0.0, 0.0, 0.0);
        Problem {
            name: self.name.to_owned(),
            reference: "direct sum and surface integrals",
            system: System {
                wavelength: 1.0,
                source: Source::Plane {
                    direction: self.light,
                    origin,
                },
                screens: vec![
                    standing(doe(0.0, &self.pixels), self.doe),
                    standing(sensor(0.0, count, pitch), self.sensor),
                ],
                trains: vec![self.glass.faces()],
            },
            settings: Settings::default(),
            exact: Box::new(move || {
                let sheet =
                    SampledSurface::pixels(&self.pixels, &self.doe, NODES).lit(self.light, 1.0);
                let points = sensor_points(&self.sensor, self.points.0, self.points.1);
                let field = self.glass.carry(&sheet, self.effort, &points);
                Array2::from_shape_fn((count, count), |(j, i)| field[j * count + i])
            }),
        }
    }
}
