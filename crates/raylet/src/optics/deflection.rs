//! What an element on a surface does to a ray that meets it.
//!
//! The optical direction cosines along the surface are continuous across an interface, and the gradient of the
//! element's phase adds to them: Snell's law and the grating equation in one. The interface transmits the field as it
//! does without the element, which then multiplies the field behind it.

use crate::math::real::Real;
use crate::math::vec3::Vec3;
use crate::optics::ray::Loss;
use crate::optics::refraction::transmission;
use crate::optics::screen::Screen;
use crate::optics::shape::Bending;

/// The direction behind an element that adds `kick` to the optical cosines along its surface: what is tangential is
/// kept and kicked, what is normal follows in the medium behind, backwards from a mirror.
pub(crate) fn deflected(
    screen: &Screen,
    at: [f64; 2],
    p: [f64; 2],
    kick: [f64; 2],
) -> Option<[f64; 2]> {
    let [sx, sy] = screen.height(at)?.slope;
    let up = Vec3::new(-sx, -sy, 1.0).unit();
    let [px, py] = p;
    let [before, behind] = [screen.index, screen.index_behind()];
    let along = (before * before - px * px - py * py).max(0.0).sqrt() * screen.arrives;
    let tangential = |v: Vec3| v - up * v.dot(up);
    let whole = Vec3::new(px, py, along);
    let kept = tangential(whole) + tangential(Vec3::new(kick[0], kick[1], 0.0));
    let under = behind * behind - kept.dot(kept);
    if under <= 0.0 {
        return None;
    }
    let turned = screen.arrives * screen.leaves();
    let out = kept + up * (under.sqrt() * whole.dot(up).signum() * turned);
    Some([out.x, out.y])
}

/// The factor by which the interface under an element multiplies the field of light that arrives above (x, y) of its
/// surface with optical cosines p along the screen's axes; one where both media are the same.
///
/// # Errors
/// [`Loss::TotalReflection`] where light would not leave without the element, [`Loss::Missed`] where the surface does
/// not exist.
#[inline(always)]
pub(crate) fn transmitted<T: Real>(
    screen: &Screen,
    shape: &impl Bending<T>,
    at: [T; 2],
    p: [T; 2],
) -> Result<T, Loss> {
    let Some(behind) = screen.behind else {
        return Ok(T::constant(1.0));
    };
    let height = shape.height(at[0], at[1]).ok_or(Loss::Missed)?;
    let [sx, sy] = height.slope;
    let up = Vec3::new(-sx, -sy, T::constant(1.0)).unit();
    let square = p[0] * p[0] + p[1] * p[1];
    let along = (square * -1.0 + screen.index * screen.index).sqrt() * screen.arrives;
    let before = up.dot(Vec3::new(p[0], p[1], along));
    let before = before * T::constant(1.0).along(before);
    let under = before * before + (behind.index * behind.index - screen.index * screen.index);
    if under.value() <= 0.0 {
        return Err(Loss::TotalReflection);
    }
    let ratio = T::constant(screen.index / behind.index);
    Ok(transmission(behind.coating, before, under.sqrt(), ratio))
}

#[cfg(test)]
mod tests {
    use crate::fixtures::parts::{conic, open_screen};
    use crate::math::vec3::Vec3;
    use crate::optics::deflection::{deflected, transmitted};
    use crate::optics::frame::Frame;
    use crate::optics::ray::Loss;
    use crate::optics::refraction::{Coating, Interface, refract};
    use crate::optics::screen::{MediumBehind, Screen};

    fn interface(coating: Coating) -> Screen {
        Screen {
            shape: conic(0.08, -0.6),
            index: 1.5,
            behind: Some(MediumBehind {
                index: 1.2,
                coating,
            }),
            ..open_screen(Frame::GLOBAL)
        }
    }

    /// Without a phase the interface is an ordinary surface.
    #[test]
    fn an_interface_without_a_phase_is_an_ordinary_surface() {
        for coating in [Coating::Ideal, Coating::Fresnel, Coating::Unit] {
            let (screen, at, p) = (interface(coating), [2.0, -1.0], [0.3, 0.2]);
            let [sx, sy] = screen.height(at).unwrap().slope;
            let along = (1.5f64 * 1.5 - 0.13).sqrt();
            let direction = Vec3::new(p[0], p[1], along) * (1.0 / 1.5);
            let normal = Vec3::new(-sx, -sy, 1.0).unit();
            let refracted =
                refract(Interface::Refract, coating, direction, normal, [1.5, 1.2]).unwrap();
            let turned = deflected(&screen, at, p, [0.0; 2]).unwrap();
            assert!((turned[0] - 1.2 * refracted.direction.x).abs() < 1e-14);
            assert!((turned[1] - 1.2 * refracted.direction.y).abs() < 1e-14);
            let factor = transmitted(&screen, &screen.shape, at, p).unwrap();
            assert!((factor - refracted.transmission).abs() < 1e-14);
        }
    }

    /// A grating on a plane: n₂ sin θ₂ = n₁ sin θ₁ + ∇φ/k.
    #[test]
    fn a_plane_grating_obeys_the_grating_equation() {
        let plane = Screen {
            shape: crate::optics::shape::Shape::Plane,
            ..interface(Coating::Ideal)
        };
        let turned = deflected(&plane, [1.0, 2.0], [0.4, 0.1], [-0.3, 0.2]).unwrap();
        assert!((turned[0] - 0.1).abs() < 1e-15 && (turned[1] - 0.3).abs() < 1e-15);
        // 1.3 is more than the index behind.
        assert_eq!(deflected(&plane, [0.0; 2], [1.1, 0.0], [0.2, 0.0]), None);
        let lost = transmitted(&plane, &plane.shape, [0.0; 2], [1.3, 0.0]);
        assert_eq!(lost.unwrap_err(), Loss::TotalReflection);
    }
}
