//! The transmission of an element over a carrier, row by row.

use ndarray::Array2;
use num_complex::Complex64;

use crate::math::lanes::phasors;
use crate::optics::doe::Layer;
use crate::optics::phase::profile::Profile;
use crate::optics::pixels::pixel_grid::{PixelPlace, Pixels};
use crate::wave::grid::field::Axis;
use crate::wave::local_bands::carrier::Carrier;
use crate::wave::local_bands::edge_mask::edge_mask;
use crate::wave::local_bands::element_phase::phase;
use crate::wave::local_bands::element_samples::Element;
use crate::wave::local_bands::open_nodes::OpenNodes;
use crate::wave::local_bands::reused_array;

impl Element<'_> {
    /// The transmission over a carrier at nodes, times what is open there if `opened`: the share of each part of a pixel, and
    /// the mask of limited band where there are no pixels.
    pub(super) fn values(
        &self,
        nodes: &[Axis; 2],
        carrier: &Carrier,
        k: f64,
        opened: bool,
    ) -> Array2<Complex64> {
        let [columns, rows] = nodes;
        let mut values = reused_array::zeros((rows.len(), columns.len()));
        let mask =
            (opened && self.pixels.is_none()).then(|| edge_mask(&self.phase.aperture, nodes));
        let whole = vec![1.0; columns.len()];
        let mut open_nodes = OpenNodes::new(&self.phase.aperture, nodes, self.filter());
        let mut line = self.line(nodes);
        for (j, mut row) in values.outer_iter_mut().enumerate() {
            // What is open at each node of the row.
            let masked = mask.as_ref().and_then(|mask| mask.row(j).to_slice());
            let open = match masked {
                Some(mask) => mask,
                None if opened => open_nodes.row(j),
                None => &whole,
            };

            // The transmission of what is open.
            if let Some(row) = row.as_slice_mut() {
                line.fill(row, j, open, (carrier, k));
            }
        }
        values
    }

    /// The transmission at a point.
    pub(super) fn transmission(&self, [x, y]: [f64; 2]) -> Complex64 {
        self.phase
            .doe
            .map_or(Complex64::ONE, |doe| doe.transmission(x, y))
    }

    /// Its rows of nodes, by the kind of its layers.
    fn line<'b>(&'b self, nodes: &'b [Axis; 2]) -> Line<'b> {
        let [columns, rows] = nodes;
        let layers = self.phase.doe.map_or(&[][..], |doe| &doe.layers);
        let kind = match layers {
            [Layer::Pixels(pixels)] if pixels.form.is_even() => Kind::Pixels(PixelLine {
                pixels,
                columns: pixels.places(0, &columns.nodes()),
                rows: pixels.places(1, &rows.nodes()),
                row: None,
                values: Vec::new(),
            }),
            _ => {
                let profiles: Vec<&Profile> = layers.iter().filter_map(phase).collect();
                match profiles.len() == layers.len() {
                    true => Kind::Phases(profiles, Vec::new()),
                    false => Kind::Any(self),
                }
            }
        };
        Line {
            places: columns.nodes(),
            rows,
            kind,
        }
    }
}

/// The transmission of an element along a row of nodes.
struct Line<'a> {
    /// The nodes along x, in mm.
    places: Vec<f64>,
    rows: &'a Axis,
    kind: Kind<'a>,
}

/// What an element consists of.
enum Kind<'a> {
    /// Pixels alone, each of one value.
    Pixels(PixelLine<'a>),
    /// Phases alone; and room for those of a row, in turns.
    Phases(Vec<&'a Profile>, Vec<f64>),
    /// Anything else.
    Any(&'a Element<'a>),
}

impl Line<'_> {
    /// Fills a row with the transmission over a carrier, times what is open.
    fn fill(
        &mut self,
        row: &mut [Complex64],
        j: usize,
        open: &[f64],
        (carrier, k): (&Carrier, f64),
    ) {
        let y = self.rows.node(j);
        let each = row.iter_mut().zip(open);
        match &mut self.kind {
            Kind::Phases(profiles, turns) => {
                turns.clear();
                turns.extend(self.places.iter().map(|x| {
                    let own: f64 = profiles.iter().map(|profile| profile.phase(*x, y)).sum();
                    (own - k * carrier.path([*x, y])) / std::f64::consts::TAU
                }));
                phasors(turns, row);

                // A phase may be no number where nothing is open.
                for (value, open) in row.iter_mut().zip(open) {
                    *value = match *open {
                        0.0 => Complex64::ZERO,
                        _ => *value * open,
                    };
                }
                return;
            }
            Kind::Pixels(line) => {
                let through = line.row(j).iter();
                each.zip(through)
                    .for_each(|((value, open), through)| *value = through * open);
            }
            Kind::Any(element) => {
                for ((value, open), x) in each.zip(&self.places) {
                    if *open != 0.0 {
                        *value = element.transmission([*x, y]) * open;
                    }
                }
            }
        }
        if carrier.is_flat() {
            return;
        }
        let lit = row.iter_mut().zip(&self.places);
        for (value, x) in lit.filter(|(value, _)| **value != Complex64::ZERO) {
            *value *= carrier.removed([*x, y], k);
        }
    }
}

