//! The place on a screen from which beamlets leave: on a curved screen the plane that touches it there.

use crate::math::complex::{Complex, Symmetric};
use crate::math::vec3::Vec3;
use crate::optics::frame::Frame;
use crate::optics::ray::Loss;
use crate::optics::screen::Screen;
use crate::optics::system::Hop;

/// A point of a screen with the plane that touches it.
pub(crate) struct LaunchPlane {
    /// The touching plane of a curved screen; nothing on a plane one.
    plane: Option<Screen>,
    /// The point, in mm on that plane.
    at: [f64; 2],
    /// The plane's axes x, y, z along the screen's own.
    axes: [[f64; 3]; 3],
    index: f64,
    leaves: f64,
}

impl LaunchPlane {
    /// The plane above (x, y) of a screen.
    ///
    /// # Errors
    /// [`Loss::Missed`] where a curved screen does not exist.
    #[inline]
    pub(crate) fn new(screen: &Screen, at: [f64; 2]) -> Result<Self, Loss> {
        let mut launch_plane = Self {
            plane: None,
            at,
            axes: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
            index: screen.index_behind(),
            leaves: screen.leaves(),
        };
        if !screen.is_plane() {
            let plane = screen.tangent(at).ok_or(Loss::Missed)?;
            let own = |axis| {
                let v = screen.frame.direction_to_local(axis);
                [v.x, v.y, v.z]
            };
            launch_plane.axes = [plane.frame.x, plane.frame.y, plane.frame.z].map(own);
            launch_plane.at = [0.0; 2];
            launch_plane.plane = Some(plane);
        }
        Ok(launch_plane)
    }

    /// The hop as it begins here.
    #[inline]
    pub(crate) fn hop<'a>(&'a self, hop: &Hop<'a>) -> Hop<'a> {
        Hop {
            from: self.plane.as_ref().unwrap_or(hop.from),
            ..*hop
        }
    }

    /// The touching plane's frame on the axes of its screen; nothing on a plane screen.
    pub(crate) fn frame_on(&self, screen: &Screen) -> Option<Frame> {
        let plane = self.plane.as_ref()?;
        let [x, y, z] = self.axes.map(|[x, y, z]| Vec3::new(x, y, z));
        Some(Frame {
            origin: screen.frame.to_local(plane.frame.origin),
            x,
            y,
            z,
        })
    }

    /// The point on the plane of [`LaunchPlane::hop`], in mm.
    #[inline]
    pub(crate) fn at(&self) -> [f64; 2] {
        self.at
    }

    /// A direction's optical cosines along the screen's axes, turned to the axes of the plane.
    ///
    /// # Errors
    /// [`Loss::Evanescent`] when it does not propagate, [`Loss::Missed`] when it leaves on the wrong side.
    #[inline]
    pub(crate) fn cosines(&self, p: [f64; 2]) -> Result<[f64; 2], Loss> {
        let under = self.index * self.index - p[0] * p[0] - p[1] * p[1];
        if under <= 0.0 {
            return Err(Loss::Evanescent);
        }
        if self.plane.is_none() {
            return Ok(p);
        }
        let d = [p[0], p[1], under.sqrt() * self.leaves];
        let along = |a: [f64; 3]| a[0] * d[0] + a[1] * d[1] + a[2] * d[2];
        if along(self.axes[2]) * self.leaves <= 0.0 {
            return Err(Loss::Missed);
        }
        Ok([along(self.axes[0]), along(self.axes[1])])
    }

    /// The curvature with which a beamlet starts, whose Gaussian has width σ on the screen's local plane:
    /// (i/kσ²)·AᵀA, A = ∂(x, y)/∂u on the plane's axes.
    #[inline]
    pub(crate) fn window(&self, sigma: f64, k: f64) -> Symmetric<f64> {
        let [[ax, ay, _], [bx, by, _], _] = self.axes;
        let size = 1.0 / (k * sigma * sigma);
        let imaginary = |v: f64| Complex::new(0.0, size * v);
        Symmetric {
            xx: imaginary(ax * ax + ay * ay),
            xy: imaginary(ax * bx + ay * by),
            yy: imaginary(bx * bx + by * by),
        }
    }
}
