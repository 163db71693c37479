//! The rows of the accuracy report that its tests measure again.

/// Parts of the names of these problems: quick ones of each kind of reference that has a quick one.
pub const PROBLEMS: [&str; 6] = [
    "120λ of free space, light",
    "hologram, LA1131-A convex side first, sensor 44.7 mm behind it",
    "bare mirror on a Gaussian bump (radius 506λ), without rays",
    "lens, random 2λ pixels 50λ behind it, sensor 200λ on",
    "random pixels, random pixels 200λ on, sensor 120λ on",
    "random 2λ pixels, 120λ of free space, sensor tilted 30°",
];

/// References that take half a minute and more. Tests of the estimated errors run small random tilted lenses; `make accuracy`
/// runs one that sends little light to its sensor.
pub const SLOW_REFERENCES: [&str; 2] = [
    "direct sum and surface integrals",
    "direct sums and surface integrals",
];

/// Name of the gradients that are measured again, one for each loss.
pub const GRADIENT: &str = "12² random 4λ pixels, 60λ of free space, light at 0°, without rays";

/// Whether the row of a problem is measured again.
pub fn is_measured_again(name: &str) -> bool {
    PROBLEMS.iter().any(|words| name.contains(words))
}

/// The sentence of the report about these rows.
pub fn sentence() -> String {
    format!(
        "The tests measure some rows again and compare them to a tenth: the problems whose names hold \"{}\", and \
         the gradients \"{GRADIENT}\". Of the other rows they check the names, the references of the problems and \
         the bounds.",
        PROBLEMS.join("\", \"")
    )
}
