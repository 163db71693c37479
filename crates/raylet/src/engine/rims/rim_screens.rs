//! Rims of surfaces inside a train: which cut light, and what becomes of them.
//!
//! A hard edge diffracts, and rays accepted or refused one by one do not. So a rim that cuts light becomes a
//! screen where the surface is small enough for its whole aperture to be sampled: the field is summed on the
//! plane of the rim, in the medium behind the surface, reached by free flight (backward where the rim bulges
//! forward), cut there with exactly weighted edges, and sent on. Where the rim lies in no plane, the field is summed and cut on
//! the surface itself. A rim counts when the root of the share of
//! energy that it cuts, of what would land on the target, is more than half the target error: a safe bound of
//! the error of leaving it out. Rims of larger surfaces accept or refuse each beamlet by its chief ray; the
//! energy that this puts on the wrong side of the edge is in the error budget. Local bands need no samples of a whole aperture:
//! where they carry the light, a rim that cuts a noticeable part of it is a screen at any size (`of_any_size`).

use crate::engine::plan::settings::Settings;
use crate::engine::rims::edge_diffraction::edge_waves;
use crate::engine::rims::entrance_edge::{entrance_at_rim, is_entrance_edge};
use crate::engine::rims::joined_screens::{joined, joining_hops};
use crate::engine::rims::onward::Onward;
use crate::engine::rims::pixel_light::PixelValues;
use crate::engine::rims::rim_light::{Cut, cut_shares};
use crate::engine::rims::source_ray::SourceRay;
use crate::engine::rims::source_rays::{rays_behind, source_rays};
use crate::math::vec3::Vec3;
use crate::optics::aperture::Outline;
use crate::optics::frame::Frame;
use crate::optics::refraction::Interface;
use crate::optics::screen::{Screen, ScreenKind};
use crate::optics::shape::Shape;
use crate::optics::surface::Surface;
use crate::optics::system::{Hop, System};

/// Most samples along a rim's diameter, at λ/(3n), where memory allows them.
const AFFORDABLE: f64 = 2500.0;

/// Most samples along a rim that lies in no plane: light is summed on many planes about its surface.
const ON_SURFACE: f64 = 800.0;

/// The part of the light that a rim of any size cuts from where on it is a screen for local bands. They take a second or two
/// for such a screen; rims that only light of edges and pixels meets would be many.
const NOTICEABLE: f64 = 1e-3;

/// Share of the target error that a rim which is left out may cost.
const SHARE: f64 = 0.5;

/// How a run treats a rim.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RimTreatment {
    /// It is a screen, and diffracts.
    Screen,
    /// It cuts too little to matter; what meets it is cut ray by ray.
    Ignored,
    /// It cuts light ray by ray, without diffraction, though it matters.
    ByRay(NoScreen),
    /// It is the edge of the entrance before it, which diffracts.
    Entrance,
}

/// Why a rim that cuts light is no screen.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NoScreen {
    /// It lies in no plane, and its surface does not exist everywhere within it.
    Absent,
    /// It takes more samples along its diameter than are allowed.
    TooLarge {
        /// Samples along its diameter.
        samples: usize,
        /// Samples allowed.
        allowed: usize,
    },
}

/// The rim of a surface.
#[derive(Clone, Debug, PartialEq)]
pub struct Rim {
    /// Name of the rim, which is also that of its screen if it has one.
    pub name: String,
    /// The hop in which its surface stands, of the system in which rims that matter are screens.
    pub hop: usize,
    /// Share of the energy on its way to the target that it cuts, by beamlets along rays of the source.
    pub cut: f64,
    /// Share of that energy which the decision by chief rays puts on the wrong side of the edge.
    pub misplaced: f64,
    /// Share of that energy by which a cut in the plane of the rim differs from one along the surface; zero for a rim that
    /// is not cut in a plane.
    pub difference: f64,
    /// What light aslant adds to the relative error of that difference; zero likewise.
    pub aslant: f64,
    /// Share of the light behind the screen before the rim that is on its way to the target, by rays of the source.
    pub landing: f64,
    /// Whether of that light only what goes on to the sensor counts.
    pub to_sensor: bool,
    /// How the run treats it.
    pub treatment: RimTreatment,
}

