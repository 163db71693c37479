//! The error account of a hop: what to expect from each cause, and altogether.

use crate::engine::plan::Plan;
use crate::engine::settings::Settings;
use crate::engine::tally::Tally;

/// Expected relative errors of the complex field, by cause.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Account {
    /// Aberration inside beamlets, what the correction leaves of it.
    pub aberration: f64,
    /// Windows and period of the patches; without rays, the period of the free hop.
    pub windows: f64,
    /// Modes below the threshold.
    pub dropped: f64,
}

/// Field error of a sum with divided Gaussian windows at a period of 6σ, by their distance in σ:
/// measured on random pixels behind a lens.
const WINDOWS: [(f64, f64); 5] = [
    (1.25, 5e-4),
    (1.5, 9e-4),
    (1.75, 2.2e-3),
    (2.0, 3.4e-3),
    (2.5, 6.4e-3),
];

/// Field error of a free hop whose period is 4 and 6 times the sum of half widths: the largest measured
/// but for half-wave pixels close by.
const FREE: [(f64, f64); 2] = [(4.0, 3e-4), (6.0, 1e-4)];

impl Account {
    /// The account of a hop that was carried by `plan` with this tally; nothing for methods whose errors
    /// are not foretold.
    pub fn of(plan: &Plan, tally: &Tally, settings: &Settings) -> Option<Self> {
        match plan {
            Plan::Free(free, _) => Some(Self {
                windows: interpolated(&FREE, free.padding),
                ..Self::default()
            }),
            Plan::Beamlets(beamlets) => Some(Self {
                aberration: if beamlets.correct {
                    tally.eta_corrected()
                } else {
                    tally.eta()
                },
                windows: window_error(settings.step, settings.period),
                dropped: tally.dropped(),
            }),
            Plan::Planes(_) | Plan::Paper(_) => None,
        }
    }

    /// The root of the sum of squares.
    pub fn total(&self) -> f64 {
        self.aberration.hypot(self.windows).hypot(self.dropped)
    }
}

/// Expected field error of windows `step` σ apart in patches of `period` σ.
pub fn window_error(step: f64, period: f64) -> f64 {
    interpolated(&WINDOWS, step).hypot(2.0 * (-0.25 * period * period).exp())
}

/// Between the entries of a table their logarithms are joined by straight lines; before the first entry
/// its value holds, beyond the last one the last line goes on.
fn interpolated(table: &[(f64, f64)], at: f64) -> f64 {
    let pair = table
        .windows(2)
        .find(|pair| at <= pair[1].0)
        .unwrap_or(&table[table.len() - 2..]);
    let [(x0, y0), (x1, y1)] = [pair[0], pair[1]];
    let t = ((at - x0) / (x1 - x0)).max(0.0);
    (y0.ln() + t * (y1.ln() - y0.ln())).exp().min(1.0)
}

#[cfg(test)]
mod tests {
    use crate::engine::account::{Account, window_error};

    #[test]
    fn windows_follow_the_measurements() {
        for (step, measured) in [(1.25, 5e-4), (1.5, 9e-4), (2.5, 6.4e-3)] {
            assert!((window_error(step, 20.0) - measured).abs() < 1e-12);
        }
        // Between and beyond the measurements errors rise; shorter steps promise nothing more.
        assert!(window_error(1.6, 6.0) > window_error(1.5, 6.0));
        assert!(window_error(3.0, 6.0) > window_error(2.5, 6.0));
        assert_eq!(window_error(0.5, 20.0), window_error(1.25, 20.0));
        // A period of 4.5 σ alone costs 1.3e-2.
        assert!((window_error(1.5, 4.5) - 1.27e-2).abs() < 1e-4);
    }

    #[test]
    fn causes_add_in_squares() {
        let account = Account {
            aberration: 2e-3,
            windows: 3e-3,
            dropped: 6e-3,
        };
        assert!((account.total() - 7e-3).abs() < 1e-15);
    }
}
