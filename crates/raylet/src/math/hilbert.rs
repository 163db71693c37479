//! The order of grid cells along Hilbert's curve, on which near cells stay near.

/// Place of the cell [x, y] along the curve through a square of 2^`level` cells a side.
pub(crate) fn hilbert_place(level: u32, [mut x, mut y]: [u32; 2]) -> u64 {
    let mut place = 0;
    for bit in (0..level).rev() {
        let side = 1 << bit;
        let (right, up) = (u64::from(x & side != 0), u64::from(y & side != 0));
        place += (u64::from(side) * u64::from(side)) * ((3 * right) ^ up);

        // Turn the quadrant so that the curve within it runs like the whole one.
        if up == 0 {
            if right == 1 {
                (x, y) = (!x & (side - 1), !y & (side - 1));
            }
            (x, y) = (y, x);
        }
        (x, y) = (x & (side - 1), y & (side - 1));
    }
    place
}

/// The cells of an `nx` × `ny` grid as indices y·nx + x, in the order of the curve through the smallest
/// square of a power of two that holds them.
pub(crate) fn hilbert_order([nx, ny]: [usize; 2]) -> Vec<usize> {
    let level = nx.max(ny).max(1).next_power_of_two().trailing_zeros();
    let mut cells: Vec<usize> = (0..nx * ny).collect();
    cells.sort_by_cached_key(|cell| hilbert_place(level, [(cell % nx) as u32, (cell / nx) as u32]));
    cells
}

#[cfg(test)]
mod tests {
    use crate::math::hilbert::hilbert_order;

    #[test]
    fn every_step_leads_to_a_neighbour() {
        for side in [1, 2, 8, 32] {
            let order = hilbert_order([side, side]);
            let mut sorted = order.clone();
            sorted.sort_unstable();
            assert_eq!(sorted, (0..side * side).collect::<Vec<_>>());
            for pair in order.windows(2) {
                let apart =
                    |of: fn(usize, usize) -> usize| of(pair[0], side).abs_diff(of(pair[1], side));
                assert_eq!(
                    apart(|c, n| c % n) + apart(|c, n| c / n),
                    1,
                    "{side} {pair:?}"
                );
            }
        }
    }

    #[test]
    fn any_rectangle_is_visited_once() {
        let small = (0..12).flat_map(|nx| (0..12).map(move |ny| [nx, ny]));
        for [nx, ny] in small.chain([[1, 300], [257, 2], [64, 65]]) {
            let mut order = hilbert_order([nx, ny]);
            order.sort_unstable();
            assert_eq!(order, (0..nx * ny).collect::<Vec<_>>(), "{nx} × {ny}");
        }
    }
}