/// The transmission of even pixels along a row of nodes. Neighbouring rows mostly lie in the same pixels.
struct PixelLine<'a> {
    pixels: &'a Pixels,
    columns: Vec<PixelPlace>,
    rows: Vec<PixelPlace>,
    /// The row of pixels whose values it has.
    row: Option<PixelPlace>,
    values: Vec<Complex64>,
}

impl PixelLine<'_> {
    /// The values at the nodes of a row.
    fn row(&mut self, j: usize) -> &[Complex64] {
        let row = self.rows[j];
        if self.row != Some(row) {
            let columns = self.columns.iter();
            self.row = Some(row);
            self.values.clear();
            self.values
                .extend(columns.map(|column| self.pixels.value_at(*column, row)));
        }
        &self.values
    }
}

#[cfg(test)]
mod tests {
    use num_complex::Complex64;

    use crate::fixtures::noise::noise;
    use crate::fixtures::parts::{element, pixel_layer, screen};
    use crate::optics::aperture::Aperture;
    use crate::optics::doe::Layer;
    use crate::optics::frame::Frame;
    use crate::optics::phase::profile::Profile;
    use crate::optics::pixels::pixel_grid::PixelForm;
    use crate::optics::screen::ScreenKind;
    use crate::wave::grid::field::Axis;
    use crate::wave::local_bands::carrier::Carrier;
    use crate::wave::local_bands::element_samples::Element;

    /// Rows of phases are the product of their transmissions at single points, with the carrier's; also where they turn by
    /// thousands of radians.
    #[test]
    fn rows_of_phases_are_those_of_points() {
        let lens = Profile::Lens {
            focal_length: 8.0,
            wavenumber: 9e3,
        };
        let layers = [lens, Profile::Vortex { charge: 2 }].map(Layer::Phase);
        let mut doe = element(layers[0].clone(), Aperture::disc(9.0));
        doe.layers = layers.to_vec();
        let screen = screen(Frame::GLOBAL, ScreenKind::Doe(doe));
        let element = Element::of(&screen).unwrap();
        let carrier = Carrier {
            at: [1.4, 0.5],
            p: [-0.17, -0.06],
            q: [-0.12, 0.01, -0.13],
        };
        let nodes = [Axis::uniform(19, 0.01, 1.5), Axis::uniform(6, 0.02, 0.4)];
        let found = element.values(&nodes, &carrier, 9e3, false);
        for ((j, i), value) in found.indexed_iter() {
            let at = [nodes[0].node(i), nodes[1].node(j)];
            let expected = element.value_at(at, &carrier, 9e3);
            assert!(
                (value - expected).norm() < 1e-11,
                "{at:?}: {value} {expected}"
            );
        }
    }

    /// A phase may overflow outside the opening, where nothing is lit: the values there are zero, alone and with pixels.
    #[test]
    fn a_phase_that_is_no_number_outside_stays_dark() {
        let steep = Profile::Polynomial {
            radius: 0.1,
            terms: vec![([400, 0], 1.0)],
        };
        assert!(steep.phase(1.0, 0.0).is_infinite());
        let pixels = pixel_layer(noise((40, 40), 0), 0.05, PixelForm::Box);
        let pairs = |cells: usize| Axis::gauss(cells, 0.005, 0.0, 2);
        let even = |count: usize| Axis::uniform(count, 0.004, 0.0);
        for (layers, nodes) in [
            (vec![], [even(500), even(50)]),
            (vec![pixels], [pairs(400), pairs(40)]),
        ] {
            let mut doe = element(Layer::Phase(steep.clone()), Aperture::disc(0.09));
            doe.layers.extend(layers);
            let screen = screen(Frame::GLOBAL, ScreenKind::Doe(doe));
            let element = Element::of(&screen).unwrap();
            let none = [0.0; 2];
            let carrier = Carrier {
                at: none,
                p: none,
                q: [0.0; 3],
            };
            let found = element.values(&nodes, &carrier, 9e3, true);
            for ((j, i), value) in found.indexed_iter() {
                let (x, y) = (nodes[0].node(i), nodes[1].node(j));
                assert!(value.is_finite(), "{x} {y}");
                assert!(x.abs() < 0.2 || *value == Complex64::ZERO, "{x} {y}");
            }
            let lit: f64 = found.iter().map(|value| value.norm_sqr()).sum();
            assert!(lit > 1.0);
        }
    }
}
