//! Paraxial optics of centred trains: ray matrices, focal lengths, principal planes.
//!
//! Rays near the axis are a height y (mm) and an optical direction cosine p = n·sin u. In these variables
//! every centred train, refracting or reflecting, between any two media, is one real matrix of
//! determinant one (Goodman, "General principles of geometric optics", Handbook of Optics I, 1995).

use crate::math::vec3::Vec3;
use crate::optics::frame::Frame;
use crate::optics::phase::vertex_power::vertex_power;
use crate::optics::refraction::Interface;
use crate::optics::screen::Screen;
use crate::optics::shape::Shape;
use crate::optics::surface::Surface;
use crate::optics::system::{Hop, System};

/// Vertices may lie this far (mm) from the axis, and axes differ by this much, and count as centred.
const CENTRED: f64 = 1e-9;

/// Below this power times thickness a train counts as afocal, relative to its own curvatures.
const AFOCAL: f64 = 1e-13;

/// Curvatures at a vertex may differ by this share and count as one.
const ROUND: f64 = 1e-9;

/// Why a train has no ray matrix.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ParaxialError {
    /// A part's axis is not the optical axis.
    #[error("{part} is tilted; paraxial optics needs every part square to one axis")]
    Tilted {
        /// The part.
        part: String,
    },
    /// A part's vertex is off the optical axis.
    #[error("{part} is {offset_mm} mm off the axis; paraxial optics needs centred parts")]
    Decentred {
        /// The part.
        part: String,
        /// Distance of its vertex from the axis in mm.
        offset_mm: f64,
    },
    /// A surface has two curvatures at its vertex.
    #[error(
        "{part} is curved differently along x and y; paraxial optics needs surfaces of revolution"
    )]
    Astigmatic {
        /// The part.
        part: String,
    },
    /// Distances and curvatures lie so far apart that the ray matrix is not finite.
    #[error("the ray matrix up to {part} is not finite")]
    NotFinite {
        /// The part.
        part: String,
    },
    /// A screen's x axis is not parallel to that of the screen before.
    #[error("{part} is turned about the axis; paraxial optics needs screens with parallel x axes")]
    Turned {
        /// The part.
        part: String,
    },
}

/// The ray matrix of a centred train, (y′, p′) = ((a, b), (c, d))·(y, p), and its length.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Abcd {
    /// ∂y′/∂y.
    pub a: f64,
    /// ∂y′/∂p in mm: the reduced distance; zero between an object and its image.
    pub b: f64,
    /// ∂p′/∂y in 1/mm: minus the power.
    pub c: f64,
    /// ∂p′/∂p.
    pub d: f64,
    /// Optical path along the axis in mm.
    pub path: f64,
}

impl Abcd {
    /// No train at all.
    pub const IDENTITY: Abcd = Abcd {
        a: 1.0,
        b: 0.0,
        c: 0.0,
        d: 1.0,
        path: 0.0,
    };

    /// This train, then a flight of `distance` mm in a medium; negative distances fly back.
    pub fn drift(self, distance: f64, index: f64) -> Self {
        self.then(Abcd {
            b: distance / index,
            path: distance * index,
            ..Self::IDENTITY
        })
    }

    /// This train, then a thin element of power `power` in 1/mm (1/f of a thin lens in air).
    pub fn thin_lens(self, power: f64) -> Self {
        self.then(Abcd {
            c: -power,
            ..Self::IDENTITY
        })
    }

    /// This train, then another.
    pub(crate) fn then(self, next: Abcd) -> Self {
        Self {
            a: next.a * self.a + next.b * self.c,
            b: next.a * self.b + next.b * self.d,
            c: next.c * self.a + next.d * self.c,
            d: next.c * self.b + next.d * self.d,
            path: self.path + next.path,
        }
    }

