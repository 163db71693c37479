"""What a diffractive element is made of, and the apertures of elements.

The layers of one element multiply, so their phases add. A phase φ multiplies the field by exp(+iφ). Each function
returns a small dictionary that :meth:`raylet.System.add_doe` and its fellows take; keys are those of scene files. The
centre of a layer of pixels, of heights or of an analytic phase stands at `centre_mm` [x, y] of the element, and its
axes are turned by `rotation_deg` from x towards y. All pixels and heights of one element share their grid and their
place.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, Union

import numpy as np

from raylet._arrays import grid, real_grid
from raylet._calls import checked, listed, public_call, refusal
from raylet._refusal import shown

Layer = dict[str, Any]
Aperture = dict[str, Any]
Pair = Union[float, Sequence[float]]

#: What the arrays of pixels may be: real, or complex as well.
ARRAY_OF = {"phase": real_grid, "amplitude": real_grid, "transmission": grid}


def _layer(kind: str, **keys: Any) -> Layer:
    call = "superposition" if kind == "sum" else kind
    given = {"kind": kind, **{key: value for key, value in keys.items() if value is not None}}
    return checked(f"raylet.{call}", "layer", given)


def _aperture(kind: str, **keys: Any) -> Aperture:
    return checked(f"raylet.{kind}", "aperture", {kind: keys}, inside=kind)


@public_call
def pixels(
    *,
    pitch_um: Pair,
    phase: Any = None,
    amplitude: Any = None,
    transmission: Any = None,
    pixel: str = "box",
    size: Sequence[int] | None = None,
    phase_scale: float = 1.0,
    fill: float = 1.0,
    rest: str = "dark",
    fly_back_um: float = 0.0,
    crosstalk_um: float = 0.0,
    sub_pixels: int = 4,
    centre_mm: Sequence[float] = (0.0, 0.0),
    rotation_deg: float = 0.0,
) -> Layer:
    """A grid of pixels [y, x]: phase in rad and amplitude, or the complex transmission.

    Arrays of float64 and complex128 are not copied: they are looked at when the system is computed. `pixel` says what
    lies between the centres: "box" (constant over each pixel), "point", "bilinear", or "band_limited" for samples at
    twice the Nyquist rate. `size` [nx, ny] makes a blank.
    `phase_scale` multiplies the phase. `fill` is the share of a box pixel's area that carries its value, a rectangle
    about its centre, and `rest` says what the gap around it does: "dark" or "flat" (transmits all).
    The phase of a liquid crystal, taken between 0 and 2π, makes no jumps: where neighbours differ by more than π it
    runs from one to the other on a ramp of `fly_back_um`, and the map of phases is convolved with a Gaussian of the
    standard deviation `crosstalk_um`. Both act on `sub_pixels` parts of a pixel along each axis.
    """
    given = {"phase": phase, "amplitude": amplitude, "transmission": transmission}
    held = {key: ARRAY_OF[key](f"raylet.pixels: {key}", value) for key, value in given.items() if value is not None}
    own = {"pitch_um": pitch_um, "pixel": pixel, "size": size, "phase_scale": phase_scale, "fill": fill, "rest": rest}
    between = {"fly_back_um": fly_back_um, "crosstalk_um": crosstalk_um, "sub_pixels": sub_pixels}
    return _layer("pixels", **own, **between, **held, centre_mm=centre_mm, rotation_deg=rotation_deg)


@public_call
def height(
    *,
    pitch_um: Pair,
    height_um: Any = None,
    glass: Any,
    stands_in: str | None = None,
    pixel: str = "box",
    size: Sequence[int] | None = None,
    centre_mm: Sequence[float] = (0.0, 0.0),
    rotation_deg: float = 0.0,
) -> Layer:
    """A relief of one material, heights [y, x] in µm: phase k(n − n′)h, n′ the index of the medium that it displaces.

    `glass` is a name or an index. Where the element is an interface it is one of the two media, and the relief reaches
    into the other; a third material needs `stands_in`, "before" or "behind". Without heights `size` [nx, ny] makes a
    relief that :meth:`raylet.System.design` is to find."""
    held = None if height_um is None else real_grid("raylet.height: height_um", height_um)
    own = {"pitch_um": pitch_um, "pixel": pixel, "size": size, "stands_in": stands_in}
    own |= {"centre_mm": centre_mm, "rotation_deg": rotation_deg}
    return _layer("height", **own, height_um=held, glass=constant(glass))


def keep_wavelength(layers: Sequence[Layer], wavelength_um: float) -> None:
    """Writes the wavelength for which phases are made into those that have none of their own."""
    for layer in layers:
        if layer.get("kind") in ("lens", "two_point", "kinoform"):
            layer.setdefault("wavelength_um", wavelength_um)
        for term in (
            [*layer.get("terms", []), layer.get("layer", [])] if layer.get("kind") in ("sum", "kinoform") else []
        ):
            keep_wavelength(term, wavelength_um)


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


@public_call
def grating(
    *,
    period_um: float,
    direction_deg: float = 0.0,
    order: int = 1,
    centre_mm: Sequence[float] = (0.0, 0.0),
    rotation_deg: float = 0.0,
) -> Layer:
    """One order of a blazed grating; positive orders turn light from the axis towards `direction_deg`, x to y."""
    own = {"period_um": period_um, "direction_deg": direction_deg, "order": order}
    return _layer("grating", **own, centre_mm=centre_mm, rotation_deg=rotation_deg)


@public_call
def lens(
    *,
    focal_length_mm: float,
    wavelength_um: float | None = None,
    centre_mm: Sequence[float] = (0.0, 0.0),
    rotation_deg: float = 0.0,
) -> Layer:
    """An ideal diffractive lens: equal optical path to its focus at its design wavelength."""
    own = {"focal_length_mm": focal_length_mm, "wavelength_um": wavelength_um}
    return _layer("lens", **own, centre_mm=centre_mm, rotation_deg=rotation_deg)


@public_call
def axicon(
    *,
    angle_deg: float,
    centre_mm: Sequence[float] = (0.0, 0.0),
    rotation_deg: float = 0.0,
) -> Layer:
    """A conical phase that turns light towards its centre by one angle everywhere."""
    return _layer("axicon", angle_deg=angle_deg, centre_mm=centre_mm, rotation_deg=rotation_deg)


@public_call
def vortex(
    *,
    charge: int,
    centre_mm: Sequence[float] = (0.0, 0.0),
    rotation_deg: float = 0.0,
) -> Layer:
    """A spiral phase: charge times the angle about its centre."""
    whole = isinstance(charge, (float, np.floating)) and float(charge).is_integer()
    return _layer("vortex", charge=int(charge) if whole else charge, centre_mm=centre_mm, rotation_deg=rotation_deg)


@public_call
def radial(
    *,
    norm_radius_mm: float,
    coefficients: Sequence[float],
    centre_mm: Sequence[float] = (0.0, 0.0),
    rotation_deg: float = 0.0,
) -> Layer:
    """Phase Σ aᵢ (r/ρ)^{2i} in rad, i from 1."""
    own = {"norm_radius_mm": norm_radius_mm, "coefficients": coefficients}
    return _layer("radial", **own, centre_mm=centre_mm, rotation_deg=rotation_deg)


@public_call
def radial_table(
    *,
    radius_mm: Sequence[float],
    phase_rad: Sequence[float],
    centre_mm: Sequence[float] = (0.0, 0.0),
    rotation_deg: float = 0.0,
) -> Layer:
    """A phase of the radius by samples: the cubic spline through `phase_rad` at `radius_mm`.

    The radii grow from 0 to the edge of the aperture or beyond. The spline is level at the centre; a cone is an axicon
    beside the table. Its error falls with the fourth power of the spacing."""
    own = {"radius_mm": radius_mm, "phase_rad": phase_rad}
    return _layer("radial_table", **own, centre_mm=centre_mm, rotation_deg=rotation_deg)


@public_call
def phase_grid(
    *,
    pitch_um: Pair,
    phase: Any,
    size: Sequence[int] | None = None,
    centre_mm: Sequence[float] = (0.0, 0.0),
    rotation_deg: float = 0.0,
) -> Layer:
    """A smooth phase in rad by samples [y, x] on a centred grid: the bicubic spline through them.

    The phase has no jumps of 2π, and its samples reach to the edge of the aperture or beyond, at least 4 along each
    axis. :func:`raylet.phase_function` samples a function; :func:`raylet.pixels` makes a pixelated element."""
    own = {"pitch_um": pitch_um, "phase": real_grid("raylet.phase_grid: phase", phase), "size": size}
    return _layer("phase_grid", **own, centre_mm=centre_mm, rotation_deg=rotation_deg)


@public_call
def zernike(
    *,
    norm_radius_mm: float,
    coefficients: Sequence[float],
    centre_mm: Sequence[float] = (0.0, 0.0),
    rotation_deg: float = 0.0,
) -> Layer:
    """Zernike polynomials in Noll's order and normalisation, in rad; the first coefficient is piston."""
    own = {"norm_radius_mm": norm_radius_mm, "coefficients": coefficients}
    return _layer("zernike", **own, centre_mm=centre_mm, rotation_deg=rotation_deg)


