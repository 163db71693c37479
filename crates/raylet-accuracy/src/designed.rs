//! Designed systems seen by references that share no code with raylet's rays: planes of phase pixels in free space by
//! their plane waves, and a phase before a lens by integrals from surface to surface.

use std::error::Error;

use ndarray::{Array1, Array2, Axis};
use num_complex::Complex64;
use raylet::file::arrays::image::read_gray;
use raylet::file::arrays::memory::MemoryLimit;
use raylet::file::model::build;
use raylet::file::scene::element::Element;
use raylet::file::scene::layer::Layer;
use raylet::file::scene::loss_specification::{LossSpecification, OverlapLoss, SpotLoss};
use raylet::file::scene::scene_file::Scene;
use raylet::optics::aperture::Aperture;
use raylet::optics::screen::{ScreenKind, Sensor};
use raylet::optics::shape::Shape;
use raylet::optics::surface::Surface;
use raylet::optics::system::System;

use crate::numerics::pixels::Pixels;
use crate::references::lens_train::{LensTrain, Source, Step};
use crate::references::spectrum::Spectrum;
use crate::references::surface::Sag;

/// What can go wrong: nothing that more than a message would help.
type Outcome<T> = Result<T, Box<dyn Error + Send + Sync>>;

/// The overlap of a reference field with its mode, and its brightness.
#[derive(Clone, Copy, Debug)]
pub struct Share {
    /// Share of the light behind the first aperture that is in the mode.
    pub mode: f64,
    /// Share of it that is on the sensor.
    pub seen: f64,
    /// Normalised correlation of the intensity with the picture.
    pub ncc: f64,
}

/// The brightness of one spot.
#[derive(Clone, Copy, Debug)]
pub struct Brightness {
    /// Number of the field, of the wavelength.
    pub place: [usize; 2],
    /// Share of what the whole aperture in phase would bring.
    pub strehl: f64,
}

/// Parts of a pixel along each axis, so that a disc may cut it.
const PARTS: usize = 5;

/// The pixels of an element, each divided into parts that count by how far they are open.
fn parts(system: &System, screen: usize) -> Outcome<Pixels> {
    let ScreenKind::Doe(doe) = &system.screens[screen].kind else {
        return Err("a screen without pixels".into());
    };
    let pixels = doe.free_pixels().ok_or("an element without pixels")?;
    let (pitch, (ny, nx)) = (pixels.pitch[0] / PARTS as f64, pixels.values.dim());
    let place = |i: usize, n: usize| (i as f64 - 0.5 * (n * PARTS) as f64) * pitch;
    let transmission = Array2::from_shape_fn((ny * PARTS, nx * PARTS), |(j, i)| {
        let (x, y) = (place(i, nx), place(j, ny));
        let open = doe.aperture.coverage(x, x + pitch, y, y + pitch);
        pixels.values[[j / PARTS, i / PARTS]] * open
    });
    Ok(Pixels {
        pitch,
        transmission,
    })
}

/// The sensor's pixel centres along an axis.
fn centres(sensor: &Sensor, axis: usize) -> Array1<f64> {
    let count = sensor.pixels[axis];
    let place = |i: usize| (i as f64 - 0.5 * (count as f64 - 1.0)) * sensor.pitch[axis];
    Array1::from_shape_fn(count, place)
}

fn sensor(system: &System) -> Outcome<Sensor> {
    match system.screens.last().map(|screen| &screen.kind) {
        Some(ScreenKind::Sensor(sensor)) => Ok(*sensor),
        _ => Err("no sensor".into()),
    }
}

fn distance(system: &System, from: usize) -> f64 {
    system.screens[from + 1].frame.origin.z - system.screens[from].frame.origin.z
}

/// The overlap that a scene describes, of planes of pixels in free space: by their plane waves, pixel by pixel.
///
/// # Errors
/// When the scene has none, or the system is none of pixels alone.
pub fn overlap(scene: &Scene, system: &System) -> Outcome<Share> {
    let last = system.screens.len() - 1;
    let planes: Vec<Pixels> = (0..last)
        .map(|i| parts(system, i))
        .collect::<Outcome<_>>()?;
    let mut steps = Vec::new();
    for (i, plane) in planes.iter().enumerate() {
        if i > 0 {
            steps.push(Step::Pixels(plane));
        }
        steps.push(Step::Drift(distance(system, i)));
    }
    let widest = planes.iter().map(Pixels::half_width).fold(0.0, f64::max);
    let train = LensTrain {
        wavelength: system.wavelength,
        period: 8.0 * widest,
        samples: 1,
        reach: 0.65,
        extra: 5.0,
        stencil: 6,
        pixel_nodes: 2,
    };
    let sensor = sensor(system)?;
    let (x, y) = (centres(&sensor, 0), centres(&sensor, 1));
    let spectrum = train.run(Source::Pixels(&planes[0], [0.0; 2]), &steps, widest);
    let field = spectrum.map_err(|e| format!("{e:?}"))?.on_grid(&y, &x);

    share(scene, system, [&x, &y], &field)
}