    /// The matrix of a hop, from its first to its second screen.
    ///
    /// # Errors
    /// When a surface or the second screen is tilted, off the first screen's axis, or turned, or a surface
    /// is astigmatic.
    pub fn between(hop: &Hop) -> Result<Self, ParaxialError> {
        let mut axis = Walk::from(hop.from);
        for (number, surface) in hop.train.iter().enumerate() {
            axis.pass(surface, number)?;
        }
        axis.reach(&hop.to.frame, hop.to.index, || screen_name(hop.to))?;
        if !hop.from.frame.is_parallel(&hop.to.frame) {
            let part = screen_name(hop.to);
            return Err(ParaxialError::Turned { part });
        }
        Ok(axis.matrix)
    }

    /// The matrix of a hop whose train is replaced by a thin lens of the same focal length at the first
    /// vertex: the approximation that ignores principal planes, for comparison.
    ///
    /// # Errors
    /// As [`Abcd::between`].
    pub fn between_as_thin_lens(hop: &Hop) -> Result<Self, ParaxialError> {
        let whole = Self::between(hop)?;
        let (Some(lens), Some(first)) = (Cardinal::of_hop(hop)?, hop.train.first()) else {
            return Ok(whole);
        };
        let before = (first.frame.origin - hop.from.frame.origin).norm();
        let behind = (hop.to.frame.origin - first.frame.origin).norm();
        Ok(Self::IDENTITY
            .drift(before, lens.index[0])
            .thin_lens(lens.power())
            .drift(behind, lens.index[1]))
    }
}

/// The first-order properties of a train with power. Positions are distances in mm along the light's
/// path, positive downstream.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cardinal {
    /// The matrix from the first vertex to the last.
    pub matrix: Abcd,
    /// Refractive index before the first and behind the last surface.
    pub index: [f64; 2],
}

impl Cardinal {
    /// The first-order properties of the train of a hop; `None` without surfaces or without power.
    ///
    /// # Errors
    /// When a surface is tilted, off the screen's axis, or astigmatic.
    pub fn of_hop(hop: &Hop) -> Result<Option<Self>, ParaxialError> {
        let mut lens = Lens::new(Walk::from(hop.from));
        for (number, surface) in hop.train.iter().enumerate() {
            lens.pass(surface, number)?;
        }
        Ok(lens.cardinal())
    }

    /// The first-order properties of all parts of a system, its diffractive elements among them, from the first part that bends
    /// light to the last; `None` without power. Elements of which [`vertex_power`] knows nothing are left out.
    ///
    /// # Errors
    /// When a part that bends light is tilted, off the axis of the first screen, or astigmatic.
    pub fn of_system(system: &System) -> Result<Option<Self>, ParaxialError> {
        let Some(first) = system.screens.first() else {
            return Ok(None);
        };
        let mut lens = Lens::new(Walk {
            towards: first.frame.z * first.arrives,
            ..Walk::from(first)
        });
        let k = system.wavenumber();
        for hop in system.hops() {
            lens.cross(hop.from, k)?;
            for (number, surface) in hop.train.iter().enumerate() {
                lens.pass(surface, number)?;
            }
        }
        Ok(lens.cardinal())
    }

    /// 1/f in 1/mm.
    pub(crate) fn power(&self) -> f64 {
        -self.matrix.c
    }

    /// Effective focal length in mm: 1/power. The distance from the rear principal plane to the rear
    /// focus is this times the index there.
    pub fn focal_length(&self) -> f64 {
        -1.0 / self.matrix.c
    }

    /// Rear focus from the last vertex: the back focal distance.
    pub fn back_focus(&self) -> f64 {
        -self.index[1] * self.matrix.a / self.matrix.c
    }

    /// Front principal plane from the first vertex.
    pub fn front_principal_plane(&self) -> f64 {
        self.index[0] * (self.matrix.d - 1.0) / self.matrix.c
    }

    /// Rear principal plane from the last vertex.
    pub fn rear_principal_plane(&self) -> f64 {
        self.index[1] * (1.0 - self.matrix.a) / self.matrix.c
    }

