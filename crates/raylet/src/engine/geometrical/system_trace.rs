//! Single rays through a whole system by geometrical optics, surface by surface.
//!
//! A smooth element turns a ray by the gradient of its phase φ and adds φ/k to its path; pixels and sums, whose
//! phase has no gradient of this kind, let it go straight on.

use crate::engine::trace::ray_sensitivity::{BLOCK, Number, Variation, VariedHop};
use crate::engine::trace::ray_trace::Landing;
use crate::math::real::Real;
use crate::math::vec3::Vec3;
use crate::optics::deflection::deflected;
use crate::optics::frame::Axes;
use crate::optics::ray::Loss;
use crate::optics::screen::{Screen, ScreenKind};
use crate::optics::source::Source;
use crate::optics::system::System;
use crate::wave::beamlet::wavelet::{Companion, Encounter};

/// A ray where it meets a screen or surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RayHit {
    /// Point where they meet, in mm, global.
    pub point: Vec3,
    /// Unit direction in which it goes on, global.
    pub direction: Vec3,
    /// Optical path up to there in mm, from where the source's phase is zero.
    pub path: f64,
}

/// A ray that was followed.
#[derive(Clone, Debug, PartialEq)]
pub struct SystemRay {
    /// The screens and surfaces that it met, in order.
    pub hits: Vec<RayHit>,
    /// Reason why it was lost before the sensor; `None` if it arrived.
    pub lost: Option<Loss>,
}

/// The record of a ray under way.
struct Log {
    hits: Vec<RayHit>,
    direction: Vec3,
    path: f64,
    /// Whether the ray is where it was met last, so that the next visit records nothing new.
    stands: bool,
}

impl<T: Real> Companion<T> for Log {
    fn fly(&mut self, length: T, index: T) {
        self.path += length.value() * index.value();
    }
    fn refract<A: Axes<T>>(&mut self, encounter: &Encounter<T, A>) {
        self.direction = encounter
            .frame
            .direction_to_global(encounter.refracted.direction)
            .value();
        if let Some(last) = self.hits.last_mut() {
            last.direction = self.direction;
        }
    }
    fn visit(&mut self, point: Vec3<T>) {
        if std::mem::take(&mut self.stands) {
            return;
        }
        self.hits.push(RayHit {
            point: point.value(),
            direction: self.direction,
            path: self.path,
        });
    }
}

/// The ray of the light of `source` that meets the first screen above its local (x, y).
pub fn trace_system(system: &System, source: &Source, at: [f64; 2]) -> SystemRay {
    let (mut log, mut at, mut p) = match launch(system, source, at) {
        Ok(start) => start,
        Err(lost) => {
            return SystemRay {
                hits: Vec::new(),
                lost: Some(lost),
            };
        }
    };
    let mut lost = None;
    for hop in system.hops() {
        let step = deflected_at(hop.from, system.wavenumber(), at, p).and_then(|(p, added)| {
            log.go_on(outwards(hop.from, p), added);
            hop.trace(at, p, &mut log)
        });
        match step {
            Ok(landing) => (at, p) = (landing.at, landing.cosines),
            Err(loss) => {
                lost = Some(loss);
                break;
            }
        }
    }
    let hits = log.hits;
    SystemRay { hits, lost }
}

/// Where a ray meets the first screen of a system, on the screen's axes; `start` in mm and the unit `direction` are global.
///
/// # Errors
/// [`Loss::Missed`] if it meets no point of the screen, or only one behind its start; as a surface otherwise.
pub fn first_meeting(system: &System, start: Vec3, direction: Vec3) -> Result<[f64; 2], Loss> {
    let screen = system.screens.first().ok_or(Loss::Missed)?;
    let [point, along] = [
        screen.frame.to_local(start),
        screen.frame.direction_to_local(direction),
    ];
    let length = screen.shape.meet(point, along)?;
    // A start on the screen itself is met there.
    let rounding = START * (1.0 + point.norm());
    match length.is_finite() && length >= -rounding {
        true => {
            let met = point + along * length;
            Ok([met.x, met.y])
        }
        false => Err(Loss::Missed),
    }
}

