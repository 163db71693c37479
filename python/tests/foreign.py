"""Systems that other tracers are compared on, as raylet has them."""

from __future__ import annotations

from typing import Any

import numpy as np
from conftest import noise

import raylet

#: Random phases for all of them.
PHASE = noise((25, 25))

#: System 3 of the source paper at half its size: a hologram 3 mm before the LA1131-A.
PITCH, SENSOR, SIGMA = 25.2, {"pixels": (48, 48), "pitch_um": 12.6}, 0.1
TOWARDS = (-0.014, 0.014, -0.014, 0.014)
HOLOGRAM: dict[str, Any] = {"aperture": raylet.disc(0.31), "sigma_mm": SIGMA, "towards": TOWARDS, **SENSOR}


def hologram_first() -> raylet.System:
    return (
        raylet.System(wavelength_um=0.7)
        .add_doe(raylet.pixels(pitch_um=PITCH, phase=PHASE), aperture=raylet.disc(0.31), thickness_mm=3.0, name="doe")
        .add_surface(radius_mm=25.8, thickness_mm=5.3, glass=1.5131, semi_aperture_mm=12.7)
        .add_surface(thickness_mm=44.7, semi_aperture_mm=12.7)
        .add_sensor(**SENSOR)
    )


#: The other way round: a hologram 1 mm behind a small plano-convex lens.
FINE: dict[str, Any] = {"pixels": (48, 48), "pitch_um": 6.3}
BEHIND: dict[str, Any] = {
    "aperture": raylet.disc(0.155),
    "sigma_mm": 0.035,
    "towards": (-0.06, 0.06, -0.06, 0.06),
    **FINE,
}
BEHIND_PITCH = 12.6


def soft_edge() -> dict[str, Any]:
    """An aperture 1 mm before the lens whose transmission falls smoothly from one to zero: rays know no diffraction at
    edges, and this has next to none where the hologram is."""
    places = 5e-3 * (np.arange(260) - 129.5)
    share = np.clip((np.hypot(*np.meshgrid(places, places)) - 0.28) / 0.36, 1e-3, 1.0 - 1e-3)
    falling, rising = np.exp(-1.0 / (1.0 - share)), np.exp(-1.0 / share)
    return raylet.pixels(pitch_um=5.0, amplitude=falling / (falling + rising))


def hologram_behind(lens_radius: float = 10.0, **keys: Any) -> raylet.System:
    """`keys` are those of the hologram: its shape, its tilt."""
    layer = raylet.pixels(pitch_um=BEHIND_PITCH, phase=PHASE)
    return (
        raylet.System(wavelength_um=0.7)
        .add_doe(soft_edge(), aperture=raylet.disc(0.65), thickness_mm=1.0, name="edge")
        .add_surface(radius_mm=lens_radius, thickness_mm=1.0, glass=1.5131, semi_aperture_mm=2.0)
        .add_surface(thickness_mm=1.0, semi_aperture_mm=2.0)
        .add_doe(layer, aperture=raylet.disc(0.155), thickness_mm=15.0, name="doe", **keys)
        .add_sensor(**FINE)
    )


def apart(one: Any, other: Any) -> float:
    """Relative error of one field or gradient from another."""
    return float(np.linalg.norm(np.asarray(one) - other) / np.linalg.norm(other))


def field(bend: float, phase: Any = PHASE, source: Any = None, target_error: float = 1e-3, **keys: Any) -> Any:
    """Field behind the lens with so much more curvature, of collimated light or of a point. With the target error that
    it has if no other is given, gradients of `distance` are within half the bound of the comparison."""
    own = hologram_behind(lens_radius=1.0 / (0.1 + bend), **keys).with_pixels("doe", phase=phase)
    own = own.settings(target_error=target_error)
    return (own if source is None else own.point_source(source)).simulate().field


#: What gradients lead to: a lens that is bent so much more, 20 %.
STRONGER = 0.02


def distance(field: Any, wanted: Any) -> Any:
    """Squared distance of a field from another, a tensor or an array: it sees the phase that a whole field shares."""
    return (abs(field - wanted) ** 2).sum()


def missed(wanted: Any, by_curvature: float, by_phase: Any, **keys: Any) -> float:
    """Relative error of a gradient of the distance from a field by the curvature of the lens and by the phases: by
    differences of raylet's own runs on a way on which both change it equally, and add up."""
    steepness = float(np.linalg.norm(by_phase))
    bend, along = np.copysign(1e-5, by_curvature), 1e-5 * abs(by_curvature) / steepness

    def value(step: float) -> float:
        return float(distance(field(step * bend, PHASE + step * along * by_phase / steepness, **keys), wanted))

    expected = 2.0 * 1e-5 * abs(by_curvature)
    return abs(0.5 * (value(1.0) - value(-1.0)) / expected - 1.0)
