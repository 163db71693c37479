//! First-order optics of a prescription: pupils, the size of its stop, and how high light passes each surface.
//!
//! The axis is taken as straight: turns and shifts of it do not count. Heights are y (mm), slopes are optical: p = n·u along
//! the way of the light.

use crate::file::prescription::face_grid::GridKind;
use crate::file::prescription::glasses::glass_choice::MediumBehind;
use crate::file::prescription::sequential::{Action, ApertureRule, Behind, FieldKind, Sequential};
use crate::file::scene::layer::Layer;
use crate::optics::zernike::ZernikeSum;

/// A ray behind each surface but the object: its height and optical slope.
type Heights = Vec<[f64; 2]>;

/// First-order data of a lens.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct FirstOrder {
    /// Diameter of the entrance pupil in mm.
    pub pupil_diameter: f64,
    /// Position of the entrance pupil behind the first surface in mm.
    pub pupil_position: f64,
    /// Focal length in mm; infinite without power.
    pub focal_length: f64,
    /// Radius of the light in the stop in mm.
    pub stop_radius: f64,
    /// The marginal ray, by the number of the surface less one.
    pub marginal: Heights,
    /// The chief ray of slope one before the first surface.
    pub chief: Heights,
    /// Its height at the image in mm.
    pub image_height: f64,
}

/// One surface: its power, and the reduced distance to the next.
#[derive(Clone, Copy, Debug)]
struct Stage {
    power: f64,
    reduced: f64,
}

/// Why a lens has no first-order data.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct NoPupil(pub &'static str);

impl FirstOrder {
    /// The data of a lens with these media at a wavelength in mm.
    ///
    /// # Errors
    /// A stop that no light can fill, or an aperture that does not fit the distance of the object.
    pub(crate) fn of(
        lens: &Sequential,
        media: &[MediumBehind],
        wavelength: f64,
    ) -> Result<Self, NoPupil> {
        let stages = stages(lens, media, wavelength);
        let stop = lens.stop - 1;
        // A height and a slope at the first surface give these heights at the stop.
        let at_stop = |start: [f64; 2]| height_at(&trace(&stages, start), stop);
        let (a, b) = (at_stop([1.0, 0.0]), at_stop([0.0, 1.0]));
        if a.abs() < 1e-9 {
            return Err(NoPupil(
                "a stop that light from an infinitely distant point crosses in one point",
            ));
        }
        let pupil_position = b / a;
        let distance = lens.object_distance().map(|object| object + pupil_position);

        // The marginal ray through the rim of an entrance pupil of radius one.
        let unit = match (lens.object_distance(), distance) {
            (Some(object), Some(distance)) => [object / distance, 1.0 / distance],
            _ => [1.0, 0.0],
        };
        if !unit.iter().all(|value| value.is_finite()) {
            return Err(NoPupil("an object in the entrance pupil"));
        }
        let unit_ray = trace(&stages, unit);
        let collimated = trace(&stages, [1.0, 0.0]);
        let slope = collimated.last().map_or(0.0, |ray| ray[1]);
        let focal_length = -1.0 / slope;
        let radius = pupil_radius(lens, &unit_ray, focal_length, distance)?;
        if !(radius.is_finite() && radius > 1e-9 && radius < 1e9) {
            return Err(NoPupil("an aperture from which no finite pupil follows"));
        }
        let scaled = unit_ray.iter().map(|ray| ray.map(|value| value * radius));
        let chief = trace(&stages, [-pupil_position, 1.0]);
        let image_height = chief.last().map_or(0.0, |ray| ray[0]);
        Ok(Self {
            pupil_diameter: 2.0 * radius,
            pupil_position,
            focal_length,
            stop_radius: height_at(&unit_ray, stop).abs() * radius,
            marginal: scaled.collect(),
            chief,
            image_height,
        })
    }

    /// The distance in mm along the axis at which the marginal ray behind a surface crosses it, in a medium of this index, after
    /// this many mirrors; none where it is parallel.
    pub(crate) fn crossing(&self, surface: usize, index: f64, mirrors: usize) -> Option<f64> {
        let [height, slope] = self.marginal.get(surface.checked_sub(1)?)?;
        let heading = if mirrors.is_multiple_of(2) { 1.0 } else { -1.0 };
        let distance = -heading * height * index / slope;
        distance.is_finite().then_some(distance)
    }

    /// Slopes of the chief ray of a field at the entrance pupil, along x and y.
    pub(crate) fn field_slopes(&self, lens: &Sequential, field: [f64; 2]) -> [f64; 2] {
        let distance = lens
            .object_distance()
            .map(|object| object + self.pupil_position);
        field.map(|value| match (lens.field_kind, distance) {
            (FieldKind::Angle, _) => value.to_radians().tan(),
            (FieldKind::ObjectHeight, Some(distance)) => -value / distance,
            (FieldKind::ObjectHeight, None) => 0.0,
            _ => value / self.image_height,
        })
    }

    /// 1 over twice the slope of the marginal ray at the image, times the index there; infinite where it is parallel.
    pub(crate) fn working_f_number(&self) -> f64 {
        let slope = self.marginal.last().map_or(0.0, |ray| ray[1]);
        0.5 / slope.abs()
    }

