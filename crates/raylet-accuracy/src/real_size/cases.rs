//! The systems, what stands at their stops, and their fields.

use raylet::engine::plan::settings::Settings;
use raylet::file::decode::fault::Fault;
use raylet::file::model::build;
use raylet::file::scene::scene_file::Scene;
use raylet::math::vec3::Vec3;
use raylet::optics::aperture::Aperture;
use raylet::optics::doe::Layer;
use raylet::optics::phase::profile::Profile;
use raylet::optics::screen::{Screen, ScreenKind};
use raylet::optics::source::Source;
use raylet::optics::system::System;
use raylet_testkit::scenes::scene_path;

use crate::objective::masks::{binary_grating, cubic, random_pixels};
use crate::objective::ray_integral::chief_landing;

/// Period of the binary grating in mm.
const PERIOD: f64 = 0.02;

/// The targets of the second table.
pub const TARGETS: [f64; 4] = [1e-2, 1e-3, 1e-4, 1e-5];

/// Random pixels of 8 µm.
const RANDOM: Mask = Mask::Pixels(8e-3);

/// The mask at the stop of a system.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Mask {
    /// What its scene has there, under this name.
    Own(&'static str),
    /// Nothing.
    Bare,
    /// A vortex of charge 1.
    Vortex,
    /// A cubic phase of 20 waves.
    Cubic,
    /// A binary grating of phase 0 and π.
    Grating,
    /// Pixels of random phase, this wide in mm.
    Pixels(f64),
}

/// The reference of a case.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reference {
    /// The integral over the stop, with rays, on a block of pixels about the brightest one.
    Stop,
    /// The integral over the surface of a reflecting element, on pixels spread over the sensor. The source is the
    /// scene's.
    Surface,
}

/// A system with a mask and a field.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Case {
    /// Name of its scene file in the folder `real_size`, without the ending.
    pub scene: &'static str,
    /// The mask at its stop.
    pub mask: Mask,
    /// Angle of the light to the axis, in degrees, towards +x.
    pub angle_deg: f64,
    /// Vacuum wavelength in mm, where that is not the scene's.
    pub wavelength: Option<f64>,
    /// Radius of its stop in mm, where that is not the scene's.
    pub stop: Option<f64>,
    /// Target error, where that is not the scene's.
    pub target: Option<f64>,
    /// The reference with which raylet's field is compared.
    pub reference: Reference,
    /// Pixels along each side of the block on which the reference is evaluated.
    pub block: usize,
    /// Nodes of the reference along the radius of the stop and around it, where it has no pixels; of a stop that is no
    /// disc, cells along its width.
    pub nodes: [usize; 2],
    /// Cells of the reference along each side of a pixel. The edge of the stop cuts cells, which count with their open
    /// share: in steep light they have to be smaller than pixels.
    pub cells: usize,
}

impl Mask {
    /// Name of the mask in the table.
    pub fn name(self) -> String {
        match self {
            Mask::Own(name) => name.to_owned(),
            Mask::Bare => "bare".to_owned(),
            Mask::Vortex => "vortex".to_owned(),
            Mask::Cubic => "cubic, 20 waves".to_owned(),
            Mask::Grating => "binary grating of 20 µm".to_owned(),
            Mask::Pixels(pitch) => format!("random pixels of {:.0} µm", pitch * 1e3),
        }
    }

    /// What it adds to the optical direction cosines of the light that the sensor is to see: the grating has no light
    /// in order zero.
    fn kick(self, wavelength: f64) -> [f64; 2] {
        match self {
            Mask::Grating => [wavelength / PERIOD, 0.0],
            _ => [0.0; 2],
        }
    }

    /// Its layers over an aperture of this width and height in mm; nothing for the scene's own.
    fn layers(self, size: [f64; 2]) -> Option<Vec<Layer>> {
        Some(match self {
            Mask::Own(_) => return None,
            Mask::Bare => Vec::new(),
            Mask::Vortex => vec![Layer::Phase(Profile::Vortex { charge: 1 })],
            Mask::Cubic => vec![cubic(0.5 * size[0])],
            Mask::Grating => vec![binary_grating(size, PERIOD)],
            Mask::Pixels(pitch) => vec![random_pixels(size, pitch)],
        })
    }
}

impl Case {
    const fn new(scene: &'static str, mask: Mask, angle_deg: f64) -> Self {
        Self {
            scene,
            mask,
            angle_deg,
            wavelength: None,
            stop: None,
            target: None,
            reference: Reference::Stop,
            block: 32,
            nodes: [100, 240],
            cells: 1,
        }
    }

