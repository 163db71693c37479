//! Rays of any tracer on a screen, in plain arrays, and the faults that such arrays may have.

use num_complex::Complex64;

use crate::math::vec3::Vec3;
use crate::optics::screen::Screen;

/// Rays on a screen in arrays of one length, one entry per ray, global coordinates.
///
/// The light that ray i represents is weightᵢ·exp(ik·pathᵢ) where it meets the screen, with the vacuum
/// wavenumber k and the sign convention exp(+ikz) for light that goes +z.
#[derive(Clone, Copy, Debug)]
pub struct Rays<'a> {
    /// Where each meets the screen, in mm.
    pub position: &'a [[f64; 3]],
    /// Unit direction of travel.
    pub direction: &'a [[f64; 3]],
    /// Optical path so far (index × length), in mm.
    pub path: &'a [f64],
    /// Complex amplitude, without the phase of the path.
    pub weight: &'a [Complex64],
}

/// A ray on its screen's own axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// Position on the local plane, in mm.
    pub at: [f64; 2],
    /// Optical direction cosines (index × cosine) along the local x and y axes.
    pub cosines: [f64; 2],
    /// Cosine against the local z axis, without index, with its sign.
    pub along: f64,
}

/// Why arrays of rays, or a call that uses them, are refused.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum RayError {
    /// An array has another length than its fellows.
    #[error("{field} has {found} entries, expected {expected}: one for each {each}")]
    Length {
        /// The array.
        field: &'static str,
        /// Its length.
        found: usize,
        /// What its length should be.
        expected: usize,
        /// What it has an entry for.
        each: &'static str,
    },
    /// A number is none.
    #[error("{field}[{index}] is {found}, expected finite numbers up to 1e60")]
    NotFinite {
        /// The array.
        field: &'static str,
        /// The entry.
        index: usize,
        /// What stands there.
        found: f64,
    },
    /// A direction has another length than one.
    #[error("direction[{index}] has length {found}, expected a unit vector")]
    NotUnit {
        /// The ray.
        index: usize,
        /// Length of its direction.
        found: f64,
    },
    /// A ray does not stand on the surface.
    #[error(
        "position[{index}] is {found:e} mm off the surface of screen '{screen}' along its z axis, expected \
         at most {allowed:e} mm (a hundredth of the wavelength)"
    )]
    OffSurface {
        /// The ray.
        index: usize,
        /// The screen.
        screen: String,
        /// How far off it is.
        found: f64,
        /// How far off it may be.
        allowed: f64,
    },
    /// A ray stands where there is no surface.
    #[error(
        "position[{index}] has local (x, y) = ({x}, {y}) mm, expected a place where the surface of \
             screen '{screen}' exists"
    )]
    NoSurface {
        /// The ray.
        index: usize,
        /// The screen.
        screen: String,
        /// Local x in mm.
        x: f64,
        /// Local y in mm.
        y: f64,
    },
    /// A ray comes from the wrong side, or runs along the surface.
    #[error(
        "direction[{index}] has the cosine {found} against the normal of screen '{screen}', expected one \
         of sign {expected}: the side light arrives from is the screen's `arrives`"
    )]
    WrongSide {
        /// The ray.
        index: usize,
        /// The screen.
        screen: String,
        /// Cosine against the surface's normal.
        found: f64,
        /// Its sign.
        expected: f64,
    },
    /// A setting is out of range.
    #[error("{field} is {found}, expected {expected}")]
    Setting {
        /// The setting.
        field: &'static str,
        /// What was given.
        found: String,
        /// What may be given.
        expected: &'static str,
    },
}

/// How far a position may be off its surface, in wavelengths.
const OFF_SURFACE: f64 = 0.01;

/// How far the length of a direction may be from one.
const OFF_UNIT: f64 = 1e-6;

/// Checks that an array has `expected` entries.
///
/// # Errors
/// [`RayError::Length`] when it has not.
pub(crate) fn check_length(
    field: &'static str,
    found: usize,
    expected: usize,
    each: &'static str,
) -> Result<(), RayError> {
    if found == expected {
        return Ok(());
    }
    Err(RayError::Length {
        field,
        found,
        expected,
        each,
    })
}

