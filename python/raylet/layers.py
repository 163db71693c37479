"""What a diffractive element is made of, and the apertures of elements.

The layers of one element multiply, so their phases add. A phase φ multiplies the field by exp(+iφ). Each function
returns a small dictionary that :meth:`raylet.System.add_doe` and its fellows take; keys are those of scene files.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Union

import numpy as np

from raylet._arrays import grid

Layer = dict[str, Any]
Aperture = dict[str, Any]
Pair = Union[float, Sequence[float]]


def _layer(kind: str, **keys: Any) -> Layer:
    return {"kind": kind, **{key: value for key, value in keys.items() if value is not None}}


def pixels(
    *,
    pitch_um: Pair,
    phase: Any = None,
    amplitude: Any = None,
    transmission: Any = None,
    pixel: str = "box",
    size: Sequence[int] | None = None,
) -> Layer:
    """A centred grid of pixels [y, x]: phase in rad and amplitude, or the complex transmission.

    Arrays of float64 and complex128 are not copied: they are looked at when the system is computed. `pixel` says what
    lies between the centres: "box" (constant over each pixel), "point" or "bilinear". `size` [nx, ny] makes a blank.
    """
    given = {"phase": phase, "amplitude": amplitude, "transmission": transmission}
    held = {key: grid(key, value) for key, value in given.items() if value is not None}
    return _layer("pixels", pitch_um=pitch_um, pixel=pixel, size=size, **held)


def height(
    *, pitch_um: Pair, height_um: Any = None, glass: Any, pixel: str = "box", size: Sequence[int] | None = None
) -> Layer:
    """A relief of one material, heights [y, x] in µm: phase k(n − n_ambient)h. `glass` is a name or an index; without
    heights `size` [nx, ny] makes a relief that :meth:`raylet.System.design` is to find."""
    held = None if height_um is None else grid("height_um", height_um)
    return _layer("height", pitch_um=pitch_um, height_um=held, glass=constant(glass), pixel=pixel, size=size)


def pixel_shape(layers: Sequence[Layer]) -> tuple[int, ...] | None:
    """Rows and columns of the first layer of pixels, where they are known."""
    for layer in layers:
        if layer.get("kind") == "pixels":
            given = (layer.get(key) for key in ("phase", "amplitude", "transmission"))
            held = [array for array in given if isinstance(array, np.ndarray)]
            size = layer.get("size")
            return held[0].shape if held else (size[1], size[0]) if size else None
    return None


def constant(glass: Any) -> Any:
    """A constant index may be given as a plain number."""
    number = isinstance(glass, (int, float, np.number)) and not isinstance(glass, bool)
    return {"index": glass} if number else glass


def grating(*, period_um: float, direction_deg: float = 0.0, order: int = 1) -> Layer:
    """One order of a blazed grating; positive orders turn light from the axis towards `direction_deg`, x to y."""
    return _layer("grating", period_um=period_um, direction_deg=direction_deg, order=order)


def lens(*, focal_length_mm: float, wavelength_um: float | None = None) -> Layer:
    """An ideal diffractive lens: equal optical path to its focus at its design wavelength."""
    return _layer("lens", focal_length_mm=focal_length_mm, wavelength_um=wavelength_um)


def axicon(*, angle_deg: float) -> Layer:
    """A conical phase that turns light towards the axis by one angle everywhere."""
    return _layer("axicon", angle_deg=angle_deg)


def vortex(*, charge: int) -> Layer:
    """A spiral phase: charge times the angle about the axis."""
    whole = isinstance(charge, (float, np.floating)) and float(charge).is_integer()
    return _layer("vortex", charge=int(charge) if whole else charge)


def radial(*, norm_radius_mm: float, coefficients: Sequence[float]) -> Layer:
    """Phase Σ aᵢ (r/ρ)^{2i} in rad, i from 1."""
    return _layer("radial", norm_radius_mm=norm_radius_mm, coefficients=coefficients)


def zernike(*, norm_radius_mm: float, coefficients: Sequence[float]) -> Layer:
    """Zernike polynomials in Noll's order and normalisation, in rad; the first coefficient is piston."""
    return _layer("zernike", norm_radius_mm=norm_radius_mm, coefficients=coefficients)


def superposition(terms: Sequence[Sequence[Layer]], weights: Sequence[float] | None = None) -> Layer:
    """A weighted sum of transmissions, each the product of a list of layers."""
    return _layer("sum", terms=[list(term) for term in terms], weights=weights)


def disc(radius_mm: float, *, centre_mm: Sequence[float] = (0.0, 0.0)) -> Aperture:
    """A round aperture."""
    return {"disc": {"radius_mm": radius_mm, "centre_mm": centre_mm}}


def rectangle(
    width_mm: float, height_mm: float, *, rotation_deg: float = 0.0, centre_mm: Sequence[float] = (0.0, 0.0)
) -> Aperture:
    """A rectangular aperture."""
    sides = {"width_mm": width_mm, "height_mm": height_mm}
    return {"rectangle": {**sides, "rotation_deg": rotation_deg, "centre_mm": centre_mm}}


def annulus(inner_radius_mm: float, outer_radius_mm: float) -> Aperture:
    """A ring."""
    return {"annulus": {"inner_radius_mm": inner_radius_mm, "outer_radius_mm": outer_radius_mm}}


def polygon(corners_mm: Sequence[Sequence[float]]) -> Aperture:
    """An aperture with straight sides."""
    return {"polygon": {"corners_mm": corners_mm}}


def obstructed(aperture: Aperture, *blocked: Aperture) -> Aperture:
    """An aperture with parts that let nothing through."""
    return {**aperture, "blocked": list(blocked)}
