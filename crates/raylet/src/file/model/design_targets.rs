//! What a design evaluates: one run for each wavelength and each place the light comes from, and its losses.

use std::path::{Path, PathBuf};

use ndarray::Array2;
use num_complex::Complex64;

use crate::design::losses::likeness::{Brightness, Likeness};
use crate::design::losses::loss::{FieldLoss, LossError};
use crate::design::losses::overlap::Overlap;
use crate::design::losses::share::Share;
use crate::design::losses::spots::Spots;
use crate::design::losses::target::Target;
use crate::engine::chain::arriving_light::sensor_of;
use crate::file::decode::fault::Fault;
use crate::file::decode::number::LEAST;
use crate::file::model::hologram::{hologram_of, picture_of, target};
use crate::file::scene::design::{Design, View};
use crate::file::scene::illumination::Illumination;
use crate::file::scene::loss_specification::{
    CirclesLoss, Compared, EfficiencyLoss, LossSpecification, OverlapLoss, PictureLoss, SpotLoss,
};
use crate::file::scene::scene_file::Scene;
use crate::math::vec3::Vec3;
use crate::optics::aperture::Aperture;
use crate::optics::pixels::pixel_axes::on_pixel_axes;
use crate::optics::screen::ScreenKind;
use crate::optics::system::System;
use crate::wave::grid::raster::Raster;

/// One run that a design evaluates.
#[derive(Clone, Debug)]
pub struct ChannelDescription {
    /// Number of its field, and of its wavelength in the scene.
    pub place: [usize; 2],
    /// The kinds of its losses.
    pub kinds: Vec<&'static str>,
    /// The picture that it is compared with, [y, x], and where its outline is, if there is one.
    pub picture: Option<[Array2<f64>; 2]>,
}

/// A run with its losses.
pub(crate) type ChannelLosses = (ChannelDescription, Vec<(f64, Box<dyn FieldLoss>)>);

/// The scene as it is lit in each field; itself without any.
///
/// # Errors
/// Fields that do not fit the source.
pub(crate) fn lit(scene: &Scene, design: &Design) -> Result<Vec<Scene>, Fault> {
    if design.field.is_empty() {
        return Ok(vec![scene.clone()]);
    }
    let fields = design.field.iter().enumerate();
    fields.map(|(i, view)| lit_by(scene, view, i)).collect()
}

fn lit_by(scene: &Scene, view: &View, number: usize) -> Result<Scene, Fault> {
    let mut scene = scene.clone();
    let refuse = |found: &str, expected: &str| {
        Err(scene.fault(&format!("design.field[{number}]"), found, expected))
    };
    match (&scene.source, view.angle_deg, view.position_mm) {
        (Illumination::Plane(_), Some(angle), None) => {
            if let Illumination::Plane(plane) = &mut scene.source {
                plane.angle_deg = angle;
            }
        }
        (Illumination::Gaussian(_), Some(angle), None) => {
            if let Illumination::Gaussian(beam) = &mut scene.source {
                beam.angle_deg = angle;
            }
        }
        (Illumination::Point(_), None, Some(position)) if position[2] <= -LEAST => {
            if let Illumination::Point(point) = &mut scene.source {
                point.position_mm = position;
            }
        }
        (Illumination::Plane(_) | Illumination::Gaussian(_), ..) => {
            return refuse(
                "a field of another kind of light",
                "angle_deg for a plane source or a Gaussian beam",
            );
        }
        (Illumination::Field(_) | Illumination::Fibre(_), ..) => {
            return refuse(
                "a field of a source that is given on a plane",
                "a plane source, a Gaussian beam or a point source",
            );
        }
        (Illumination::Point(_), ..) => {
            let expected = "position_mm for a point source, z below zero";
            return refuse("a field of another kind of light", expected);
        }
    }
    Ok(scene)
}

