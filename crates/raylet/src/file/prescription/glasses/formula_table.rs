//! A formula of dispersion as the table of indices that a scene can hold.

use crate::file::scene::material::OwnMedium;

/// Entries of the smallest and of the largest table.
const FEWEST: usize = 8;
const MOST: usize = 512;

/// How well a table has to keep a formula between its entries.
const WITHIN: f64 = 1e-9;

/// A table through which the index of a formula is kept to 1e-9, or as well as 512 entries can, with its largest error halfway
/// between entries; none where the formula has no index from 1 to 10 in the range in µm.
pub(crate) fn tabulated(
    index: impl Fn(f64) -> f64,
    [from, to]: [f64; 2],
) -> Option<(OwnMedium, f64)> {
    if !(from > 0.0 && to > from && to.is_finite()) {
        return None;
    }
    let mut count = FEWEST;
    loop {
        // Entries stand evenly in 1/λ, in which the index between them is a cubic.
        let step = (1.0 / from - 1.0 / to) / (count - 1) as f64;
        let wave = |place: f64| match place {
            0.0 => from,
            last if last == (count - 1) as f64 => to,
            _ => 1.0 / (1.0 / from - place * step),
        };
        let wavelengths_um: Vec<f64> = (0..count).map(|i| wave(i as f64)).collect();
        let indices: Vec<f64> = wavelengths_um.iter().map(|um| index(*um)).collect();
        if !indices.iter().all(|n| (1.0..=10.0).contains(n)) {
            return None;
        }
        let own = OwnMedium {
            wavelengths_um: Some(wavelengths_um),
            indices: Some(indices),
            ..OwnMedium::default()
        };
        let medium = own.medium().ok()?;
        let error = |i: usize| {
            let um = wave(i as f64 + 0.5);
            let kept = medium.index(um * 1e-3).unwrap_or(f64::INFINITY);
            (kept - index(um)).abs()
        };
        let largest = (0..count - 1).map(error).fold(0.0, f64::max);
        if largest <= WITHIN || count >= MOST {
            return largest.is_finite().then_some((own, largest));
        }
        count *= 2;
    }
}

#[cfg(test)]
mod tests {
    use crate::file::prescription::glasses::formula_table::tabulated;
    use crate::optics::media::catalog;

    #[test]
    fn tables_keep_a_formula() {
        let glass = catalog::medium("SF11").unwrap();
        let index = |um: f64| glass.index(um * 1e-3).unwrap();
        let (own, error) = tabulated(index, [0.4, 2.3]).unwrap();
        let table = own.medium().unwrap();
        assert!(error < 1e-9, "{error}");
        for um in [0.4, 0.4047, 0.53, 0.5875618, 1.06, 2.3] {
            let found = table.index(um * 1e-3).unwrap();
            assert!((found - index(um)).abs() < 1e-9, "{um}");
        }
        assert!(tabulated(|_| 0.5, [0.4, 0.7]).is_none());
        assert!(tabulated(index, [0.7, 0.4]).is_none());
    }
}