impl Rim {
    /// √cut, which the error of leaving the rim out does not exceed.
    pub fn bound(&self) -> f64 {
        self.cut.sqrt()
    }

    /// The expected error of a rim that clips single rays though it matters; zero of others. The light that
    /// is wrongly kept or lost is taken to be incoherent with the rest: it counts by the root of its energy.
    pub fn error(&self) -> f64 {
        match self.treatment {
            RimTreatment::Screen | RimTreatment::Ignored | RimTreatment::Entrance => 0.0,
            RimTreatment::ByRay(_) => self.misplaced.sqrt(),
        }
    }
}

/// A system in which rims that matter are screens, and screens in one place are one, as it is run.
#[derive(Clone, Debug)]
pub struct Rimmed {
    /// The system.
    pub system: System,
    /// The rims of all its surfaces that have one, along the way of the light.
    pub rims: Vec<Rim>,
    /// What the rim of each surface of the system as it was given cuts, hop by hop.
    cuts: Vec<Vec<Cut>>,
    /// The root of what a rim cuts above which it matters.
    limit: f64,
    /// Most samples along the diameter of a rim that becomes a screen.
    affordable: f64,
    /// Whether rims that cut a noticeable part of the light become screens at any size.
    any_size: bool,
    /// Which hops of the system as it was given join their screens.
    joining: Vec<bool>,
    /// Where the screens of the system as it was given stand among those of [`Rimmed::system`], and whether they have pixels
    /// that may vary.
    own: Vec<(usize, bool)>,
}

/// The system with a screen at every rim that matters and is small enough, and one screen in place of those that stand in one
/// place, for the pixels as they are or for all that they may become.
pub fn with_rims(system: &System, settings: &Settings, values: PixelValues) -> Rimmed {
    with_rims_joining(system, settings, values, joining_hops(system, values))
}

/// The same, where hops that are `joining` join their screens.
pub(crate) fn with_rims_joining(
    given: &System,
    settings: &Settings,
    values: PixelValues,
    joining: Vec<bool>,
) -> Rimmed {
    let system = &joined(given, &joining).0;
    let mut light = source_rays(system);
    let cuts = system.hops().enumerate().map(|(number, hop)| {
        let onward = Onward::behind(system, number);
        let leaving = light_behind(&hop, &light, values);
        cut_shares(&hop, &onward, &leaving, &mut light, settings)
    });
    let empty = Rimmed {
        system: system.clone(),
        rims: Vec::new(),
        cuts: cuts.collect(),
        limit: SHARE * settings.target_error,
        affordable: AFFORDABLE.min((settings.samples_allowed() as f64).sqrt()),
        any_size: false,
        joining,
        own: Vec::new(),
    };
    empty.filled(given)
}