@public_call
def xy(
    *,
    norm_radius_mm: float,
    terms: Sequence[Sequence[float]],
    centre_mm: Sequence[float] = (0.0, 0.0),
    rotation_deg: float = 0.0,
) -> Layer:
    """Phase Σ a (x/ρ)ⁱ (y/ρ)ʲ in rad by its `terms` (i, j, a): a cubic mask is [(3, 0, a), (0, 3, a)]."""
    rows = listed(terms)
    if isinstance(rows, list):
        rows = [_term(f"terms[{number}]", term) for number, term in enumerate(rows)]
    return _layer("xy", norm_radius_mm=norm_radius_mm, terms=rows, centre_mm=centre_mm, rotation_deg=rotation_deg)


def _term(path: str, term: Any) -> dict[str, Any]:
    """A term (i, j, a) as scenes write it."""
    if not isinstance(term, (Sequence, np.ndarray)) or isinstance(term, str) or len(term) != 3:
        raise refusal("raylet.xy", path, shown(term), "three numbers (i, j, a)")
    return dict(zip(("x", "y", "coefficient"), term))


@public_call
def two_point(
    *,
    object: Mapping[str, Any],
    reference: Mapping[str, Any] | None = None,
    wavelength_um: float | None = None,
    order: int = 1,
    centre_mm: Sequence[float] = (0.0, 0.0),
    rotation_deg: float = 0.0,
) -> Layer:
    """A hologram of two points: it turns the wave of the `reference` into that of the `object`.

    Each is {"point_mm": [x, y, z]} or {"angle_deg": [ax, ay]} on the element's own axes. Light comes from a point on
    the side it comes from, and runs to a point on the side to which it goes. Without a reference the light is
    collimated along the axis. `wavelength_um` is that of the construction. The phase is that of the two waves on the
    element's own surface, plane or curved."""
    waves = {"object": object, "reference": reference, "wavelength_um": wavelength_um}
    return _layer("two_point", **waves, order=order, centre_mm=centre_mm, rotation_deg=rotation_deg)