/// Rounding of a start, over its distance.
const START: f64 = 1e-9;

impl Log {
    /// The screen where the ray stands sends it on in a direction, and adds to its path.
    fn go_on(&mut self, direction: Vec3, added: f64) {
        self.direction = direction;
        self.path += added;
        self.stands = true;
        if let Some(last) = self.hits.last_mut() {
            last.direction = direction;
            last.path = self.path;
        }
    }
}

/// A ray of the light of `source` above (x, y) in mm of the first screen.
///
/// # Errors
/// [`Loss::Missed`] where that screen does not exist.
pub(crate) fn starting_hit(system: &System, source: &Source, at: [f64; 2]) -> Result<RayHit, Loss> {
    let screen = system.screens.first().ok_or(Loss::Missed)?;
    let height = screen.height(at).ok_or(Loss::Missed)?;
    let point = screen.frame.to_global(Vec3::new(at[0], at[1], height.z));
    Ok(RayHit {
        point,
        direction: source.direction(point),
        path: source.path(point, screen.index),
    })
}

/// The same with its optical cosines on the screen's axes.
fn launch(
    system: &System,
    source: &Source,
    at: [f64; 2],
) -> Result<(Log, [f64; 2], [f64; 2]), Loss> {
    let hit = starting_hit(system, source, at)?;
    let screen = system.screens.first().ok_or(Loss::Missed)?;
    let local = screen.frame.direction_to_local(hit.direction);
    let log = Log {
        direction: hit.direction,
        path: hit.path,
        hits: vec![hit],
        stands: false,
    };
    Ok((log, at, [local.x * screen.index, local.y * screen.index]))
}

/// The global direction behind a screen of a ray with optical cosines p.
fn outwards(screen: &Screen, [px, py]: [f64; 2]) -> Vec3 {
    let n = screen.index_behind();
    let along = (n * n - px * px - py * py).max(0.0).sqrt() * screen.leaves();
    screen
        .frame
        .direction_to_global(Vec3::new(px, py, along) * (1.0 / n))
}

/// Whether the aperture of a screen contains the point (x, y) in mm on its axes; a sensor contains all points.
pub(crate) fn passes(screen: &Screen, at: [f64; 2]) -> bool {
    match &screen.kind {
        ScreenKind::Stop(aperture) => aperture.contains(at[0], at[1]),
        ScreenKind::Doe(doe) => doe.aperture.contains(at[0], at[1]),
        ScreenKind::Sensor(_) => true,
    }
}

/// Optical cosines of a ray behind a screen, and what its path gains there.
pub(crate) fn deflected_at(
    screen: &Screen,
    k: f64,
    at: [f64; 2],
    p: [f64; 2],
) -> Result<([f64; 2], f64), Loss> {
    if !passes(screen, at) {
        return Err(Loss::Clipped);
    }
    let ScreenKind::Doe(doe) = &screen.kind else {
        return Ok((p, 0.0));
    };
    // Pixels spread light about the direction in which it came: rays go straight on. Of a profile with several orders they
    // follow the strongest.
    let gradient = doe.ray_gradient(at[0], at[1]);
    let kick = gradient.unwrap_or_default().map(|g| g / k);
    let turned = deflected(screen, at, p, kick).ok_or(Loss::Evanescent)?;
    let phase = doe.ray_phase(at[0], at[1]).unwrap_or(0.0);
    Ok((turned, phase / k))
}

/// How rays through a system change with parameters.
pub struct RaySensitivity<'a> {
    system: &'a System,
    /// The hops of each block of parameters, and how many parameters it has; nothing where a variation has fewer hops.
    blocks: Vec<(usize, Option<Vec<VariedHop<'a>>>)>,
}

