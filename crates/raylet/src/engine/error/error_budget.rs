//! The error budget of a hop: what to expect from each cause, and altogether.

use crate::engine::error::tally::Tally;
use crate::engine::error::window_error::interpolated;
use crate::engine::local_bands::settings::LocalBandPlan;
use crate::engine::plan::hop_method::HopMethod;
use crate::engine::plan::hop_plan::Plan;
use crate::wave::free::free_plan::FreePlan;

/// Expected relative errors of the complex field, by cause.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ErrorBudget {
    /// Aberration inside beamlets, what the correction leaves of it.
    pub aberration: f64,
    /// Windows and period of the patches; without rays, what the free hop's period, taper and levels cost.
    pub windows: f64,
    /// Modes below the threshold, tails of aberrated beamlets that are not trusted, and light beyond the ends of footprints.
    pub dropped: f64,
    /// The rim of a curved surface where the hop begins, and rims that cut light ray by ray.
    pub rims: f64,
}

/// Field error behind random pixels of a free hop, by the range of its taper in Fresnel zones, where the half widths of screen and
/// target come to one zone. Measured at 0.5 µm, with screens of 0.04 to 0.6 mm 8 to 100 mm apart.
const FREE: [(f64, f64); 4] = [(7.2, 1.1e-3), (13.0, 1e-4), (18.8, 4e-5), (24.5, 1e-5)];

/// The power with which that error grows where the half widths are less than a zone. It falls as their inverse where they are more.
const NARROW: f64 = 2.3;

/// What the ends of footprints that reach a sensor from beside it do to the field, over what all of it beyond them would do if it were
/// dropped. Beside the focus of a lens, beside orders of a grating and behind random pixels, with targets of 1e-3 and 1e-4, the expected
/// error is then 0.48 to 2.5 times the error.
const CUT: f64 = 1.1;

/// Field error to expect of a free hop that no direct sum checks.
fn free_error(plan: &FreePlan) -> f64 {
    let along = |axis: usize| {
        let [wide, taper] = plan.zones(axis);
        let power = if wide < 1.0 { NARROW } else { 1.0 };
        interpolated(&FREE, taper) * wide.powf(-power)
    };
    along(0).max(along(1)).min(1.0)
}

/// What plane waves and ends of footprints that are left out do to the field, where none of the first orders of the lattice of windows
/// falls on the target, over what they do otherwise. In the focus of lenses and of a metalens, at targets of 1e-2 and 1e-3, it is
/// 0.3 to 1.0.
const LEFT_OUT_ALIKE: f64 = 0.5;

/// What they do, by the part of these orders that falls on the target.
///
/// Neighbouring windows of smooth light leave alike parts out. Their sum has the directions of the light, where it nearly
/// vanishes, and of the orders.
pub(crate) fn left_out(orders: f64) -> f64 {
    let least = LEFT_OUT_ALIKE * LEFT_OUT_ALIKE;
    (least + (1.0 - least) * orders).sqrt()
}

impl ErrorBudget {
    /// The budget of a hop that was carried by `method` with this tally; nothing for methods whose errors
    /// are not estimated.
    pub fn of(method: &HopMethod, tally: &Tally) -> Option<Self> {
        match method {
            HopMethod::WholeField(plan) => Self::of_whole_field(plan, tally),
            HopMethod::LocalBands(plan) => Some(Self::of_local_bands(plan, tally)),
        }
    }

    /// The budget of a hop by local bands.
    fn of_local_bands(plan: &LocalBandPlan, tally: &Tally) -> Self {
        let waves = tally.dropped_of_followed() * tally.darkness();
        let dropped = plan.share_of_dropped() * waves.hypot(tally.footprints_left_out());
        Self {
            aberration: match plan.corrected {
                true => tally.eta_corrected(),
                false => tally.eta(),
            },
            windows: plan.window_error(tally.lattice_phase()) * tally.darkness(),
            dropped: left_out(tally.orders()) * dropped,
            rims: tally.edge.hypot(tally.edges_left_out()),
        }
    }

    /// The budget of a hop from a whole field.
    fn of_whole_field(plan: &Plan, tally: &Tally) -> Option<Self> {
        match plan {
            Plan::Free(_, free) => Some(Self {
                windows: tally.spot_check.unwrap_or_else(|| free_error(free)),
                rims: tally.edge,
                ..Self::default()
            }),
            Plan::Beamlets(beamlets) => Some(Self {
                aberration: if beamlets.correct {
                    tally.eta_corrected()
                } else {
                    tally.eta()
                },
                windows: beamlets.window_error(tally.cubic_phase()) * tally.darkness(),
                dropped: {
                    let shown = beamlets.share_of_dropped();
                    let cut = CUT * shown * tally.footprints_left_out();
                    tally.dropped(shown).hypot(cut)
                },
                rims: tally.edge,
            }),
            Plan::Planes(_) | Plan::Paper(_) => None,
        }
    }

    /// The error to expect of a hop before it is run, rims aside; nothing for methods whose errors are not estimated.
    pub(crate) fn expected_of(plan: &Plan) -> Option<f64> {
        match plan {
            Plan::Free(_, free) => Some(free_error(free)),
            Plan::Beamlets(beamlets) => Some(beamlets.expected_error()),
            Plan::Planes(_) | Plan::Paper(_) => None,
        }
    }

    /// The root of the sum of squares.
    pub fn total(&self) -> f64 {
        let inside = self.aberration.hypot(self.windows);
        inside.hypot(self.dropped).hypot(self.rims)
    }
}

#[cfg(test)]
mod tests {
    use crate::engine::error::error_budget::ErrorBudget;

    #[test]
    fn causes_add_in_squares() {
        let budget = ErrorBudget {
            aberration: 2e-3,
            windows: 3e-3,
            dropped: 6e-3,
            rims: 0.0,
        };
        assert!((budget.total() - 7e-3).abs() < 1e-15);
    }
}