@public_call
def kinoform(
    layer: Layer | Sequence[Layer],
    *,
    orders: Sequence[int] = (0, 1, 2),
    levels: int | None = None,
    wavelength_um: float | None = None,
    glass: Any = None,
    stands_in: str | None = None,
) -> Layer:
    """Smooth phases folded into a profile whose height makes one wave at the design wavelength, with its `orders`.

    `layer` is an analytic phase, or lists several that add to that of the first order. The profile is a ramp, or has so
    many equal `levels`: 2 make a binary element. Its `glass` gives the dispersion; without it the material has none.
    Where the element is an interface it is one of the two media; a third material needs `stands_in`, "before" or
    "behind"."""
    own = {"layer": listed(layer), "orders": listed(orders), "levels": levels, "wavelength_um": wavelength_um}
    return _layer("kinoform", **own, glass=constant(glass), stands_in=stands_in)


@public_call
def superposition(terms: Sequence[Layer | Sequence[Layer]], weights: Sequence[complex] | None = None) -> Layer:
    """A sum of transmissions, each a layer or the product of a list of them, times its weight: a real or complex
    number."""
    parts = [_parts(weight) for weight in weights] if isinstance(weights, (Sequence, np.ndarray)) else weights
    rows = listed(terms)
    products = [listed(term) for term in rows] if isinstance(rows, list) else rows
    return _layer("sum", terms=products, weights=parts)


def _parts(weight: Any) -> Any:
    """A complex number as scenes write it."""
    return [weight.real, weight.imag] if isinstance(weight, (complex, np.complexfloating)) else weight


@public_call
def disc(radius_mm: float, *, centre_mm: Sequence[float] = (0.0, 0.0)) -> Aperture:
    """A round aperture."""
    return _aperture("disc", radius_mm=radius_mm, centre_mm=centre_mm)


@public_call
def rectangle(
    width_mm: float, height_mm: float, *, rotation_deg: float = 0.0, centre_mm: Sequence[float] = (0.0, 0.0)
) -> Aperture:
    """A rectangular aperture."""
    sides = {"width_mm": width_mm, "height_mm": height_mm}
    return _aperture("rectangle", **sides, rotation_deg=rotation_deg, centre_mm=centre_mm)


@public_call
def annulus(inner_radius_mm: float, outer_radius_mm: float, *, centre_mm: Sequence[float] = (0.0, 0.0)) -> Aperture:
    """A ring."""
    radii = {"inner_radius_mm": inner_radius_mm, "outer_radius_mm": outer_radius_mm}
    return _aperture("annulus", **radii, centre_mm=centre_mm)


@public_call
def regular_polygon(
    sides: int, radius_mm: float, *, rotation_deg: float = 0.0, centre_mm: Sequence[float] = (0.0, 0.0)
) -> Aperture:
    """An aperture with equal sides, such as that of an iris. Its corners are `radius_mm` from its centre; the first one
    lies at `rotation_deg`, from x towards y."""
    return _aperture(
        "regular_polygon", sides=sides, radius_mm=radius_mm, rotation_deg=rotation_deg, centre_mm=centre_mm
    )


@public_call
def polygon(corners_mm: Sequence[Sequence[float]], *, centre_mm: Sequence[float] = (0.0, 0.0)) -> Aperture:
    """An aperture with straight sides, by its corners [x, y] from its centre."""
    return _aperture("polygon", corners_mm=corners_mm, centre_mm=centre_mm)


@public_call
def obstructed(aperture: Aperture, *blocked: Aperture) -> Aperture:
    """An aperture with parts that let nothing through."""
    if not isinstance(aperture, Mapping):
        raise refusal("raylet.obstructed", "aperture", shown(aperture), "a table")
    return checked("raylet.obstructed", "aperture", {**aperture, "blocked": list(blocked)})