/// Every run with a loss, from the systems of each field and wavelength.
///
/// # Errors
/// Losses that do not fit the scene or its sensor.
pub(crate) fn channel_losses(
    scene: &Scene,
    design: &Design,
    systems: &[Vec<System>],
) -> Result<Vec<ChannelLosses>, Fault> {
    let counted = counted_losses(scene, design)?;
    let mut list = Vec::new();
    for (field, systems) in systems.iter().enumerate() {
        for (wavelength, system) in systems.iter().enumerate() {
            let place = [field, wavelength];
            let stage = Stage::new(scene, system)?;
            let mut run = ChannelDescription {
                place,
                kinds: Vec::new(),
                picture: None,
            };
            let mut losses = Vec::new();
            for own in counted.iter().filter(|own| own.counts(place)) {
                let loss = stage.loss(&own.spec, &own.at)?;
                run.kinds.push(own.spec.name());
                losses.push((own.weight, loss));
                if run.picture.is_none() {
                    run.picture = stage.shown(&own.spec, &own.at)?;
                }
            }
            if !losses.is_empty() {
                list.push((run, losses));
            }
        }
    }
    Ok(list)
}

/// A loss and where it counts.
struct Counted {
    spec: LossSpecification,
    /// Where the scene says it.
    at: String,
    /// Its factor in each run in which it counts.
    weight: f64,
    fields: Vec<usize>,
    wavelengths: Vec<usize>,
}

impl Counted {
    fn counts(&self, [field, wavelength]: [usize; 2]) -> bool {
        self.fields.contains(&field) && self.wavelengths.contains(&wavelength)
    }

    /// A loss that stands at this place of the scene.
    fn new(
        scene: &Scene,
        design: &Design,
        spec: LossSpecification,
        at: String,
    ) -> Result<Self, Fault> {
        let common = spec.common();
        let all = design.field.len().max(1);
        let fields = match common.field {
            None => (0..all).collect(),
            Some(given) => {
                let good = !given.is_empty() && given.iter().all(|field| *field < all);
                if !good {
                    let expected = format!("numbers of fields below {all}");
                    let found = format!("{given:?}");
                    return Err(scene.fault(&format!("{at}.field"), found, expected));
                }
                given.to_vec()
            }
        };
        let lengths = &scene.wavelength_um;
        let wavelengths: Vec<usize> = match common.wavelength_um {
            None => (0..lengths.len()).collect(),
            Some(given) => {
                let find = |one: &f64| lengths.iter().position(|length| length == one);
                let found: Option<Vec<usize>> = given.iter().map(find).collect();
                found.filter(|found| !found.is_empty()).ok_or_else(|| {
                    let expected = format!("wavelengths of the scene: {lengths:?}");
                    let path = format!("{at}.wavelength_um");
                    scene.fault(&path, format!("{given:?}"), expected)
                })?
            }
        };
        Ok(Self {
            weight: common.weight / (fields.len() * wavelengths.len()) as f64,
            fields,
            wavelengths,
            spec,
            at,
        })
    }
}

/// The losses of a scene; those of `[hologram]` where it lists none.
fn counted_losses(scene: &Scene, design: &Design) -> Result<Vec<Counted>, Fault> {
    if !design.loss.is_empty() {
        if design.efficiency.is_some() {
            let expected = "a [[design.loss]] of kind \"efficiency\"";
            let found = "a key for the picture of [hologram] beside [[design.loss]]";
            return Err(scene.fault("design.efficiency", found, expected));
        }
        let listed = design.loss.iter().enumerate();
        return listed
            .map(|(i, spec)| Counted::new(scene, design, spec.clone(), format!("design.loss[{i}]")))
            .collect();
    }
    if scene.hologram.is_none() {
        let expected = "a [[design.loss]], or the picture of a [hologram]";
        return Err(scene.fault("design.loss", "no loss", expected));
    }
    let likeness = PictureLoss {
        weight: 1.0,
        wavelength_um: None,
        field: None,
        picture: None,
        size_mm: None,
        care: Compared::Sensor,
        mask: None,
    };
    let mut list = vec![LossSpecification::Likeness(likeness)];
    let beta = design.efficiency.unwrap_or(BETA);
    if beta > 0.0 {
        list.push(LossSpecification::Efficiency(EfficiencyLoss {
            weight: beta,
            wavelength_um: None,
            field: None,
            picture: None,
            size_mm: None,
            at_mm: Vec::new(),
            radius_mm: None,
        }));
    }
    let at = || String::from("hologram");
    let counted = list
        .into_iter()
        .map(|spec| Counted::new(scene, design, spec, at()));
    counted.collect()
}

