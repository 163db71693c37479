"""Tapers of light: how the amplitude of a beam, or of a point's light, falls off aside.

Each function returns a small dictionary that :meth:`raylet.System.plane_wave` or :meth:`raylet.System.point_source` takes
as its `taper`; keys are those of scene files. The amplitude is exp(−ρ^{2m}), ρ² = (u/a)² + (v/b)², with the order m: the
intensity is 1/e² of that in the middle where ρ = 1.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from raylet.layers import Pair

Taper = dict[str, Any]


def beam_taper(
    radius_mm: Pair, *, order: int = 1, centre_mm: Sequence[float] = (0.0, 0.0), rotation_deg: float = 0.0
) -> Taper:
    """The taper of a collimated beam, as of a laser: `radius_mm` along both axes or along each, about `centre_mm` [x, y]
    from the first element's vertex. `order` 1 is a Gaussian, more has a flatter top."""
    return {"radius_mm": radius_mm, "order": order, "centre_mm": centre_mm, "rotation_deg": rotation_deg}


def cone_taper(
    half_angle_deg: Pair | None = None,
    *,
    numerical_aperture: Pair | None = None,
    order: int = 1,
    angle_deg: Sequence[float] = (0.0, 0.0),
    rotation_deg: float = 0.0,
) -> Taper:
    """The taper of a point's light over directions, as of a laser diode: by half angles or by numerical apertures, along
    both axes or along each. u and v are direction cosines across the middle, whose direction is `angle_deg` [ax, ay]."""
    own = {"half_angle_deg": half_angle_deg, "numerical_aperture": numerical_aperture, "order": order}
    return {**own, "angle_deg": angle_deg, "rotation_deg": rotation_deg}