    /// The paraxial image, from the last vertex, of an axial point `object` mm from the first vertex
    /// (negative upstream, −∞ for collimated light); infinite when the image is.
    pub fn image(&self, object: f64) -> f64 {
        let Abcd { a, b, c, d, .. } = self.matrix;
        if object.is_infinite() {
            return self.back_focus();
        }
        // A ray from the point has y = −(object/n)·p at the first vertex.
        let reduced = -object / self.index[0];
        -self.index[1] * (a * reduced + b) / (c * reduced + d)
    }

    /// Numerical aperture n·sin u in the image space of collimated light of this radius (mm).
    pub fn numerical_aperture(&self, radius: f64) -> f64 {
        // The rear principal plane is a sphere about the focus: sin u = radius/f, as Abbe's condition has it.
        (radius * self.matrix.c).abs()
    }
}

/// A walk along the axis.
struct Walk {
    at: Vec3,
    towards: Vec3,
    matrix: Abcd,
}

impl Walk {
    /// From a screen, the way light leaves it.
    fn from(screen: &Screen) -> Self {
        Self {
            at: screen.frame.origin,
            towards: screen.frame.z * screen.leaves(),
            matrix: Abcd::IDENTITY,
        }
    }

    /// On to a vertex that must lie on the axis, square to it.
    fn reach(
        &mut self,
        frame: &Frame,
        index: f64,
        part: impl Fn() -> String,
    ) -> Result<(), ParaxialError> {
        let along = self.towards.dot(frame.z);
        if (frame.z - self.towards * along.signum()).norm() > CENTRED {
            return Err(ParaxialError::Tilted { part: part() });
        }
        let way = frame.origin - self.at;
        let distance = way.dot(self.towards);
        let offset_mm = (way - self.towards * distance).norm();
        if offset_mm > CENTRED {
            let part = part();
            return Err(ParaxialError::Decentred { part, offset_mm });
        }
        self.at = frame.origin;
        self.matrix = self.matrix.drift(distance, index);
        self.check_finite(part)
    }

    fn check_finite(&self, part: impl Fn() -> String) -> Result<(), ParaxialError> {
        let Abcd { a, b, c, d, path } = self.matrix;
        match [a, b, c, d, path].into_iter().all(f64::is_finite) {
            true => Ok(()),
            false => Err(ParaxialError::NotFinite { part: part() }),
        }
    }

    /// To a surface and through it, or back from it.
    fn pass(&mut self, surface: &Surface, number: usize) -> Result<(), ParaxialError> {
        self.reach(&surface.frame, surface.index[0], || surface_name(number))?;
        let part = || surface_name(number);
        self.bend(
            &surface.shape,
            &surface.frame,
            surface.index,
            surface.interface,
            &part,
        )?;
        self.check_finite(part)
    }

    /// Refraction or reflection at a vertex that is reached.
    fn bend(
        &mut self,
        shape: &Shape,
        frame: &Frame,
        [before, after]: [f64; 2],
        interface: Interface,
        part: &impl Fn() -> String,
    ) -> Result<(), ParaxialError> {
        // The curvature as the light sees it: positive when the centre lies downstream.
        let height = shape.height(0.0, 0.0);
        let [curvature, twist, other] = height.map_or([0.0; 3], |height| height.hessian);
        if (curvature - other).abs().max(twist.abs()) > ROUND * curvature.abs().max(other.abs()) {
            return Err(ParaxialError::Astigmatic { part: part() });
        }
        let seen = curvature * self.towards.dot(frame.z).signum();
        match interface {
            Interface::Refract => self.matrix = self.matrix.thin_lens((after - before) * seen),
            Interface::Reflect => {
                self.matrix = self.matrix.thin_lens(-2.0 * before * seen);
                self.towards = self.towards * -1.0;
            }
        }
        Ok(())
    }
}

/// A walk that counts from the first vertex to the last.
struct Lens {
    walk: Walk,
    /// The matrix up to the last surface, the largest power of one surface, and the outer indices.
    found: Option<(Abcd, f64, [f64; 2])>,
}