/// The factor of the efficiency where the scene says nothing.
const BETA: f64 = 0.01;

/// What counts as black, over the brightest.
const BLACK: f64 = 0.05;

/// One run's light and sensor.
struct Stage<'s> {
    scene: &'s Scene,
    wavelength: f64,
    raster: Raster,
    /// ∫|U|² of the light that gets into the first screen's aperture, in mm².
    power: f64,
}

/// A picture's file and size, as a loss names them.
#[derive(Clone, Copy)]
struct Named<'w> {
    picture: Option<&'w PathBuf>,
    /// Width and height in mm.
    size: Option<[f64; 2]>,
}

/// A picture's file and size of a loss.
fn named(picture: &Option<PathBuf>, size: Option<[f64; 2]>) -> Named<'_> {
    Named {
        picture: picture.as_ref(),
        size,
    }
}

impl<'s> Stage<'s> {
    fn new(scene: &'s Scene, system: &System) -> Result<Self, Fault> {
        let sensor = sensor_of(system)
            .map_err(|error| scene.fault("element", error.to_string(), "a sensor at the end"))?;
        Ok(Self {
            scene,
            wavelength: system.wavelength,
            raster: Raster::of(sensor),
            power: incident(system, scene.source.plane().is_some()),
        })
    }

    /// The area of a pixel of the sensor in mm².
    fn area(&self) -> f64 {
        self.raster.pitch[0] * self.raster.pitch[1]
    }

    /// A loss that the scene describes at this place.
    fn loss(&self, spec: &LossSpecification, at: &str) -> Result<Box<dyn FieldLoss>, Fault> {
        let refuse = |error: LossError| {
            let (key, expected) = match spec {
                LossSpecification::EncircledEnergy(_) => (".at_mm", "circles on the sensor"),
                LossSpecification::Spot(_) => (".at_mm", "points on the sensor"),
                LossSpecification::Efficiency(spec) if !spec.at_mm.is_empty() => {
                    (".at_mm", "circles on the sensor")
                }
                _ => ("", "a picture on the sensor that is not black"),
            };
            let found = error.to_string();
            self.scene.fault(&format!("{at}{key}"), found, expected)
        };
        match spec {
            LossSpecification::Likeness(spec) => {
                let named = named(&spec.picture, spec.size_mm);
                let loss =
                    self.likeness(named, spec.care, spec.mask.as_ref(), Brightness::Free, at)?;
                loss.map(|loss| Box::new(loss) as Box<dyn FieldLoss>)
            }
            LossSpecification::Mse(spec) => {
                let named = named(&spec.picture, spec.size_mm);
                let given = |scale: f64| Brightness::Given { scale };
                let brightness = spec.scale.map_or(Brightness::Sum, given);
                let loss = self.likeness(named, spec.care, spec.mask.as_ref(), brightness, at)?;
                loss.map(|loss| Box::new(loss) as Box<dyn FieldLoss>)
            }
            LossSpecification::Efficiency(spec) => self.efficiency(spec, at)?,
            LossSpecification::EncircledEnergy(spec) => self.circles(spec),
            LossSpecification::Spot(spec) => self.spot(spec),
            LossSpecification::Overlap(spec) => self.overlap(spec, at)?,
        }
        .map_err(refuse)
    }

    /// The picture that a loss compares with, and its outline, at the sensor's pixels.
    fn shown(&self, spec: &LossSpecification, at: &str) -> Result<Option<[Array2<f64>; 2]>, Fault> {
        let shown = match spec {
            LossSpecification::Likeness(spec) => named(&spec.picture, spec.size_mm),
            LossSpecification::Mse(spec) => named(&spec.picture, spec.size_mm),
            LossSpecification::Overlap(spec) => named(&spec.picture, spec.size_mm),
            _ => return Ok(None),
        };
        let target = self.target(shown, at)?;
        Ok(Some([target.on(&self.raster), self.outline(&target)]))
    }