    /// The height of the marginal ray, and that of the chief ray of these slopes, at a surface; both from the axis outwards.
    pub(crate) fn heights(&self, surface: usize, slopes: [f64; 2]) -> [f64; 2] {
        let at = surface.wrapping_sub(1);
        let slope = slopes[0].hypot(slopes[1]);
        [
            height_at(&self.marginal, at).abs(),
            height_at(&self.chief, at).abs() * slope,
        ]
    }
}

/// The radius of the entrance pupil in mm.
fn pupil_radius(
    lens: &Sequential,
    unit: &Heights,
    focal_length: f64,
    distance: Option<f64>,
) -> Result<f64, NoPupil> {
    Ok(match lens.aperture {
        ApertureRule::EntrancePupil(diameter) => 0.5 * diameter,
        ApertureRule::ImageFNumber(number) => 0.5 * (focal_length / number).abs(),
        ApertureRule::WorkingFNumber(number) => {
            let slope = unit.last().map_or(0.0, |ray| ray[1]);
            0.5 / (number * slope.abs())
        }
        ApertureRule::ObjectSine(sine) => match distance {
            Some(distance) => (distance * sine / (1.0 - sine * sine).sqrt()).abs(),
            None => {
                return Err(NoPupil(
                    "a numerical aperture at an object that is infinitely far",
                ));
            }
        },
        ApertureRule::StopSize => {
            let stop = lens.surface.get(lens.stop);
            let Some((size, _)) = stop.and_then(|stop| stop.semi_diameter) else {
                return Err(NoPupil(
                    "an aperture given by the stop, whose surface has no semi-diameter",
                ));
            };
            size / height_at(unit, lens.stop - 1).abs()
        }
    })
}

fn height_at(ray: &Heights, at: usize) -> f64 {
    ray.get(at).map_or(0.0, |ray| ray[0])
}

/// The surfaces but the object, unfolded: behind an odd number of mirrors curvatures and distances change their signs.
fn stages(lens: &Sequential, media: &[MediumBehind], wavelength: f64) -> Vec<Stage> {
    let mut heading = 1.0;
    let mut list = Vec::new();
    let pairs = lens.surface.iter().zip(media).skip(1).zip(media);
    for ((face, behind), before) in pairs {
        let vertex = face.curve.vertex_curvature() + face.grid_curvature(GridKind::Sag);
        let curvature = heading * vertex;
        let reflects = face.behind == Behind::Reflected;
        let own = match face.action {
            Action::Turn(_) => 0.0,
            Action::IdealLens(focal_length) => before.index / focal_length,
            Action::Border if reflects => -2.0 * before.index * curvature,
            Action::Border => (behind.index - before.index) * curvature,
        };
        if reflects {
            heading = -heading;
        }
        let shift = match face.action {
            Action::Turn(turn) => turn.along_mm,
            _ => 0.0,
        };
        let thickness = match face.thickness_mm.is_finite() {
            true => face.thickness_mm + shift,
            false => 0.0,
        };
        let phases: f64 = face
            .phase
            .iter()
            .map(|layer| power(layer, wavelength))
            .sum();
        let phases = phases + bending(0.5 * face.grid_curvature(GridKind::Phase), wavelength);
        list.push(Stage {
            power: own + phases,
            reduced: heading * thickness / behind.index,
        });
    }
    list
}

/// Power in 1/mm that a phase has at its vertex.
fn power(layer: &Layer, wavelength: f64) -> f64 {
    let square = match layer {
        Layer::Radial(sum) => {
            let first = sum.coefficients.first().copied().unwrap_or(0.0);
            first / sum.norm_radius_mm.powi(2)
        }
        Layer::Polynomial(sum) => {
            let squares = sum.terms.iter().filter(|term| (term.x, term.y) == (0, 2));
            let sum_of_squares: f64 = squares.map(|term| term.coefficient).sum();
            sum_of_squares / sum.norm_radius_mm.powi(2)
        }
        Layer::Zernike(sum) => {
            let sum = ZernikeSum::new(sum.norm_radius_mm, sum.coefficients.clone());
            0.5 * sum.curvature_y()
        }
        _ => 0.0,
    };
    bending(square, wavelength)
}

/// Power in 1/mm of a phase with this coefficient of y² in rad/mm²: it bends a ray by its slope over k.
fn bending(square: f64, wavelength: f64) -> f64 {
    -2.0 * square * wavelength / std::f64::consts::TAU
}

/// A ray from a height and an optical slope at the first surface.
fn trace(stages: &[Stage], [mut y, mut p]: [f64; 2]) -> Heights {
    let mut list = Vec::new();
    for stage in stages {
        p -= stage.power * y;
        list.push([y, p]);
        y += p * stage.reduced;
    }
    list
}

#[cfg(test)]
mod tests {
    use crate::file::prescription::first_order::{Stage, trace};

    /// A thin lens of f = 50 mm, 100 mm before the image: light parallel to the axis crosses it halfway.
    #[test]
    fn light_crosses_the_axis_in_the_focus() {
        let lens = Stage {
            power: 0.02,
            reduced: 100.0,
        };
        let image = Stage {
            power: 0.0,
            reduced: 0.0,
        };
        let ray = trace(&[lens, image], [3.0, 0.0]);
        assert!((ray[1][0] + 3.0).abs() < 1e-12 && (ray[1][1] + 0.06).abs() < 1e-12);
    }
}
