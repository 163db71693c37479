//! Beamlets of rays that another tracer followed, from the Jacobians of its rays.

use num_complex::Complex64;

use crate::optics::bundle::{Hit, RayError, check_finite, check_length, check_positive};

/// What happened to rays between two screens, in arrays of one length.
#[derive(Clone, Copy, Debug)]
pub struct Jacobians<'a> {
    /// \[\[A, B\], \[C, D\]\] = ∂(s, p′)/∂(u, p): rows s_x, s_y, p′_x, p′_y on the receiving screen's axes,
    /// columns u_x, u_y, p_x, p_y on those of the plane that touches the emitting screen where the ray
    /// starts; positions in mm, p and p′ optical direction cosines (index × cosine).
    pub jacobian: &'a [[[f64; 4]; 4]],
    /// W (xx, xy, yy) in mm⁻² of the window exp(−½uᵀWu) with which each starts.
    pub window: &'a [[f64; 3]],
    /// Cosine of each against the normal of the plane where it starts, positive.
    pub cosine: &'a [f64],
    /// How many images of its starting point each ray has passed, counted for both transverse directions
    /// (two behind an ordinary image); none when absent.
    pub images: Option<&'a [u32]>,
}

/// Beamlets on a screen, in arrays of one length.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Beams {
    /// What the amplitude of each was multiplied by on the way, one at the start, without the phase of the
    /// optical path.
    pub amplitude: Vec<Complex64>,
    /// Curvature G (xx, xy, yy) in 1/mm of exp(ik[p·u + ½uᵀGu]) along the screen's axes; Im G decays.
    pub curvature: Vec<[Complex64; 3]>,
}

type Real2 = [[f64; 2]; 2];
type Complex2 = [[Complex64; 2]; 2];

/// A ray that is less than this before an image counts as behind it, in rad of the phase that grows by π from image to
/// image.
const AT_IMAGE: f64 = 1e-6;

impl Beams {
    /// The beamlets of rays that arrive on a screen: G = (C + Dq₀)(A + Bq₀)⁻¹, q₀ = iW/k, and the amplitude
    /// det(A + Bq₀)^{−1/2} √(cos/cos′). The root is that of a beam that was followed all the way. The Jacobian gives
    /// the phase of the determinant since the last image, whatever the axes on either side and the number of mirrors; every
    /// image adds half a turn.
    ///
    /// # Errors
    /// When lengths differ, numbers are not finite, or a Jacobian leaves nothing that decays.
    pub fn from_jacobians(rays: &Jacobians, hits: &[Hit], k: f64) -> Result<Self, RayError> {
        check_positive("wavenumber", k)?;
        for (field, found) in [
            ("jacobian", rays.jacobian.len()),
            ("window", rays.window.len()),
            ("cosine", rays.cosine.len()),
            ("images", rays.images.map_or(hits.len(), <[u32]>::len)),
        ] {
            check_length(field, found, hits.len(), "position")?;
        }
        check_finite("jacobian", rays.jacobian.iter().map(flat))?;
        check_window(rays.window)?;
        check_finite("cosine", rays.cosine.iter().map(|c| [*c]))?;
        let mut beams = Self::default();
        for (i, hit) in hits.iter().enumerate() {
            let images = rays.images.map_or(0, |all| all[i]);
            let (curvature, root) = land(&rays.jacobian[i], rays.window[i], images, k);
            beams.curvature.push(curvature);
            beams
                .amplitude
                .push(root * (rays.cosine[i] / hit.along.abs()).sqrt());
        }
        beams.check(hits.len())?;
        Ok(beams)
    }

    /// Checks that there are as many beamlets as rays, and that all decay.
    ///
    /// # Errors
    /// When they do not.
    pub(crate) fn check(&self, rays: usize) -> Result<(), RayError> {
        check_length("beam amplitude", self.amplitude.len(), rays, "position")?;
        check_length("beam curvature", self.curvature.len(), rays, "position")?;
        check_finite(
            "beam amplitude",
            self.amplitude.iter().map(|a| [a.re, a.im]),
        )?;
        for (index, curvature) in self.curvature.iter().enumerate() {
            let [xx, xy, yy] = curvature.map(|g| g.im);
            let decays = xx > 0.0 && xx * yy - xy * xy > 0.0;
            if !decays || curvature.iter().any(|g| !g.re.is_finite()) {
                return Err(RayError::Setting {
                    field: "beam curvature",
                    found: format!("(xx, xy, yy) = {curvature:?} at ray {index}"),
                    expected: "an imaginary part that is positive definite",
                });
            }
        }
        Ok(())
    }
}