impl<'a> RaySensitivity<'a> {
    /// The parts of a system as they move and bend with each parameter.
    pub fn new(system: &'a System, variations: &'a [Variation]) -> Self {
        let varied = |block: &'a [Variation]| {
            let hops = system.hops().enumerate();
            let varied = hops.map(|(number, hop)| {
                let perturbed = block.iter().map(|variation| variation.hop(number));
                Some(VariedHop::new(hop, &perturbed.collect::<Option<Vec<_>>>()?))
            });
            (block.len(), varied.collect())
        };
        Self {
            system,
            blocks: variations.chunks(BLOCK).map(varied).collect(),
        }
    }

    /// Derivatives of one ray on the sensor with respect to each parameter: of x and y on the sensor's axes (mm), of
    /// its optical cosines there, and of its optical path (mm). It starts at a fixed place of the first screen.
    /// Nothing where it is lost.
    pub fn of(&self, source: &Source, at: [f64; 2]) -> Option<Vec<[f64; 5]>> {
        let mut all = Vec::new();
        for (count, hops) in &self.blocks {
            let landing = self.landing(hops.as_ref()?, source, at)?;
            let [x, y] = landing.at;
            let [p, q] = landing.cosines;
            let of = |i: usize| [x, y, p, q, landing.path].map(|number| number.tangent[i]);
            all.extend((0..*count).map(of));
        }
        Some(all)
    }

    /// One ray on the sensor with its tangents; nothing where it is lost, or where an element turns it, whose own
    /// derivatives are not included.
    fn landing(
        &self,
        hops: &[VariedHop],
        source: &Source,
        at: [f64; 2],
    ) -> Option<Landing<Number>> {
        let (_, at, p) = launch(self.system, source, at).ok()?;
        let mut at = at.map(Number::constant);
        let mut p = p.map(Number::constant);
        let mut path = Number::constant(0.0);
        let mut last = None;
        for (varied, hop) in hops.iter().zip(self.system.hops()) {
            let open = passes(hop.from, at.map(|v| v.value));
            if !open || matches!(hop.from.kind, ScreenKind::Doe(_)) {
                return None;
            }
            let landing = varied.trace(at, p).ok()?;
            (at, p, path) = (landing.at, landing.cosines, path + landing.path);
            last = Some(Landing { path, ..landing });
        }
        last
    }
}

#[cfg(test)]
mod tests {
    use crate::engine::geometrical::system_trace::trace_system;
    use crate::fixtures::parts::{element, lit, on_axis, screen, sensor};

    use crate::optics::aperture::Aperture;
    use crate::optics::doe::Layer;
    use crate::optics::frame::Frame;
    use crate::optics::phase::profile::Profile;
    use crate::optics::ray::Loss;
    use crate::optics::screen::ScreenKind;

    use crate::optics::system::System;

    /// Fermat: all optical paths to the focus of an ideal diffractive lens are alike; beside it rays are clipped.
    #[test]
    fn paths_to_a_focus_are_alike() {
        let (wavelength, focal_length) = (0.5e-3, 10.0);
        let wavenumber = std::f64::consts::TAU / wavelength;
        let lens = Layer::Phase(Profile::Lens {
            focal_length,
            wavenumber,
        });
        let doe = element(lens, Aperture::disc(4.0));
        let system = System {
            wavelength,
            ..lit(
                vec![
                    screen(Frame::GLOBAL, ScreenKind::Doe(doe)),
                    screen(on_axis(focal_length), sensor(2, 1e-3)),
                ],
                vec![vec![]],
            )
        };
        let source = system.source;
        for at in [[0.0, 0.0], [3.0, 1.0], [-1.0, 3.5]] {
            let ray = trace_system(&system, &source, at);
            let last = ray.hits[1];
            assert_eq!(ray.lost, None);
            assert!(last.point.x.hypot(last.point.y) < 1e-12, "{last:?}");
            assert!((last.path - focal_length).abs() < 1e-12, "{last:?}");
        }
        let beside = trace_system(&system, &source, [4.1, 0.0]);
        assert_eq!((beside.lost, beside.hits.len()), (Some(Loss::Clipped), 1));
    }
}
