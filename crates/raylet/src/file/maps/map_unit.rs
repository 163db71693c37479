//! Units of lengths and angles, by the names that files give them.

/// What a unit measures.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Unit {
    /// A length, in micrometres.
    Length(f64),
    /// An angle, in radians.
    Angle(f64),
    /// A pure number.
    One,
}

impl Unit {
    /// The unit of this name; none for an unknown one.
    pub(crate) fn named(name: &str) -> Option<Self> {
        let small = name.trim().to_ascii_lowercase();
        let one = small.strip_suffix('s').filter(|one| one.len() > 2);
        Some(match one.unwrap_or(&small) {
            "m" | "meter" | "metre" => Unit::Length(1e6),
            "in" | "inch" => Unit::Length(25.4e3),
            "cm" | "centimeter" | "centimetre" => Unit::Length(1e4),
            "mm" | "millimeter" | "millimetre" => Unit::Length(1e3),
            "um" | "µm" | "μm" | "micron" | "micrometer" | "micrometre" => Unit::Length(1.0),
            "nm" | "nanometer" | "nanometre" => Unit::Length(1e-3),
            "pm" | "picometer" | "picometre" => Unit::Length(1e-6),
            "angstrom" => Unit::Length(1e-4),
            "rad" | "radian" => Unit::Angle(1.0),
            "mrad" | "milliradian" => Unit::Angle(1e-3),
            "deg" | "degree" => Unit::Angle(std::f64::consts::PI / 180.0),
            "" | "1" | "dimensionless" | "none" => Unit::One,
            _ => return None,
        })
    }
}

/// The factor that brings values of the unit of this name to that of a key of a scene.
///
/// # Errors
/// A unit that is unknown or measures something else, as (found, expected).
pub fn factor_for(name: Option<&str>, key: &str) -> Result<f64, (String, String)> {
    let Some(name) = name else {
        return Ok(1.0);
    };
    let expected = match (Unit::named(name), key) {
        (Some(Unit::Length(um)), "height_um") => return Ok(um),
        (Some(Unit::Angle(rad)), "phase") => return Ok(rad),
        (Some(Unit::One), "phase" | "amplitude" | "transmission" | "samples") => return Ok(1.0),
        (_, "height_um") => "a length such as m, um or nm",
        (_, "phase") => "rad, mrad or deg; heights belong under `height_um`",
        _ => "values without a unit",
    };
    Err((format!("values in `{name}`"), expected.to_owned()))
}

#[cfg(test)]
mod tests {
    use crate::file::maps::map_unit::{Unit, factor_for};

    #[test]
    fn units_have_their_usual_names() {
        for (names, um) in [
            (&["m", "meter", "meters", "Metres"][..], 1e6),
            (&["mm", "millimeters"], 1e3),
            (&["um", "µm", "micron", "microns"], 1.0),
            (&["nm", "nanometers"], 1e-3),
        ] {
            for name in names {
                assert_eq!(Unit::named(name), Some(Unit::Length(um)), "{name}");
            }
        }
        assert_eq!(Unit::named("radians"), Some(Unit::Angle(1.0)));
        assert_eq!(Unit::named("furlong"), None);
    }

    #[test]
    fn keys_take_the_units_of_what_they_hold() {
        assert_eq!(factor_for(Some("nm"), "height_um"), Ok(1e-3));
        assert_eq!(factor_for(Some("rad"), "phase"), Ok(1.0));
        assert_eq!(factor_for(None, "amplitude"), Ok(1.0));
        assert!(factor_for(Some("nm"), "phase").is_err());
        assert!(factor_for(Some("counts"), "height_um").is_err());
    }
}