/// Checks that Gaussians have a width in every direction.
fn check_window(windows: &[[f64; 3]]) -> Result<(), RayError> {
    check_finite("window", windows.iter().copied())?;
    let flat = |[xx, xy, yy]: &[f64; 3]| !(*xx > 0.0 && xx * yy - xy * xy > 0.0);
    match windows.iter().position(flat) {
        None => Ok(()),
        Some(index) => Err(RayError::Setting {
            field: "window",
            found: format!("(xx, xy, yy) = {:?} at ray {index}", windows[index]),
            expected: "positive definite, as of Gaussian windows",
        }),
    }
}

fn flat(j: &[[f64; 4]; 4]) -> [f64; 16] {
    std::array::from_fn(|i| j[i / 4][i % 4])
}

/// Curvature on the receiving screen, and det(A + Bq₀)^{−1/2}.
fn land(j: &[[f64; 4]; 4], window: [f64; 3], images: u32, k: f64) -> ([Complex64; 3], Complex64) {
    let block = |row: usize, column: usize| -> Real2 {
        [0, 1].map(|a| [0, 1].map(|b| j[row + a][column + b]))
    };
    let w: Real2 = [[window[0], window[1]], [window[1], window[2]]];
    let (a, b, c, d) = (block(0, 0), block(0, 2), block(2, 0), block(2, 2));
    let joined = |left: Real2, right: Real2| -> Complex2 {
        let turned = product(right, w);
        [0, 1].map(|r| [0, 1].map(|s| Complex64::new(left[r][s], turned[r][s] / k)))
    };
    let (m, n) = (joined(a, b), joined(c, d));
    let det = m[0][0] * m[1][1] - m[0][1] * m[1][0];

    // G = (C + Dq₀)(A + Bq₀)⁻¹, symmetric.
    let inverse = [
        [m[1][1] / det, -m[0][1] / det],
        [-m[1][0] / det, m[0][0] / det],
    ];
    let g = |r: usize, s: usize| n[r][0] * inverse[0][s] + n[r][1] * inverse[1][s];
    let curvature = [g(0, 0), 0.5 * (g(0, 1) + g(1, 0)), g(1, 1)];
    let turn = turned(&m, w) + std::f64::consts::PI * f64::from(images);
    let root = Complex64::from_polar(det.norm().powf(-0.5), -0.5 * turn);
    (curvature, root)
}

fn product(a: Real2, b: Real2) -> Real2 {
    [0, 1].map(|r| [0, 1].map(|s| a[r][0] * b[0][s] + a[r][1] * b[1][s]))
}

/// The phase of det(A + Bq₀) since the last image, in rad.
///
/// With Z = (A + Bq₀)W^{−1/2} and H = Re ZZ† the matrix H^{−1/2}Z is unitary as the Jacobian is symplectic,
/// and U Uᵀ has eigenvalues e^{2iθ} that no choice of axes changes on either side; θ grows from zero to π
/// from one image to the next. They are those of H⁻¹ZZᵀ, Z Zᵀ = M W⁻¹Mᵀ.
fn turned(m: &Complex2, w: Real2) -> f64 {
    let size = w[0][0] * w[1][1] - w[0][1] * w[1][0];
    let inverse = [
        [w[1][1] / size, -w[0][1] / size],
        [-w[1][0] / size, w[0][0] / size],
    ];
    let form = |r: usize, s: usize, conjugate: bool| {
        let mut sum = Complex64::ZERO;
        for (a, row) in inverse.iter().enumerate() {
            for (b, v) in row.iter().enumerate() {
                let right = if conjugate { m[s][b].conj() } else { m[s][b] };
                sum += m[r][a] * right * v;
            }
        }
        sum
    };
    let h = [0, 1].map(|r| [0, 1].map(|s| form(r, s, true).re));
    let z = [0, 1].map(|r| [0, 1].map(|s| form(r, s, false)));
    let det_h = h[0][0] * h[1][1] - h[0][1] * h[1][0];

    // Trace and determinant of H⁻¹ZZᵀ give the two eigenvalues on the unit circle.
    let trace =
        (z[0][0] * h[1][1] - z[1][0] * h[0][1] - z[0][1] * h[1][0] + z[1][1] * h[0][0]) / det_h;
    let det = (z[0][0] * z[1][1] - z[0][1] * z[1][0]) / det_h;
    let gap = (0.25 * trace * trace - det).sqrt();
    let angle = |eigenvalue: Complex64| {
        let turn = 0.5 * eigenvalue.arg();
        if turn < -AT_IMAGE {
            turn + std::f64::consts::PI
        } else {
            turn
        }
    };
    angle(0.5 * trace + gap) + angle(0.5 * trace - gap)
}