    /// What stands at its stop, in the table.
    pub fn place(&self) -> String {
        let mask = self.mask.name();
        match (self.stop, self.wavelength) {
            (Some(radius), _) => format!("{mask}, {:.1} mm wide", 2.0 * radius),
            (None, Some(wavelength)) => format!("{mask}, λ = {:.4} µm", wavelength * 1e3),
            (None, None) => mask,
        }
    }

    /// A word that names it.
    pub fn key(&self) -> String {
        let mask = self.place().replace([',', '='], "").replace(' ', "-");
        let target = self
            .target
            .map_or(String::new(), |target| format!("/{target:e}"));
        format!("{}/{mask}/{}{target}", self.scene, self.angle_deg)
    }

    /// The system, its sensor about the chief ray, and the settings of its run.
    ///
    /// # Errors
    /// When the scene has a fault.
    pub fn system(&self) -> Result<(System, Settings), Fault> {
        let mut scene = Scene::read(&scene_path(&format!("real_size/{}", self.scene)))?;
        if let Some(wavelength) = self.wavelength {
            scene.wavelength_um = vec![wavelength * 1e3];
        }
        if let Some(target) = self.target {
            scene.settings.target_error = target;
        }
        let mut system = build::system(&scene, 0)?;
        if self.reference == Reference::Surface {
            return Ok((system, build::settings(&scene)));
        }
        let origin = system.screens[0].frame.origin;
        let lit = Source::collimated([self.angle_deg.to_radians(), 0.0], origin);
        system.source = lit.unwrap_or(system.source);
        let stop = system.screens.len() - 2;
        if let (ScreenKind::Doe(doe), Some(radius)) = (&mut system.screens[stop].kind, self.stop) {
            doe.aperture = Aperture::disc(radius);
        }
        put(self.mask, &mut system.screens[stop]);
        let landing = chief_landing(&system, self.mask.kick(system.wavelength));
        if let (Some([x, y]), Some(sensor)) = (landing, system.screens.last_mut()) {
            sensor.frame = sensor.frame.moved(Vec3::new(x, y, 0.0));
        }
        Ok((system, build::settings(&scene)))
    }
}

/// Puts a mask at a stop, in place of what is there.
fn put(mask: Mask, stop: &mut Screen) {
    let Some([x0, x1, y0, y1]) = stop.bounds() else {
        return;
    };
    if let (ScreenKind::Doe(doe), Some(layers)) = (&mut stop.kind, mask.layers([x1 - x0, y1 - y0]))
    {
        doe.layers = layers;
    }
}

/// All cases, in the order of the table.
pub fn cases() -> Vec<Case> {
    let mut all = photographic();
    all.extend(flat_elements());
    all.extend(hybrids());
    all.extend(telescopes());
    all.extend(phone_lens());
    all.push(combiner());
    all
}

/// Systems whose errors follow their targets, in the order of the second table: each at every target.
pub fn convergence() -> Vec<Case> {
    let cubic = Mask::Own("cubic, 5 waves");
    let systems = [
        ("cooke_triplet", Mask::Bare, 0.0, [100, 240]),
        ("cooke_triplet", Mask::Cubic, 20.0, [200, 480]),
        (
            "double_gauss",
            Mask::Own("kinoform, f = 5 m"),
            10.0,
            [100, 240],
        ),
        ("metalens", Mask::Own("hyperbolic phase"), 10.0, [300, 600]),
        (
            "hybrid_asphere",
            Mask::Own("kinoform on its front"),
            0.0,
            [200, 480],
        ),
        ("telescope_doublet", Mask::Bare, 0.5, [100, 240]),
        ("phone_lens", cubic, 20.0, [150, 360]),
    ];
    let at = |target: f64| {
        systems.map(|(scene, mask, angle, nodes)| Case {
            nodes,
            target: Some(target),
            ..Case::new(scene, mask, angle)
        })
    };
    let all = TARGETS.map(at);
    (0..systems.len())
        .flat_map(|number| all.map(|cases| cases[number]))
        .collect()
}