/// How much of a field at these x and y is in the target mode, and how bright it looks.
fn share(
    scene: &Scene,
    system: &System,
    [x, y]: [&Array1<f64>; 2],
    field: &Array2<Complex64>,
) -> Outcome<Share> {
    // The mode at the sensor's pixels, and the light that the first aperture lets in.
    let sensor = sensor(system)?;
    let spec = overlap_of(scene)?;
    let (Some(file), Some(size)) = (&spec.picture, spec.size_mm) else {
        return Err("an overlap without its picture".into());
    };
    let limit = MemoryLimit::of_settings(scene.memory_limit());
    let mode = mode(&read_gray(scene.origin.beside(file), limit)?, size, [x, y]);
    let power = match &system.screens[0].kind {
        ScreenKind::Doe(doe) => aperture(&doe.aperture),
        _ => 1.0,
    };

    let area = sensor.pitch[0] * sensor.pitch[1];
    let pairs = || mode.iter().zip(field);
    let inner: Complex64 = pairs().map(|(m, u)| u * *m).sum();
    let norm: f64 = mode.iter().map(|m| m * m).sum();
    let target: f64 = mode.iter().map(|m| m.powi(4)).sum();
    let bright: f64 = field.iter().map(|u| u.norm_sqr().powi(2)).sum();
    let like: f64 = pairs().map(|(m, u)| m * m * u.norm_sqr()).sum();
    Ok(Share {
        mode: inner.norm_sqr() / norm * area / power,
        seen: field.iter().map(|u| u.norm_sqr()).sum::<f64>() * area / power,
        ncc: like / (target * bright).sqrt(),
    })
}

/// The overlap of the scene's design.
fn overlap_of(scene: &Scene) -> Outcome<&OverlapLoss> {
    let specs = scene.design.iter().flat_map(|design| &design.loss);
    let mut overlaps = specs.filter_map(|spec| match spec {
        LossSpecification::Overlap(spec) => Some(spec),
        _ => None,
    });
    Ok(overlaps.next().ok_or("no overlap")?)
}

/// The root of a picture of this size at the sensor's pixel centres, [y, x].
fn mode(image: &Array2<f64>, size: [f64; 2], [x, y]: [&Array1<f64>; 2]) -> Array2<f64> {
    let (rows, columns) = image.dim();
    let cell = |at: f64, size: f64, count: usize| {
        let cell = (at / size + 0.5) * count as f64;
        (cell >= 0.0 && cell < count as f64).then_some(cell as usize)
    };
    Array2::from_shape_fn((y.len(), x.len()), |(j, i)| {
        let place = (cell(y[j], size[1], rows), cell(x[i], size[0], columns));
        match place {
            (Some(row), Some(column)) => image[[row, column]].sqrt(),
            _ => 0.0,
        }
    })
}

/// The area of an aperture in mm².
fn aperture(aperture: &Aperture) -> f64 {
    let [x0, x1, y0, y1] = aperture.bounds().unwrap_or_default();
    let (dx, dy) = ((x1 - x0) / 400.0, (y1 - y0) / 400.0);
    let mut area = 0.0;
    for n in 0..400 * 400 {
        let (x, y) = (x0 + f64::from(n % 400) * dx, y0 + f64::from(n / 400) * dy);
        area += aperture.coverage(x, x + dx, y, y + dy) * dx * dy;
    }
    area
}

/// Height and slopes of a plane or a conic.
fn conic(surface: &Surface) -> Outcome<impl Fn(f64, f64) -> [f64; 3] + Sync> {
    let (c, kappa) = match surface.shape {
        Shape::Plane => (0.0, 0.0),
        Shape::Conic(conic) => (conic.curvature, conic.conic),
        _ => return Err("a surface that is no conic".into()),
    };
    Ok(move |x: f64, y: f64| {
        let square = x * x + y * y;
        let root = (1.0 - (1.0 + kappa) * c * c * square).sqrt();
        [c * square / (1.0 + root), c * x / root, c * y / root]
    })
}