#[cfg(test)]
mod tests {
    use num_complex::Complex64;

    use crate::optics::bundle::{Hit, RayError};
    use crate::wave::beamlet::beams::{Beams, Jacobians};

    const K: f64 = std::f64::consts::TAU / 1e-3;

    fn hit() -> Hit {
        Hit {
            at: [0.0; 2],
            cosines: [0.0; 2],
            along: -1.0,
        }
    }

    fn jacobians<'a>(
        jacobian: &'a [[[f64; 4]; 4]],
        window: &'a [[f64; 3]],
        images: &'a [u32],
    ) -> Jacobians<'a> {
        Jacobians {
            jacobian,
            window,
            cosine: &[1.0],
            images: Some(images),
        }
    }

    /// Flight over `z`, then a cylinder lens of focal lengths `f`, then flight over `w`.
    fn train(z: f64, f: [f64; 2], w: f64) -> [[f64; 4]; 4] {
        let mut j = [[0.0; 4]; 4];
        for a in 0..2 {
            let power = -1.0 / f[a];
            j[a][a] = 1.0 + w * power;
            j[a][a + 2] = z + w * (1.0 + z * power);
            j[a + 2][a] = power;
            j[a + 2][a + 2] = 1.0 + z * power;
        }
        j
    }

    /// The amplitude of an astigmatic beam is continuous through its line images when they are counted, and
    /// is one at the start; axes turned on both sides and a mirror change nothing.
    #[test]
    fn root_follows_the_beam_through_its_images() {
        let window = [[1.0 / 0.01, 0.0, 1.0 / 0.04]];
        let (z, f) = (60.0, [20.0, 25.0]);
        let image = f.map(|f| z * f / (z - f));
        let (mut last, mut turn) = (Complex64::ONE, 0.0);
        for step in 0..4000 {
            // From the element on, then behind the lens.
            let (j, w) = match step {
                0..1000 => (train(0.0, [1e12; 2], z * f64::from(step) / 1000.0), -1.0),
                _ => {
                    let w = 100.0 * f64::from(step - 1000) / 3000.0;
                    (train(z, f, w), w)
                }
            };
            let passed = image.iter().filter(|image| **image <= w).count() as u32;
            let beams = Beams::from_jacobians(&jacobians(&[j], &window, &[passed]), &[hit()], K);
            let found = beams.unwrap().amplitude[0];
            let change = (found / last).arg();
            assert!(change.abs() < 0.5, "{step}: {last} {found}");
            (turn, last) = (turn + change, found);

            // Other axes on both sides, one of them turned over.
            let (s, c) = 2.1f64.sin_cos();
            let mut other = j;
            for column in 0..4 {
                for a in [0, 2] {
                    let (x, y) = (j[a][column], j[a + 1][column]);
                    (other[a][column], other[a + 1][column]) = (c * x + s * y, s * x - c * y);
                }
            }
            let beams =
                Beams::from_jacobians(&jacobians(&[other], &window, &[passed]), &[hit()], K);
            let mirrored = beams.unwrap().amplitude[0];
            assert!((mirrored - found).norm() < 1e-9 * found.norm());
        }
        assert!(
            turn < -2.0,
            "two line images turn the phase by about −π: {turn}"
        );
    }

    #[test]
    fn wrong_arrays_are_refused() {
        let window = [[1.0, 0.0, 1.0]];
        let j = [train(1.0, [5.0; 2], 2.0)];
        let found = Beams::from_jacobians(&jacobians(&j, &window, &[]), &[hit()], K).unwrap_err();
        assert!(matches!(
            found,
            RayError::Length {
                field: "images",
                ..
            }
        ));
        let found = Beams::from_jacobians(&jacobians(&j, &[[0.0; 3]], &[0]), &[hit()], K);
        assert!(found.unwrap_err().to_string().contains("positive definite"));
    }
}