    /// A picture and its size, or those of `[hologram]`.
    fn target(&self, named: Named, at: &str) -> Result<Target, Fault> {
        match (named.picture, named.size) {
            (None, None) => target(self.scene, hologram_of(self.scene)?),
            (Some(file), Some(size)) => Ok(Target {
                image: self.image(file, &format!("{at}.picture"))?,
                size,
                blur: [0.0; 2],
            }),
            _ => {
                let expected = "`picture` and `size_mm`, or neither for those of [hologram]";
                Err(self.scene.fault(at, "one without the other", expected))
            }
        }
    }

    fn image(&self, file: &Path, at: &str) -> Result<Array2<f64>, Fault> {
        picture_of(self.scene, file, at)
    }

    /// 1 within a picture's outline, [y, x].
    fn outline(&self, target: &Target) -> Array2<f64> {
        let inside = target.inside(&self.raster);
        inside.mapv(|inside| f64::from(u8::from(inside)))
    }

    fn likeness(
        &self,
        named: Named,
        care: Compared,
        mask: Option<&PathBuf>,
        brightness: Brightness,
        at: &str,
    ) -> Result<Result<Likeness, LossError>, Fault> {
        let target = self.target(named, at)?;
        let mut weight = match care {
            Compared::Sensor => None,
            Compared::Outline => Some(self.outline(&target)),
        };
        if let Some(mask) = mask {
            let mask = Target {
                image: self.image(mask, &format!("{at}.mask"))?,
                size: target.size,
                blur: [0.0; 2],
            };
            if mask.image.dim() != target.image.dim() {
                let size = |(rows, across): (usize, usize)| format!("{across} x {rows} pixels");
                let expected = format!("{}, as the picture has", size(target.image.dim()));
                let found = size(mask.image.dim());
                return Err(self.scene.fault(&format!("{at}.mask"), found, expected));
            }

            // Outside the mask everything counts, unless only the outline does.
            let inside = self.outline(&mask);
            let mask = mask.on(&self.raster) + inside.mapv(|inside| 1.0 - inside);
            let whole = Array2::ones(mask.dim());
            weight = Some(weight.unwrap_or(whole) * mask.mapv(|m| m.clamp(0.0, 1.0)));
        }
        Ok(Likeness::new(target.on(&self.raster), weight, brightness))
    }

    fn efficiency(
        &self,
        spec: &EfficiencyLoss,
        at: &str,
    ) -> Result<Result<Box<dyn FieldLoss>, LossError>, Fault> {
        let boxed = |share: Share| Box::new(share) as Box<dyn FieldLoss>;
        if let (false, Some(radius)) = (spec.at_mm.is_empty(), spec.radius_mm) {
            let share = Share::within(&self.raster, &spec.at_mm, radius, self.power);
            return Ok(share.map(boxed));
        }
        if !spec.at_mm.is_empty() || spec.radius_mm.is_some() {
            let expected = "`at_mm` and `radius_mm`, or neither for a picture";
            return Err(self.scene.fault(at, "one without the other", expected));
        }
        let target = self.target(named(&spec.picture, spec.size_mm), at)?;
        let (picture, mut lit) = (target.on(&self.raster), self.outline(&target));
        let most = picture.iter().fold(0.0f64, |most, value| most.max(*value));
        lit.zip_mut_with(&picture, |lit, value| {
            if *value < BLACK * most {
                *lit = 0.0;
            }
        });
        Ok(Share::efficiency(lit, self.power, self.area(), 1.0).map(boxed))
    }

    fn circles(&self, spec: &CirclesLoss) -> Result<Box<dyn FieldLoss>, LossError> {
        let share = Share::encircled(&self.raster, &spec.at_mm, spec.radius_mm, None)?;
        Ok(Box::new(share))
    }