/// The spots that a scene describes, behind a radial phase and one lens: by integrals from surface to surface.
///
/// # Errors
/// When the scene has no such phase and lens, or a field without its spot.
pub fn spots(scene: &Scene) -> Outcome<Vec<Brightness>> {
    let design = scene.design.as_ref().ok_or("no design")?;
    let Some(Element::Doe(doe)) = scene.element.first() else {
        return Err("the first element is no phase".into());
    };
    let Some(Layer::Radial(radial)) = doe.layer.first() else {
        return Err("the first layer is not radial".into());
    };
    let phase = |x: f64, y: f64| {
        let u = (x * x + y * y) / radial.norm_radius_mm.powi(2);
        let powers = radial.coefficients.iter().enumerate();
        powers.map(|(i, a)| a * u.powi(i as i32 + 1)).sum::<f64>()
    };
    let mut found = Vec::new();
    for (field, view) in design.field.iter().enumerate() {
        let angle = view.angle_deg.ok_or("a field without its angle")?;
        let spec = design.loss.iter().find_map(|spec| match spec {
            LossSpecification::Spot(spot) if spot.field == Some(vec![field]) => Some(spot),
            _ => None,
        });
        let spec = spec.ok_or("a field without its spot")?;
        for channel in 0..scene.wavelength_um.len() {
            let system = build::system(scene, channel)?;
            let tilt = angle.map(|angle| angle.to_radians().sin());
            let strehl = strehl(&system, &phase, tilt, spec)?;
            let place = [field, channel];
            found.push(Brightness { place, strehl });
        }
    }
    Ok(found)
}

/// The brightness of a spot as its loss has it: linear between the sensor's pixels.
fn strehl(
    system: &System,
    phase: &(dyn Fn(f64, f64) -> f64 + Sync),
    tilt: [f64; 2],
    spec: &SpotLoss,
) -> Outcome<f64> {
    let [front, back] = &system.trains[0][..] else {
        return Err("not one lens".into());
    };
    let ScreenKind::Doe(doe) = &system.screens[0].kind else {
        return Err("the first screen is no element".into());
    };
    let radius = doe.aperture.bounds().ok_or("no aperture")?[1];
    let end = system.screens[1].frame.origin;
    let (a, b) = (front.frame.origin.z, back.frame.origin.z);
    let sags = [conic(front)?, conic(back)?];
    let face = |number: usize, index: f64| Step::Surface {
        sag: Sag::General(&sags[number]),
        semi_aperture: 1.3 * radius,
        index,
    };
    let steps = [
        Step::Drift(a - system.screens[0].frame.origin.z),
        face(0, front.index[1]),
        Step::Drift(b - a),
        face(1, back.index[1]),
        Step::Drift(end.z - b),
    ];
    let train = LensTrain {
        wavelength: system.wavelength,
        period: 6.0 * radius,
        samples: fast((6.0 * radius / (1.5 * system.wavelength)) as usize),
        reach: 0.25,
        extra: 4.0,
        stencil: 6,
        pixel_nodes: 2,
    };
    let half = end.x.abs() + spec.at_mm[0][0].abs() + 0.02;
    let spectrum = train.run(Source::Phase(radius, phase, tilt), &steps, half);
    let spectrum = spectrum.map_err(|error| format!("{error:?}"))?;

    let seen = between(&spectrum, &sensor(system)?, spec.at_mm[0], [end.x, end.y]);
    let focal = spec
        .focal_length_mm
        .ok_or("a spot without its focal length")?;
    let ideal = std::f64::consts::PI * radius * radius / (system.wavelength * focal);
    Ok(seen / (ideal * ideal))
}

/// The intensity at a point of the sensor whose middle is at `middle`, linear between its pixels.
fn between(spectrum: &Spectrum, sensor: &Sensor, at: [f64; 2], middle: [f64; 2]) -> f64 {
    // The four pixels about the point, and their shares.
    let around = |axis: usize| {
        let centres = centres(sensor, axis);
        let place = (at[axis] - centres[0]) / sensor.pitch[axis];
        let first = place as usize;
        let pair = centres
            .slice_axis(Axis(0), (first..first + 2).into())
            .to_owned()
            + middle[axis];
        let part = place - first as f64;
        (pair, [1.0 - part, part])
    };
    let ((x, u), (y, v)) = (around(0), around(1));
    let field = spectrum.on_grid(&y, &x);
    let terms = field.indexed_iter();
    terms
        .map(|((j, i), value)| v[j] * u[i] * value.norm_sqr())
        .sum()
}

/// The next number that has no other factors than 2, 3 and 5.
fn fast(least: usize) -> usize {
    let smooth = |n: &usize| {
        let mut n = *n;
        for factor in [2, 3, 5] {
            while n.is_multiple_of(factor) {
                n /= factor;
            }
        }
        n == 1
    };
    (least.max(1)..).find(smooth).unwrap_or(least)
}
