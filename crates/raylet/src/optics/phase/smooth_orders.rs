//! The orders of an element: where it has no pixels, its transmission is a sum of smooth phases, each with a weight.

use num_complex::Complex64;

use crate::optics::doe::{Doe, Layer};

/// One order at a place.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SmoothOrder {
    /// Its share of the light, as if orders did not interfere.
    pub share: f64,
    /// The gradient of its phase in rad/mm.
    pub gradient: [f64; 2],
    /// Second derivatives (xx, xy, yy) of its phase in rad/mm².
    pub hessian: [f64; 3],
}

/// An order before its share is known.
type Weighted = (Complex64, SmoothOrder);

/// Most orders of an element, where its layers are several sums.
const MOST_ORDERS: usize = 4096;

/// The orders of an element at a place; nothing where pixels take part, or too many orders.
pub(crate) fn smooth_orders(doe: &Doe, at: [f64; 2]) -> Option<Vec<SmoothOrder>> {
    let weighted = product(&doe.layers, at)?;
    let all: f64 = weighted.iter().map(|(weight, _)| weight.norm_sqr()).sum();
    let orders = weighted.into_iter().map(|(weight, order)| SmoothOrder {
        share: weight.norm_sqr() / all,
        ..order
    });
    (all > 0.0).then(|| orders.collect())
}

/// The orders of layers whose transmissions multiply.
fn product(layers: &[Layer], at: [f64; 2]) -> Option<Vec<Weighted>> {
    let none = SmoothOrder {
        share: 0.0,
        gradient: [0.0; 2],
        hessian: [0.0; 3],
    };
    let mut orders = vec![(Complex64::ONE, none)];
    for layer in layers {
        let own = of_layer(layer, at)?;
        if own.len().saturating_mul(orders.len()) > MOST_ORDERS {
            return None;
        }
        let both = orders
            .iter()
            .flat_map(|a| own.iter().map(move |b| times(a, b)));
        orders = both.collect();
    }
    Some(orders)
}

/// The orders of one layer.
fn of_layer(layer: &Layer, [x, y]: [f64; 2]) -> Option<Vec<Weighted>> {
    match layer {
        Layer::Phase(profile) => {
            let order = SmoothOrder {
                share: 0.0,
                gradient: profile.gradient(x, y),
                hessian: profile.hessian(x, y),
            };
            Some(vec![(Complex64::ONE, order)])
        }
        Layer::Sum(terms) => {
            let mut orders = Vec::new();
            for (weight, layers) in terms {
                let own = product(layers, [x, y])?;
                orders.extend(own.iter().map(|(w, order)| (weight * w, *order)));
            }
            Some(orders)
        }
        Layer::Pixels(_) | Layer::OnSurface(..) => None,
    }
}

/// Weights multiply, phases add.
fn times((v, a): &Weighted, (w, b): &Weighted) -> Weighted {
    let order = SmoothOrder {
        share: 0.0,
        gradient: [0, 1].map(|i| a.gradient[i] + b.gradient[i]),
        hessian: [0, 1, 2].map(|i| a.hessian[i] + b.hessian[i]),
    };
    (v * w, order)
}

#[cfg(test)]
mod tests {
    use num_complex::Complex64;

    use crate::optics::aperture::Aperture;
    use crate::optics::doe::{Doe, Layer};
    use crate::optics::phase::profile::Profile;
    use crate::optics::phase::smooth_orders::smooth_orders;

    /// A lens times a sum of gratings: the sum over its orders of weight times phase is the transmission, and each has the slope of
    /// the lens and its own.
    #[test]
    fn sums_multiply_to_orders() {
        let grating = |rate: f64| {
            Layer::Phase(Profile::Linear {
                gradient: [rate, 0.0],
            })
        };
        let lens = Layer::Phase(Profile::Radial {
            radius: 1.0,
            coefficients: vec![-3.0],
        });
        let terms = [(0.6, 5.0), (0.8, -7.0)]
            .map(|(weight, rate)| (Complex64::new(0.0, weight), vec![grating(rate)]));
        let doe = Doe {
            layers: vec![lens, Layer::Sum(terms.to_vec()), Layer::Sum(terms.to_vec())],
            aperture: Aperture::OPEN,
            reflect: false,
        };
        let orders = smooth_orders(&doe, [0.5, 0.0]).unwrap();
        let found: Vec<[f64; 2]> = orders
            .iter()
            .map(|one| [one.share, one.gradient[0]])
            .collect();
        let expected = [
            [0.1296, 7.0],
            [0.2304, -5.0],
            [0.2304, -5.0],
            [0.4096, -17.0],
        ];
        for (ours, theirs) in found.iter().flatten().zip(expected.iter().flatten()) {
            assert!((ours - theirs).abs() < 1e-12, "{found:?}");
        }
        assert!(orders.iter().all(|one| one.hessian == [-6.0, 0.0, -6.0]));
    }
}
