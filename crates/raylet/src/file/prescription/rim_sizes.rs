//! How wide the rims of surfaces are that a file does not fix.

/// How wide rims are, from the first attempt to the last: narrower where the wider surfaces do not exist or cross. Rims that a
/// program computed from the light of its fields end where that light ends: wider ones cut nothing of it.
pub(crate) const ATTEMPTS: [Rims; 5] = [
    Rims::of(1.05, 1.25, Fields::All),
    Rims::of(1.0, 1.25, Fields::All),
    Rims::of(1.0, 1.25, Fields::Chosen),
    Rims::of(1.0, 1.02, Fields::Chosen),
    Rims::of(1.0, 1.02, Fields::Axis),
];

/// How wide rims are that the file does not fix.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Rims {
    /// Factor on semi-diameters that the program computed from the light.
    pub computed: f64,
    /// Factor on the paraxial light where the file has no semi-diameter.
    pub missing: f64,
    /// Whose light that is.
    pub fields: Fields,
}

/// Fields whose light goes through rims.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Fields {
    /// All of the file.
    All,
    /// That of the scene.
    Chosen,
    /// The axis alone.
    Axis,
}

impl Rims {
    /// Rims of these factors.
    pub(crate) const fn of(computed: f64, missing: f64, fields: Fields) -> Self {
        Self {
            computed,
            missing,
            fields,
        }
    }

    /// What rims without a semi-diameter in the file are, in a sentence.
    pub(crate) fn sentence(self) -> String {
        let fields = match self.fields {
            Fields::All => "of all fields",
            Fields::Chosen => "of the chosen field; those of all fields do not fit the surfaces",
            Fields::Axis => {
                "on the axis; those of the chosen field do not fit the surfaces, and cut its light"
            }
        };
        format!(
            "Rims of surfaces without a semi-diameter in the file are {:.0} % wider than the paraxial light {fields}.",
            100.0 * (self.missing - 1.0)
        )
    }
}