    fn spot(&self, spec: &SpotLoss) -> Result<Box<dyn FieldLoss>, LossError> {
        let ideal = match spec.focal_length_mm {
            // A wave of unit amplitude over the area A makes |U| = A/λf in its focus.
            Some(focal) => (self.power / (self.wavelength * focal)).powi(2),
            None => self.power / self.area(),
        };
        let points: Vec<([f64; 2], f64)> = spec.at_mm.iter().map(|at| (*at, ideal)).collect();
        let spots = Spots::new(&self.raster, &points, spec.sharing, spec.evenness)?;
        Ok(Box::new(spots))
    }

    fn overlap(
        &self,
        spec: &OverlapLoss,
        at: &str,
    ) -> Result<Result<Box<dyn FieldLoss>, LossError>, Fault> {
        let target = self.target(named(&spec.picture, spec.size_mm), at)?;
        let mode = target.on(&self.raster);
        let mode = mode.mapv(|value| Complex64::from(value.max(0.0).sqrt()));
        let overlap = Overlap::new(&mode, self.power, self.area());
        Ok(overlap.map(|overlap| Box::new(overlap) as Box<dyn FieldLoss>))
    }
}

/// Cells along each axis in which the light on the first screen is summed.
const CELLS: usize = 400;

/// ∫|U|² of the light within the first screen's aperture and its pixels, in mm² for unit amplitude; 1 where
/// nothing limits it. Where it `is_source`, the screen makes the light: what it lets through counts.
fn incident(system: &System, is_source: bool) -> f64 {
    let open = Aperture::OPEN;
    let Some(screen) = system.screens.first().map(on_pixel_axes) else {
        return 1.0;
    };
    let (aperture, bounds) = match &screen.kind {
        ScreenKind::Doe(doe) => (&doe.aperture, doe.bounds()),
        ScreenKind::Stop(aperture) => (aperture, aperture.bounds()),
        ScreenKind::Sensor(_) => (&open, None),
    };
    let Some([x0, x1, y0, y1]) = bounds else {
        return 1.0;
    };
    let k = system.wavenumber() * screen.index;
    let [dx, dy] = [(x1 - x0) / CELLS as f64, (y1 - y0) / CELLS as f64];
    let mut total = 0.0;
    for j in 0..CELLS {
        for i in 0..CELLS {
            let (x, y) = (x0 + i as f64 * dx, y0 + j as f64 * dy);
            let share = aperture.coverage(x, x + dx, y, y + dy);
            if share > 0.0 {
                let middle = Vec3::new(x + 0.5 * dx, y + 0.5 * dy, 0.0);
                let light = system.source.field(screen.frame.to_global(middle), k);
                let made = match &screen.kind {
                    ScreenKind::Doe(doe) if is_source => doe.transmission(middle.x, middle.y),
                    _ => Complex64::ONE,
                };
                total += share * (light * made).norm_sqr() * dx * dy;
            }
        }
    }
    total
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use crate::file::model::build;
    use crate::file::model::design_targets::incident;
    use crate::file::scene::scene_file::Scene;

    /// A stop lit by a plane wave takes its area; by a point 2 mm away, πd²·log(1 + r²/d²).
    #[test]
    fn light_that_is_sent_out() {
        let text = |source: &str| {
            format!(
                "version = 1\nwavelength_um = 0.5\nsource = {source}\n[[element]]\nkind = \"stop\"\n\
                 thickness_mm = 1\naperture = {{ disc = {{ radius_mm = 0.3 }} }}\n[[element]]\n\
                 kind = \"sensor\"\npixels = [2, 2]\npitch_um = 1\n"
            )
        };
        let power = |source: &str| {
            let scene = Scene::parse(&text(source), Path::new("scene.toml")).unwrap();
            incident(&build::system(&scene, 0).unwrap(), false)
        };
        let area = std::f64::consts::PI * 0.09;
        assert!((power("{ kind = \"plane\" }") / area - 1.0).abs() < 1e-6);
        let found = power("{ kind = \"point\", position_mm = [0, 0, -2] }");
        let exact = std::f64::consts::PI * 4.0 * (1.0 + 0.09f64 / 4.0).ln();
        assert!((found / exact - 1.0).abs() < 1e-5, "{found} {exact}");
    }
}