impl Rimmed {
    /// The names of screens of the system as it was given that stand in one place and act as one.
    pub fn joined<'a>(&self, given: &'a System) -> Vec<Vec<&'a str>> {
        let own = given.screens.iter().zip(&self.own);
        let mut groups: Vec<(usize, Vec<&str>)> = Vec::new();
        for (screen, (at, _)) in own {
            match groups.last_mut().filter(|(place, _)| place == at) {
                Some((_, names)) => names.push(&screen.name),
                None => groups.push((*at, vec![&screen.name])),
            }
        }
        let names = groups.into_iter().map(|(_, names)| names);
        names.filter(|names| names.len() > 1).collect()
    }

    /// The first hop behind a screen of the system as it was given, by the number of the hop there.
    pub(crate) fn hop_of_given(&self, number: usize) -> usize {
        self.own.get(number).map_or(0, |(at, _)| *at)
    }

    /// The same, for local bands, with a screen at each rim that cuts a noticeable part of the light and is too large for whole
    /// fields; nothing where there is none.
    pub(crate) fn of_any_size(&self, given: &System) -> Option<Self> {
        let open = Self {
            any_size: true,
            ..self.clone()
        };
        let wide = open.filled(given);
        (wide.system.screens.len() > self.system.screens.len()).then_some(wide)
    }

    /// Whether rims of any size are screens.
    pub(crate) fn is_of_any_size(&self) -> bool {
        self.any_size
    }

    /// Most samples along the diameter of a rim that becomes a screen, in a plane and on a surface.
    fn affordable_for(&self, cut: &Cut) -> [f64; 2] {
        match self.any_size && cut.clipped > NOTICEABLE {
            true => [f64::INFINITY; 2],
            false => [self.affordable, self.affordable.min(ON_SURFACE)],
        }
    }

    /// A slightly changed system with screens at the same rims.
    pub(crate) fn like(&self, system: &System) -> System {
        self.clone().filled(system).system
    }

    /// What is known of each screen that has pixels, by the screens of the system as it was given.
    pub(crate) fn of_given<T>(&self, mut found: Vec<Option<T>>) -> Vec<Option<T>> {
        let own = self.own.iter();
        own.map(|(at, has_pixels)| found.get_mut(*at).filter(|_| *has_pixels)?.take())
            .collect()
    }

    /// The relative error to expect of the edge wave of the rim for which screen `number` stands; zero for other screens. Rays
    /// of the source give the light of the edge wave. What else lands beside it is taken from them too, unless `share` knows
    /// which share of the light behind one screen lands on another.
    pub(crate) fn edge_error(
        &self,
        number: usize,
        share: impl Fn(usize, usize) -> Option<f64>,
    ) -> f64 {
        let is_rim = |screen: usize, rim: &Rim| match rim.treatment {
            RimTreatment::Screen => rim.hop + 1 == screen,
            RimTreatment::Entrance => screen == 0,
            RimTreatment::Ignored | RimTreatment::ByRay(_) => false,
        };
        let Some(rim) = self.rims.iter().find(|rim| is_rim(number, rim)) else {
            return 0.0;
        };

        // The light goes from the screen before the rim to the next one that is no rim.
        let given =
            |screen: &usize| *screen == 0 || !self.rims.iter().any(|rim| is_rim(*screen, rim));
        let last = self.system.screens.len() - 1;
        let from = (0..=rim.hop).rev().find(given).unwrap_or(0);
        let to = (number + 1..=last).find(given).unwrap_or(last);
        let known = share(from, to).filter(|_| !rim.to_sensor);
        let scale = known.map_or(1.0, |share| rim.landing / share);
        (rim.difference * scale).sqrt().hypot(rim.aslant)
    }

    /// The same choices made for the rims of a system, from its first hop on.
    fn filled(mut self, given: &System) -> Self {
        let (system, places) = joined(given, &self.joining);
        self.system = System {
            screens: vec![],
            trains: vec![],
            ..system.clone()
        };
        self.rims.clear();
        let mut at = Vec::new();
        for (number, hop) in system.hops().enumerate() {
            let cuts = self.cuts.get(number).cloned().unwrap_or_default();
            at.push(self.system.screens.len());
            let along = number == 0 && is_entrance_edge(&hop, &system.source, self.limit);
            let at_rim = (number == 0 && !along).then(|| entrance_at_rim(&hop, &system.source));
            match at_rim.flatten() {
                Some(from) => self.add(&Hop { from: &from, ..hop }, &cuts, true),
                None => self.add(&hop, &cuts, along),
            }
        }
        self.system.screens.extend(system.screens.last().cloned());

        // Of the screens that light leaves.
        let screens = given.screens.iter().zip(places);
        let has_pixels = |screen: &Screen| matches!(&screen.kind, ScreenKind::Doe(doe) if doe.free_pixels().is_some());
        self.own = screens
            .filter_map(|(screen, place)| Some((*at.get(place)?, has_pixels(screen))))
            .collect();
        self
    }

    /// Adds a hop whose rims cut these shares of the energy; the first may be `merged` with the edge of the entrance.
    fn add(&mut self, hop: &Hop, cuts: &[Cut], merged: bool) {
        self.system.screens.push(hop.from.clone());
        let mut train = Vec::new();
        for (number, (surface, &cut)) in hop.train.iter().zip(cuts).enumerate() {
            let matters = cut.removed.sqrt() > self.limit;
            let entrance = merged && number == 0;
            let rim = rim_of(hop, number, self.affordable_for(&cut));
            if surface.aperture.outline != Outline::Open {
                self.rims.push(Rim {
                    name: name_of(hop, number),
                    hop: self.system.trains.len(),
                    cut: cut.removed,
                    misplaced: cut.misplaced,
                    difference: match rim_plane(surface) {
                        Some(_) if entrance => cut.difference.inside(),
                        Some(_) => cut.difference.fainter(),
                        None => 0.0,
                    },
                    aslant: rim_plane(surface).map_or(0.0, |_| cut.aslant),
                    landing: cut.landing,
                    to_sensor: cut.to_sensor,
                    treatment: match &rim {
                        _ if entrance => RimTreatment::Entrance,
                        _ if !matters => RimTreatment::Ignored,
                        Ok(_) => RimTreatment::Screen,
                        Err(reason) => RimTreatment::ByRay(*reason),
                    },
                });
            }
            match rim.ok().filter(|_| matters && !entrance) {
                None if entrance => train.push(surface.without_edge()),
                Some(screen) => {
                    train.push(surface.without_edge());
                    self.system.trains.push(std::mem::take(&mut train));
                    self.system.screens.push(screen);
                }
                None => train.push(surface.clone()),
            }
        }
        self.system.trains.push(train);
    }
}

