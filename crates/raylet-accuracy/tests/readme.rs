//! The table of the README has the smallest and the largest error of the problems that each of its rows names.

const README: &str = include_str!("../../../README.md");
const ACCURACY: &str = include_str!("../../../docs/accuracy.md");
const REAL_SIZE: &str = include_str!("../../../docs/real_size.md");

/// The first words of each row of the README, and of the names of its problems in `docs/accuracy.md`.
const ROWS: [(&str, &[&str]); 13] = [
    ("half-wave random pixels", &["random λ/2 pixels"]),
    ("half-wave checkerboard", &["checkerboard of λ/2 pixels"]),
    ("hologram through the LA1131-A", &["hologram, LA1131-A"]),
    (
        "random pixels before a strong lens",
        &[
            "random 2λ pixels, lens, sensor 250λ",
            "random 2λ pixels, lens, sensor 375λ",
            "random 2λ pixels, 40λ off the axis, lens",
        ],
    ),
    ("grating of sine 0.25", &["grating of sine 0.25, lens"]),
    (
        "pixels behind it",
        &[
            "random pixels, lens, ",
            "lens, random 2λ pixels 50λ behind it",
        ],
    ),
    (
        "pixels between two such lenses",
        &["lens, random 2λ pixels, lens"],
    ),
    (
        "light at 20°",
        &[
            "random 2λ pixels, light at 20°",
            "random 2λ pixels, lens tilted 15°",
            "random 2λ pixels, lens, sensor tilted 25°",
            "random 2λ pixels tilted 20°",
        ],
    ),
    (
        "a lens of R = 400 λ",
        &["random 2λ pixels, decentred lens with 54 %"],
    ),
    ("a lens 220 λ wide", &["random 4.35λ pixels, lens tilted"]),
    (
        "a plate tilted 25°",
        &[
            "random 2λ pixels, plate tilted 25°",
            "random 2λ pixels, 120λ of free space, sensor tilted 30°",
            "random pixels, random pixels tilted 25°",
        ],
    ),
    (
        "toroidal mirror",
        &["smooth random light of sines below 0.15, toroidal"],
    ),
    (
        "random pixels behind random pixels",
        &["random pixels, random pixels 200λ on"],
    ),
];

/// The cells of the one row of the README whose first cell begins with these words.
fn readme_row(words: &str) -> Vec<&'static str> {
    let rows = README.lines().filter_map(|line| line.strip_prefix("| "));
    let own: Vec<&str> = rows.filter(|row| row.starts_with(words)).collect();
    let [row] = own[..] else {
        panic!("{words}: {own:?}");
    };
    row.trim_end_matches(" |").split(" | ").collect()
}

/// The errors of a column in the rows of a page whose first cell begins with any of these words.
fn errors(page: &str, words: &[&str], column: usize) -> Vec<f64> {
    let rows = page.lines().filter_map(|line| line.strip_prefix("| "));
    let own = rows.filter(|row| words.iter().any(|words| row.starts_with(words)));
    let cell = |row: &str| {
        row.trim_end_matches(" |")
            .split(" | ")
            .nth(column)?
            .parse()
            .ok()
    };
    own.filter_map(cell).collect()
}

/// A range as the README writes it: "1.2e-3", or "1.2e-3 to 3.0e-3".
fn range(errors: &[f64]) -> String {
    let low = errors.iter().copied().fold(f64::INFINITY, f64::min);
    let high = errors.iter().copied().fold(0.0, f64::max);
    match low == high {
        true => format!("{low:.1e}"),
        false => format!("{low:.1e} to {high:.1e}"),
    }
}

#[test]
fn every_row_is_the_range_of_its_problems() {
    for (first, problems) in ROWS {
        let found = errors(ACCURACY, problems, 2);
        assert!(found.len() >= problems.len(), "{first}: {found:?}");
        assert_eq!(*readme_row(first).last().unwrap(), range(&found), "{first}");
    }
}

/// The mirror is in the report twice: without rays, and by beamlets.
#[test]
fn the_diffractive_mirror_has_both_methods() {
    let method = |name: &str| {
        let lines = ACCURACY
            .lines()
            .filter(|line| line.contains(" on a Gaussian bump (radius 506λ)"));
        let own: Vec<&str> = lines.filter(|line| line.contains(name)).collect();
        range(&errors(&own.join("\n"), &[""], 2))
    };
    let expected = format!(
        "{}; by beamlets {}",
        method(", without rays"),
        method(", by beamlets")
    );
    assert_eq!(*readme_row("diffractive mirror").last().unwrap(), expected);
}

/// The triplet stands in the first table of `docs/real_size.md`.
#[test]
fn the_triplet_has_the_range_of_its_masks() {
    let masks = [
        "bare",
        "vortex",
        "cubic, 20 waves",
        "binary grating of 20 µm",
        "random pixels of 8 µm",
    ];
    let starts = masks.map(|mask| format!("cooke triplet | {mask} |"));
    let (table, _) = REAL_SIZE.split_once("## Errors and target errors").unwrap();
    let found = errors(table, &starts.each_ref().map(String::as_str), 8);
    assert_eq!(found.len(), 15);
    assert_eq!(
        *readme_row("triplet of 50 mm").last().unwrap(),
        range(&found)
    );
}