impl Lens {
    fn new(walk: Walk) -> Self {
        Self { walk, found: None }
    }

    fn pass(&mut self, surface: &Surface, number: usize) -> Result<(), ParaxialError> {
        self.start(&surface.frame, surface.index[0], || surface_name(number))?;
        let old = self.walk.matrix;
        self.walk.pass(surface, number)?;
        self.count(old, surface.index);
        Ok(())
    }

    /// To an element, if it bends light, and on behind it.
    fn cross(&mut self, screen: &Screen, wavenumber: f64) -> Result<(), ParaxialError> {
        let reflects = screen.leaves() != screen.arrives;
        let power = vertex_power(screen, wavenumber).unwrap_or(0.0);
        if power == 0.0 && !reflects && screen.behind.is_none() {
            return Ok(());
        }
        let part = || screen_name(screen);
        let index = [screen.index, screen.index_behind()];
        self.start(&screen.frame, index[0], part)?;
        self.walk.reach(&screen.frame, index[0], part)?;
        let old = self.walk.matrix;
        let interface = match reflects {
            true => Interface::Reflect,
            false => Interface::Refract,
        };
        self.walk
            .bend(&screen.shape, &screen.frame, index, interface, &part)?;
        self.walk.matrix = self.walk.matrix.thin_lens(power);
        self.walk.check_finite(part)?;
        self.count(old, index);
        Ok(())
    }

    /// What was flown before the first vertex does not count.
    fn start(
        &mut self,
        frame: &Frame,
        index: f64,
        part: impl Fn() -> String,
    ) -> Result<(), ParaxialError> {
        if self.found.is_none() {
            self.walk.reach(frame, index, part)?;
            self.walk.matrix = Abcd::IDENTITY;
        }
        Ok(())
    }

    /// Counts the power of a part behind which the walk stands, between these indices.
    fn count(&mut self, old: Abcd, [before, after]: [f64; 2]) {
        let step = (self.walk.matrix.c - old.c).abs();
        let (_, largest, index) = self.found.unwrap_or((old, 0.0, [before, after]));
        self.found = Some((self.walk.matrix, largest.max(step), [index[0], after]));
    }

    fn cardinal(&self) -> Option<Cardinal> {
        let (matrix, largest, index) = self.found?;
        (matrix.c.abs() > AFOCAL * largest).then_some(Cardinal { matrix, index })
    }
}

fn surface_name(number: usize) -> String {
    format!("surface {}", number + 1)
}

fn screen_name(screen: &Screen) -> String {
    format!("screen '{}'", screen.name)
}

#[cfg(test)]
mod tests {
    use crate::fixtures::parts::{self, conic, face, on_axis};
    use crate::math::vec3::Vec3;
    use crate::optics::aperture::Aperture;
    use crate::optics::doe::Layer;
    use crate::optics::paraxial::{Abcd, Cardinal, ParaxialError};
    use crate::optics::phase::profile::Profile;
    use crate::optics::refraction::{Coating, Interface};
    use crate::optics::screen::{MediumBehind, Screen, ScreenKind};
    use crate::optics::shape::{Conic, Shape};
    use crate::optics::surface::Surface;
    use crate::optics::system::{Hop, System};
    use crate::optics::toric::Biconic;

    /// N-BK7 at 0.7 µm.
    const GLASS: f64 = 1.513063997196;

    fn screen(z: f64, arrives: f64) -> Screen {
        Screen {
            arrives,
            ..parts::screen(on_axis(z), ScreenKind::Stop(Aperture::disc(0.63)))
        }
    }

    fn surface(z: f64, radius: f64, index: [f64; 2]) -> Surface {
        Surface {
            aperture: Aperture::disc(12.7),
            ..face(on_axis(z), conic(1.0 / radius, 0.0), index)
        }
    }