/// Photographic objectives.
fn photographic() -> Vec<Case> {
    let mut all = Vec::new();
    for mask in [Mask::Bare, Mask::Vortex, Mask::Cubic, Mask::Grating, RANDOM] {
        let nodes = match mask {
            Mask::Cubic => [200, 480],
            _ => [100, 240],
        };
        for angle in [0.0, 14.0, 20.0] {
            let case = Case::new("cooke_triplet", mask, angle);
            all.push(Case { nodes, ..case });
        }
    }
    for angle in [0.0, 10.0, 14.0] {
        let kinoform = Mask::Own("kinoform, f = 5 m");
        all.push(Case::new("double_gauss", kinoform, angle));
    }
    // Farther out than this, the front group lets no light reach the stop.
    for (angle, stop) in [(0.0, None), (10.0, Some(15.0)), (14.0, Some(13.0))] {
        let corrector = Mask::Own("kinoform, f = 5 m, against spherical aberration");
        let case = Case::new("double_gauss_f2", corrector, angle);
        let nodes = [400, 960];
        all.push(Case {
            stop,
            nodes,
            ..case
        });
    }
    all
}

/// A metalens, a modulator before a camera, and elements behind a strong lens.
fn flat_elements() -> Vec<Case> {
    let mut all = Vec::new();
    for (angle, nodes) in [(0.0, [100, 240]), (10.0, [300, 600]), (20.0, [600, 1200])] {
        let case = Case::new("metalens", Mask::Own("hyperbolic phase"), angle);
        all.push(Case { nodes, ..case });
    }
    for mask in [Mask::Own("array of spots, 8 bits"), RANDOM] {
        let case = Case::new("slm_camera", mask, 0.0);
        all.push(Case { block: 16, ..case });
    }
    for mask in [Mask::Bare, Mask::Vortex, Mask::Pixels(4e-3)] {
        let case = Case::new("behind_strong_lens", mask, 0.0);
        all.push(Case { cells: 3, ..case });
    }
    all
}

/// The F and C lines in mm, beside the d line of the scenes.
const LINES: [f64; 2] = [0.486_132_7e-3, 0.656_272_5e-3];

/// Lenses with a kinoform on one of their faces, in three colours.
fn hybrids() -> Vec<Case> {
    let mut all = Vec::new();
    let lenses = [
        ("hybrid_asphere", "kinoform on its front", 3.0, [200, 480]),
        ("hybrid_achromat", "kinoform on its back", 5.0, [100, 240]),
    ];
    for (scene, mask, aside, nodes) in lenses {
        for (angle, line) in [
            (0.0, None),
            (aside, None),
            (0.0, Some(LINES[0])),
            (0.0, Some(LINES[1])),
        ] {
            let case = Case::new(scene, Mask::Own(mask), angle);
            all.push(Case {
                nodes,
                wavelength: line,
                ..case
            });
        }
    }
    all
}

/// Telescopes with lenses and with mirrors.
fn telescopes() -> Vec<Case> {
    let mut all = Vec::new();
    for angle in [0.0, 0.5] {
        all.push(Case::new("telescope_doublet", Mask::Bare, angle));
    }
    for angle in [0.0, 0.5] {
        let case = Case::new("cassegrain", Mask::Own("spider of four vanes"), angle);
        let nodes = [800, 800];
        all.push(Case { nodes, ..case });
    }
    all
}

/// Lenses of telephones, bare and with a cubic phase.
fn phone_lens() -> Vec<Case> {
    let mut all = Vec::new();
    for (mask, nodes) in [
        (Mask::Bare, [100, 240]),
        (Mask::Own("cubic, 5 waves"), [150, 360]),
    ] {
        for angle in [0.0, 20.0, 35.0] {
            let case = Case::new("phone_lens", mask, angle);
            all.push(Case { nodes, ..case });
        }
    }
    for angle in [0.0, 17.0] {
        let case = Case::new("phone_patent", Mask::Own("cubic, 5 waves"), angle);
        all.push(Case {
            nodes: [150, 360],
            ..case
        });
    }
    all
}

/// A hologram that reflects a display into the eye.
fn combiner() -> Case {
    let hologram = Mask::Own("hologram of a point, reflecting");
    Case {
        reference: Reference::Surface,
        block: 3,
        nodes: [18000, 30000],
        ..Case::new("combiner", hologram, 0.0)
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use raylet::optics::screen::ScreenKind;

    use crate::real_size::cases::cases;

    #[test]
    fn every_case_has_a_system_and_a_name_of_its_own() {
        let all = cases();
        let names: BTreeSet<String> = all.iter().map(|case| case.key()).collect();
        assert_eq!(names.len(), all.len());
        for case in &all {
            let (system, _) = case.system().unwrap();
            let last = system.screens.last().unwrap();
            assert!(matches!(last.kind, ScreenKind::Sensor(_)), "{}", case.key());
        }
    }
}