/// The largest magnitude of a number that comes with rays: products of four of them, and sums of these, are finite.
const LARGEST: f64 = 1e60;

/// Checks that all numbers of an array, given entry by entry, are finite and not beyond any physical size.
///
/// # Errors
/// [`RayError::NotFinite`] for the first that is not.
pub(crate) fn check_finite<const N: usize>(
    field: &'static str,
    entries: impl Iterator<Item = [f64; N]>,
) -> Result<(), RayError> {
    for (index, entry) in entries.enumerate() {
        if let Some(found) = entry
            .iter()
            .copied()
            .find(|v| v.is_nan() || v.abs() > LARGEST)
        {
            return Err(RayError::NotFinite {
                field,
                index,
                found,
            });
        }
    }
    Ok(())
}

/// Checks that a setting is a positive number of a size that a length or an area has.
///
/// # Errors
/// [`RayError::Setting`] when it is not.
pub(crate) fn check_positive(field: &'static str, found: f64) -> Result<(), RayError> {
    if (1e-12..=1e12).contains(&found) {
        return Ok(());
    }
    Err(RayError::Setting {
        field,
        found: found.to_string(),
        expected: "a positive finite number, from 1e-12 to 1e12",
    })
}

impl Rays<'_> {
    /// Number of rays.
    pub(crate) fn len(&self) -> usize {
        self.position.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.position.is_empty()
    }

    /// The rays on the axes of the screen where they arrive; `wavelength` is that of the vacuum, in mm.
    ///
    /// # Errors
    /// When lengths differ, a number is not finite, a direction has not length one, a ray does not stand
    /// on the screen, or comes from its other side.
    pub(crate) fn hits(&self, screen: &Screen, wavelength: f64) -> Result<Vec<Hit>, RayError> {
        check_length("direction", self.direction.len(), self.len(), "position")?;
        check_length("path", self.path.len(), self.len(), "position")?;
        check_length("weight", self.weight.len(), self.len(), "position")?;
        check_finite("position", self.position.iter().copied())?;
        check_finite("direction", self.direction.iter().copied())?;
        check_finite("path", self.path.iter().map(|path| [*path]))?;
        check_finite("weight", self.weight.iter().map(|w| [w.re, w.im]))?;
        let allowed = OFF_SURFACE * wavelength;
        (0..self.len())
            .map(|index| self.hit(screen, index, allowed))
            .collect()
    }

    /// One ray on the axes of a screen, from whose surface it may be `allowed` mm off.
    fn hit(&self, screen: &Screen, index: usize, allowed: f64) -> Result<Hit, RayError> {
        let [position, direction] =
            [self.position[index], self.direction[index]].map(|[x, y, z]| Vec3::new(x, y, z));
        let length = direction.norm();
        if (length - 1.0).abs() > OFF_UNIT {
            return Err(RayError::NotUnit {
                index,
                found: length,
            });
        }

        // On the surface.
        let local = screen.frame.to_local(position);
        let at = [local.x, local.y];
        let height = screen.height(at).ok_or_else(|| RayError::NoSurface {
            index,
            screen: screen.name.clone(),
            x: local.x,
            y: local.y,
        })?;
        let off = (local.z - height.z).abs();
        if off > allowed {
            return Err(RayError::OffSurface {
                index,
                screen: screen.name.clone(),
                found: off,
                allowed,
            });
        }

        // From the right side.
        let d = screen.frame.direction_to_local(direction);
        let [sx, sy] = height.slope;
        let lift = (d.z - sx * d.x - sy * d.y) / (1.0 + sx * sx + sy * sy).sqrt();
        if lift * screen.arrives <= 0.0 {
            return Err(RayError::WrongSide {
                index,
                screen: screen.name.clone(),
                found: lift,
                expected: screen.arrives,
            });
        }
        Ok(Hit {
            at,
            cosines: [d.x * screen.index, d.y * screen.index],
            along: d.z,
        })
    }
}
