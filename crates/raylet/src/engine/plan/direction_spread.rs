//! What is known of light before it is computed: about which directions it goes.

use crate::optics::screen::{Screen, ScreenKind};

/// Light that arrives at a screen, in a few numbers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LightDirections {
    /// Direction of its chief ray, optical cosines on the screen's axes.
    pub chief: [f64; 2],
    /// |p| along x and y below which most of it stays.
    pub usual: [f64; 2],
}

/// How light behind a screen is spread over directions, roughly: even over a range about a centre, and
/// falling outside it like that of a hard edge. It only weighs choices.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct DirectionEnvelope {
    centre: [f64; 2],
    flat: [f64; 2],
    tail: [f64; 2],
}

impl LightDirections {
    /// The envelope behind a screen: its phases widen the range, its pixels or else its edge make the tail.
    pub(crate) fn behind(&self, screen: &Screen, wavelength: f64) -> DirectionEnvelope {
        let bounds = screen.bounds().unwrap_or([-1.0, 1.0, -1.0, 1.0]);
        let doe = match &screen.kind {
            ScreenKind::Doe(doe) => Some(doe),
            ScreenKind::Stop(_) | ScreenKind::Sensor(_) => None,
        };
        let slope = doe.map_or([0.0; 2], |doe| doe.steepest(bounds));
        let pixels = doe.and_then(|doe| doe.pixels());
        let feature = |a: usize| match pixels {
            Some(pixels) => pixels.pitch[a],
            None => bounds[2 * a + 1] - bounds[2 * a],
        };
        let spread = |a: usize| (self.usual[a] - self.chief[a].abs()).max(0.0);
        DirectionEnvelope {
            centre: self.chief,
            flat: [0, 1].map(|a| spread(a) + slope[a] * wavelength / std::f64::consts::TAU),
            tail: [0, 1].map(|a| wavelength / (std::f64::consts::PI * feature(a))),
        }
    }
}

impl DirectionEnvelope {
    /// The weight of a direction, at most 1.
    pub(crate) fn weight(&self, p: [f64; 2]) -> f64 {
        let along = |a: usize| {
            let outside = ((p[a] - self.centre[a]).abs() - self.flat[a]).max(0.0);
            1.0 / (1.0 + (outside / self.tail[a]).powi(2))
        };
        along(0) * along(1)
    }

    /// The cosines that light may have along an axis where a patch's own window widens its directions by
    /// `window`: all of them where details of the element widen them more.
    pub(crate) fn range(&self, axis: usize, window: f64) -> [f64; 2] {
        let half = match self.tail[axis] > window {
            true => f64::INFINITY,
            false => self.flat[axis] + window,
        };
        [self.centre[axis] - half, self.centre[axis] + half]
    }

    /// |p| along x and y below which most of the light stays.
    pub(crate) fn usual(&self) -> [f64; 2] {
        [0, 1].map(|a| self.centre[a].abs() + self.flat[a] + 2.0 * self.tail[a])
    }
}

/// The smallest of `values` below which a share of all weight lies; zero without any.
pub(crate) fn weighted_quantile(mut values: Vec<(f64, f64)>, share: f64) -> f64 {
    values.sort_by(|a, b| a.0.total_cmp(&b.0));
    let total: f64 = values.iter().map(|(_, weight)| weight).sum();
    let mut below = 0.0;
    for (value, weight) in &values {
        below += weight;
        if below >= share * total {
            return *value;
        }
    }
    0.0
}

#[cfg(test)]
mod tests {
    use crate::engine::plan::direction_spread::{DirectionEnvelope, weighted_quantile};

    #[test]
    fn weights_fall_outside_the_flat_part() {
        let envelope = DirectionEnvelope {
            centre: [0.1, 0.0],
            flat: [0.2, 0.1],
            tail: [0.1, 0.1],
        };
        assert_eq!(envelope.weight([0.3, -0.1]), 1.0);
        assert!((envelope.weight([0.4, 0.0]) - 0.5).abs() < 1e-12);
        assert!((envelope.weight([-0.2, 0.3]) - 0.1).abs() < 1e-12);
    }

    #[test]
    fn quantiles_count_weight() {
        let values = vec![(3.0, 1.0), (1.0, 8.0), (2.0, 1.0)];
        assert_eq!(weighted_quantile(values.clone(), 0.5), 1.0);
        assert_eq!(weighted_quantile(values.clone(), 0.85), 2.0);
        assert_eq!(weighted_quantile(values, 1.0), 3.0);
        assert_eq!(weighted_quantile(vec![], 0.5), 0.0);
    }
}
