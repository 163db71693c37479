//! What an interface does to a direction and to the amplitude of the field.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::math::real::Real;
use crate::math::vec3::Vec3;
use crate::optics::ray::Loss;

/// How light goes on at a surface.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Interface {
    /// Into the medium behind.
    Refract,
    /// Back into the medium it came from, without loss.
    Reflect,
}

/// How much of the field a refracting surface transmits.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Coating {
    /// An ideal antireflection coating: all the energy at every angle.
    #[default]
    Ideal,
    // The root mean square of the two Fresnel coefficients.
    /// A bare surface in unpolarised light.
    Fresnel,
    // Coefficient one.
    /// The field amplitude goes on unchanged.
    Unit,
}

/// The outcome of one bend.
#[derive(Clone, Copy, Debug)]
pub struct Refracted<T> {
    /// New unit direction.
    pub direction: Vec3<T>,
    /// Cosine of incidence, positive.
    pub cosine_in: T,
    /// Cosine of the outgoing ray against the same normal; negative after reflection.
    pub cosine_out: T,
    /// Field amplitude factor.
    pub transmission: T,
}

/// Bends a unit `direction` at a surface whose unit `normal` points along it (positive cosine).
///
/// # Errors
/// [`Loss::TotalReflection`] when no refracted ray exists.
#[inline(always)]
pub(crate) fn refract<T: Real>(
    interface: Interface,
    coating: Coating,
    direction: Vec3<T>,
    normal: Vec3<T>,
    [before, after]: [T; 2],
) -> Result<Refracted<T>, Loss> {
    let cosine_in = direction.dot(normal);
    match interface {
        Interface::Reflect => Ok(Refracted {
            direction: direction + normal * (cosine_in * -2.0),
            cosine_in,
            cosine_out: -cosine_in,
            transmission: T::constant(1.0),
        }),
        Interface::Refract => {
            // Snell's law in vector form; the tangential part of the optical direction is kept.
            let ratio = before / after;
            let tangential = direction + normal * -cosine_in;
            let under = tangential.dot(tangential) * -(ratio * ratio) + 1.0;
            if under.value() <= 0.0 {
                return Err(Loss::TotalReflection);
            }
            let cosine_out = under.sqrt();
            Ok(Refracted {
                direction: tangential * ratio + normal * cosine_out,
                cosine_in,
                cosine_out,
                transmission: transmission(coating, cosine_in * before, cosine_out * after, ratio),
            })
        }
    }
}

/// The field coefficient from the normal optical cosines on both sides (n₁cos χ₁, n₂cos χ₂).
#[inline(always)]
pub(crate) fn transmission<T: Real>(coating: Coating, before: T, after: T, ratio: T) -> T {
    match coating {
        Coating::Unit => T::constant(1.0),
        Coating::Ideal => (before / after).sqrt(),
        Coating::Fresnel => {
            // s: 2n₁c₁/(n₁c₁+n₂c₂); p: 2n₁c₁/(n₂c₁+n₁c₂), with the optical cosines a = n₁c₁, b = n₂c₂.
            let s = before * 2.0 / (before + after);
            let p = before * 2.0 / (before / ratio + after * ratio);
            ((s * s + p * p) * 0.5).sqrt()
        }
    }
}

#[cfg(test)]
mod tests {
    use crate::math::vec3::Vec3;
    use crate::optics::ray::Loss;
    use crate::optics::refraction::{Coating, Interface, refract};

    const NORMAL: Vec3 = Vec3::new(0.0, 0.0, 1.0);

    fn at(angle: f64) -> Vec3 {
        Vec3::new(angle.sin(), 0.0, angle.cos())
    }

    #[test]
    fn snell_and_total_reflection() {
        let refracted = refract(
            Interface::Refract,
            Coating::Ideal,
            at(0.4),
            NORMAL,
            [1.5, 1.0],
        )
        .unwrap();
        assert!((refracted.direction.x - 1.5 * 0.4f64.sin()).abs() < 1e-15);
        assert!((refracted.direction.norm() - 1.0).abs() < 1e-15);
        let lost = refract(
            Interface::Refract,
            Coating::Ideal,
            at(0.8),
            NORMAL,
            [1.5, 1.0],
        );
        assert_eq!(lost.unwrap_err(), Loss::TotalReflection);
    }

    #[test]
    fn ideal_coating_keeps_the_power() {
        let refracted = refract(
            Interface::Refract,
            Coating::Ideal,
            at(0.7),
            NORMAL,
            [1.0, 1.8],
        )
        .unwrap();
        let power =
            refracted.transmission.powi(2) * 1.8 * refracted.cosine_out / refracted.cosine_in;
        assert!((power - 1.0).abs() < 1e-14);
    }

    #[test]
    fn fresnel_at_normal_incidence_and_brewster() {
        let refracted = refract(
            Interface::Refract,
            Coating::Fresnel,
            at(0.0),
            NORMAL,
            [1.0, 1.5],
        )
        .unwrap();
        assert!((refracted.transmission - 0.8).abs() < 1e-15);
        // At Brewster's angle all of p is transmitted: t_p = n₁/n₂, t_s from R_s = ((n²−1)/(n²+1))².
        let n: f64 = 1.5;
        let refracted = refract(
            Interface::Refract,
            Coating::Fresnel,
            at(n.atan()),
            NORMAL,
            [1.0, n],
        )
        .unwrap();
        let s = 1.0 - (n * n - 1.0) / (n * n + 1.0);
        let expected = ((s * s + 1.0 / (n * n)) / 2.0).sqrt();
        assert!((refracted.transmission - expected).abs() < 1e-14);
    }

    #[test]
    fn mirror_reverses_the_normal_part() {
        let refracted = refract(
            Interface::Reflect,
            Coating::Ideal,
            at(0.3),
            NORMAL,
            [1.0, 1.0],
        )
        .unwrap();
        assert!(
            (refracted.direction - Vec3::new(0.3f64.sin(), 0.0, -(0.3f64.cos()))).norm() < 1e-15
        );
    }
}