/// What a rim is called.
fn name_of(hop: &Hop, number: usize) -> String {
    format!("rim {} behind {}", number + 1, hop.from.name)
}

/// The screen of a surface's rim, if it takes no more samples along its longer side than are affordable: in the plane of the rim
/// where that is a centred disc on a surface of revolution, otherwise on the surface itself, which takes whole fields more time.
fn rim_of(hop: &Hop, number: usize, [in_plane, on_surface]: [f64; 2]) -> Result<Screen, NoScreen> {
    let surface = &hop.train[number];
    let after = surface.index[1];
    let plane = rim_plane(surface);
    let affordable = match plane {
        Some(_) => in_plane,
        None => on_surface,
    };
    let bounds = surface.aperture.bounds().ok_or(NoScreen::Absent)?;
    let side = (bounds[1] - bounds[0]).max(bounds[3] - bounds[2]);
    let samples = side * 3.0 * after / hop.wavelength;
    if samples > affordable {
        return Err(NoScreen::TooLarge {
            samples: samples as usize,
            allowed: affordable as usize,
        });
    }
    let (frame, shape) = plane.unwrap_or((surface.frame, surface.shape.clone()));
    let screen = Screen {
        name: name_of(hop, number),
        frame,
        kind: ScreenKind::Stop(surface.aperture.clone()),
        index: after,
        behind: None,
        shape,
        arrives: side_behind(hop, number),
    };
    screen.relief().ok_or(NoScreen::Absent)?;
    Ok(screen)
}

/// The plane in which the rim of a surface lies; nothing where it lies in none.
fn rim_plane(surface: &Surface) -> Option<(Frame, Shape)> {
    if surface.shape == Shape::Plane {
        return Some((surface.frame, Shape::Plane));
    }
    let Outline::Disc { radius } = surface.aperture.outline else {
        return None;
    };
    if surface.aperture.centre != [0.0; 2] || !surface.shape.is_round() {
        return None;
    }
    let sag = surface.shape.height(radius, 0.0)?.z;
    let frame = surface.frame.moved(Vec3::new(0.0, 0.0, sag));
    Some((frame, Shape::Plane))
}

/// +1 when the light along the axis leaves a surface towards its +z, else −1.
fn side_behind(hop: &Hop, number: usize) -> f64 {
    let mut way = hop.from.frame.z * hop.from.leaves();
    for surface in &hop.train[..=number] {
        if surface.interface == Interface::Reflect {
            let normal = surface.frame.z;
            way = way + normal * (-2.0 * way.dot(normal));
        }
    }
    way.dot(hop.train[number].frame.z).signum()
}

/// The error to expect from the rims that cut light ray by ray in a hop.
pub(crate) fn cut_by_ray(rims: &[Rim], hop: usize) -> f64 {
    let here = rims.iter().filter(|rim| rim.hop == hop);
    here.map(Rim::error).fold(0.0, f64::hypot)
}

/// The rays that leave a screen, those that its edge diffracts among them.
fn light_behind(hop: &Hop, light: &[SourceRay], values: PixelValues) -> Vec<SourceRay> {
    let mut leaving = rays_behind(hop, light, values);
    leaving.extend(edge_waves(hop, light));
    leaving
}
