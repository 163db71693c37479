//! Indices that glass makers and standard papers print.

use raylet::optics::media::catalog::medium;

fn index(name: &str, um: f64) -> f64 {
    medium(name).unwrap().index(um * 1e-3).unwrap()
}

/// SCHOTT's data sheet of N-BK7 (2014), from the mercury i line to 2.3 µm.
#[test]
fn crown_follows_its_data_sheet() {
    for (um, printed) in [
        (0.3650146, 1.53627),
        (0.4046561, 1.53024),
        (0.4861327, 1.52238),
        (0.5460740, 1.51872),
        (0.6562725, 1.51432),
        (0.8521100, 1.50980),
        (1.0140000, 1.50731),
        (1.5296000, 1.50091),
        (2.3254000, 1.48921),
    ] {
        let found = index("N-BK7", um);
        assert!((found - printed).abs() < 6e-6, "{um}: {found}");
    }
}

/// Abbe numbers: SCHOTT's data sheets; fused silica and CaF₂ as Malitson 1965 and 1963 give them.
#[test]
fn dispersion_is_the_published_one() {
    for (name, abbe, tolerance) in [
        ("N-BK7", 64.17, 5e-3),
        ("SF11", 25.76, 5e-3),
        ("N-SF11", 25.68, 5e-3),
        ("F2", 36.37, 5e-3),
        ("fused silica", 67.82, 1e-2),
        ("CaF2", 95.0, 1e-1),
    ] {
        let [f, d, c] = [0.4861327, 0.5875618, 0.6562725].map(|um| index(name, um));
        let found = (d - 1.0) / (f - c);
        assert!((found - abbe).abs() < tolerance, "{name}: {found}");
    }
}