    fn la1131() -> Vec<Surface> {
        vec![
            surface(3.0, 25.8, [1.0, GLASS]),
            surface(8.3, f64::INFINITY, [GLASS, 1.0]),
        ]
    }

    fn hop<'a>(from: &'a Screen, train: &'a [Surface], to: &'a Screen) -> Hop<'a> {
        Hop {
            wavelength: 0.7e-3,
            from,
            train,
            to,
        }
    }

    #[test]
    fn plano_convex_lens_of_the_catalogue() {
        let (from, to, train) = (screen(0.0, 1.0), screen(53.0, 1.0), la1131());
        let lens = Cardinal::of_hop(&hop(&from, &train, &to)).unwrap().unwrap();
        assert!((lens.focal_length() - 25.8 / (GLASS - 1.0)).abs() < 1e-12);
        assert!((lens.focal_length() - 50.286).abs() < 5e-4);
        assert!((lens.back_focus() - 46.783).abs() < 5e-4);
        // Convex side first: the front principal plane touches the vertex, the rear one lies t/n inside.
        assert!(lens.front_principal_plane().abs() < 1e-12);
        assert!((lens.rear_principal_plane() + 5.3 / GLASS).abs() < 1e-12);
        assert!(lens.image(-lens.focal_length()).abs() > 1e12);
        assert!((lens.numerical_aperture(0.63) - 0.63 / 50.286).abs() < 1e-6);
        assert!((lens.image(f64::NEG_INFINITY) - lens.back_focus()).abs() < 1e-12);
        // A point two focal lengths before the front principal plane is imaged as far behind the rear one.
        let twice = 2.0 * lens.focal_length();
        let image = lens.image(lens.front_principal_plane() - twice);
        assert!((image - (lens.rear_principal_plane() + twice)).abs() < 1e-11);
    }

    #[test]
    fn thick_lens_obeys_the_lens_makers_formula() {
        let (from, to) = (screen(0.0, 1.0), screen(90.0, 1.0));
        for (r1, r2, t, n) in [(40.0, -55.0, 7.0, 1.7), (-30.0, 80.0, 4.0, 1.6)] {
            let train = [surface(10.0, r1, [1.0, n]), surface(10.0 + t, r2, [n, 1.0])];
            let lens = Cardinal::of_hop(&hop(&from, &train, &to)).unwrap().unwrap();
            let power = (n - 1.0) * (1.0 / r1 - 1.0 / r2 + (n - 1.0) * t / (n * r1 * r2));
            assert!((lens.power() - power).abs() < 1e-15);
            let back = (1.0 - (n - 1.0) * t / (n * r1)) / power;
            assert!((lens.back_focus() - back).abs() < 1e-11);
        }
    }

    #[test]
    fn matrices_have_determinant_one_and_mirrors_focus() {
        // A concave mirror of radius 80 after 100 mm, its focus 40 mm back.
        let (from, to) = (screen(0.0, 1.0), screen(60.0, -1.0));
        let mirror = Surface {
            interface: Interface::Reflect,
            ..surface(100.0, -80.0, [1.0, 1.0])
        };
        let matrix = Abcd::between(&hop(&from, &[mirror], &to)).unwrap();
        assert!(matrix.a.abs() < 1e-14 && (matrix.b - 40.0).abs() < 1e-12);
        assert!((matrix.path - 140.0).abs() < 1e-12);
        let to = screen(53.0, 1.0);
        let train = la1131();
        for matrix in [matrix, Abcd::between(&hop(&from, &train, &to)).unwrap()] {
            assert!((matrix.a * matrix.d - matrix.b * matrix.c - 1.0).abs() < 1e-13);
        }
    }

    /// A plano-convex lens with a diffractive lens on its front: the powers of both add at the vertex, and an element apart obeys
    /// 1/f = 1/f₁ + 1/f₂ − d/(f₁f₂).
    #[test]
    fn elements_add_their_power_to_that_of_the_surfaces() {
        let k = std::f64::consts::TAU / 0.7e-3;
        let lens_of = |focal_length: f64| {
            let profile = Profile::Lens {
                focal_length,
                wavenumber: k,
            };
            ScreenKind::Doe(parts::element(Layer::Phase(profile), Aperture::disc(5.0)))
        };
        let system = |first: Screen, train: Vec<Surface>| System {
            wavelength: 0.7e-3,
            ..parts::lit(vec![first, screen(90.0, 1.0)], vec![train])
        };
        let on_front = Screen {
            shape: conic(1.0 / 25.8, 0.0),
            behind: Some(MediumBehind {
                index: GLASS,
                coating: Coating::Ideal,
            }),
            ..parts::screen(on_axis(3.0), lens_of(100.0))
        };
        let back = la1131()[1].clone();
        let hybrid = system(on_front, vec![back]);
        let hybrid = Cardinal::of_system(&hybrid).unwrap().unwrap();
        let power = (GLASS - 1.0) / 25.8 + 1.0 / 100.0;
        assert!((hybrid.power() - power).abs() < 1e-9 * power);
        assert!((hybrid.back_focus() - (1.0 / power - 5.3 / GLASS)).abs() < 1e-7);

        let apart = parts::screen(on_axis(0.0), lens_of(-200.0));
        let both = Cardinal::of_system(&system(apart, la1131()));
        let (f1, f2) = (-200.0, 25.8 / (GLASS - 1.0));
        let power = 1.0 / f1 + 1.0 / f2 - 3.0 / (f1 * f2);
        assert!((both.unwrap().unwrap().power() - power).abs() < 1e-9 * power);
    }

    #[test]
    fn thin_lens_stands_at_the_first_vertex() {
        let (from, to, train) = (screen(0.0, 1.0), screen(53.0, 1.0), la1131());
        let hop = hop(&from, &train, &to);
        let f = 25.8 / (GLASS - 1.0);
        let thin = Abcd::between_as_thin_lens(&hop).unwrap();
        assert!((thin.a - (1.0 - 50.0 / f)).abs() < 1e-14);
        assert!((thin.b - (3.0 * (1.0 - 50.0 / f) + 50.0)).abs() < 1e-12);
        // The same with its principal planes: the glass is t/n long for the light, not t.
        let true_one = Abcd::between(&hop).unwrap();
        assert!((true_one.a - (1.0 - (44.7 + 5.3 / GLASS) / f)).abs() < 1e-14);
    }

    #[test]
    fn what_is_not_centred_is_refused() {
        let (from, to) = (screen(0.0, 1.0), screen(53.0, 1.0));
        let refused = |change: &dyn Fn(&mut Surface)| {
            let mut train = la1131();
            change(&mut train[1]);
            Abcd::between(&hop(&from, &train, &to)).unwrap_err()
        };
        let tilted = refused(&|s| s.frame = s.frame.tilted([1e-3, 0.0, 0.0]));
        assert_eq!(
            tilted,
            ParaxialError::Tilted {
                part: String::from("surface 2")
            }
        );
        let moved = refused(&|s| s.frame = s.frame.moved(Vec3::new(0.1, 0.0, 0.0)));
        assert!(matches!(moved, ParaxialError::Decentred { offset_mm, .. }
            if (offset_mm - 0.1).abs() < 1e-12));
        let toric = refused(&|s| {
            let flat = Conic {
                curvature: 0.0,
                conic: 0.0,
            };
            let y = Conic {
                curvature: 0.02,
                ..flat
            };
            s.shape = Shape::Biconic(Biconic { x: flat, y });
        });
        assert!(matches!(toric, ParaxialError::Astigmatic { .. }));
        let turned = Screen {
            frame: to.frame.tilted([0.0, 0.0, 0.1]),
            ..to.clone()
        };
        let error = Abcd::between(&hop(&from, &[], &turned)).unwrap_err();
        assert!(matches!(error, ParaxialError::Turned { .. }));
    }
}
