"""Sources: how the amplitude of a beam, or of a point's light, falls off aside, and light of extended sources.

A taper is a small dictionary that :meth:`raylet.System.plane_wave` or :meth:`raylet.System.point_source` takes as its
`taper`; keys are those of scene files. The amplitude is exp(−ρ^{2m}), ρ² = (u/a)² + (v/b)², with the order m: the
intensity is 1/e² of that in the middle where ρ = 1.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from raylet._arrays import evaluated, number, real
from raylet._calls import checked, public_call
from raylet._refusal import RayletError, shown
from raylet.layers import Pair
from raylet.sweep import Sweep

Taper = dict[str, Any]


@public_call
def beam_taper(
    radius_mm: Pair, *, order: int = 1, centre_mm: Sequence[float] = (0.0, 0.0), rotation_deg: float = 0.0
) -> Taper:
    """The taper of a collimated beam, as of a laser: `radius_mm` along both axes or along each, about `centre_mm`
    [x, y] from the first element's vertex. `order` 1 is a Gaussian, more has a flatter top."""
    own = {"radius_mm": radius_mm, "order": order, "centre_mm": centre_mm, "rotation_deg": rotation_deg}
    return checked("raylet.beam_taper", "beam taper", own)


@public_call
def cone_taper(
    half_angle_deg: Pair | None = None,
    *,
    numerical_aperture: Pair | None = None,
    order: int = 1,
    angle_deg: Sequence[float] = (0.0, 0.0),
    rotation_deg: float = 0.0,
) -> Taper:
    """The taper of a point's light over directions, as of a laser diode: by half angles or by numerical apertures,
    along both axes or along each. u and v are direction cosines across the middle, whose direction is `angle_deg`
    [ax, ay]."""
    own = {"half_angle_deg": half_angle_deg, "numerical_aperture": numerical_aperture, "order": order}
    return checked("raylet.cone_taper", "cone taper", {**own, "angle_deg": angle_deg, "rotation_deg": rotation_deg})


def sampled(function: Callable[[Any, Any], Any], pitch_um: Pair, size: Sequence[int] | None) -> NDArray[Any]:
    """The samples [y, x] of a function of x and y in mm, about the middle."""
    if size is None:
        raise TypeError("System.field_source: size is not given, expected [nx, ny] for samples that are a function")
    pitch = np.broadcast_to(real("pitch_um", pitch_um), 2)
    x, y = (1e-3 * step * (np.arange(int(n)) - 0.5 * (int(n) - 1)) for step, n in zip(pitch, size))
    return evaluated("System.field_source: samples", function, x, y)


@dataclass(frozen=True, eq=False)
class ExtendedSource:
    """Points or directions that stand for an incoherent source, with their weights.

    Attributes
    ----------
    fields : what :meth:`raylet.System.simulate` takes.
    weights : their shares of the light, which add to one, for :meth:`raylet.Sweep.incoherent`.
    coarse_weights : those of a rule of half the order, which leaves out most of them; for a list of points the same.
    """

    fields: NDArray[np.float64]
    weights: NDArray[np.float64]
    coarse_weights: NDArray[np.float64]

    def image(self, sweep: Sweep) -> tuple[NDArray[np.float64], float]:
        """The intensity of the source on the sensor, from a sweep over its fields, and the error of the sum: its
        distance from that of half the order, relative to it. As a rule the intensity itself is off by much
        less. It is zero for a list of points."""
        fine, coarse = (np.asarray(sweep.incoherent(weights)) for weights in (self.weights, self.coarse_weights))
        return fine, float(np.linalg.norm(fine - coarse) / np.linalg.norm(fine))


@public_call
def point_list(*, places_mm: Any = None, angles_deg: Any = None, weights: Any = None) -> ExtendedSource:
    """Incoherent points [x, y, z] in mm, or directions [ax, ay] in degrees of collimated light, with their shares of
    the light: numbers from zero, which need not add to one, or equal shares without them. The sum over them is
    exact."""
    fields, key = _one_of(("places_mm", places_mm, 3), ("angles_deg", angles_deg, 2), ("points",))
    given = np.ones(len(fields)) if weights is None else real("weights", weights)
    if given.shape != (len(fields),):
        raise ValueError(f"weights has shape {given.shape}, expected {(len(fields),)}, one for each of {key}")
    if not np.isfinite(given).all() or (given < 0.0).any() or given.sum() <= 0.0:
        raise ValueError("weights holds negative or not finite numbers or only zeros, expected numbers from zero")
    shares = given / given.sum()
    return ExtendedSource(fields, shares, shares)


@public_call
def line_source(*, ends_mm: Any = None, ends_deg: Any = None, intervals: int = 8) -> ExtendedSource:
    """An evenly bright, incoherent line between two points [x, y, z] in mm, or between two directions [ax, ay] in
    degrees of collimated light.

    The intensity is integrated by Clenshaw and Curtis's rule over so many `intervals`, an even number."""
    ends, _ = _one_of(("ends_mm", ends_mm, 3), ("ends_deg", ends_deg, 2), (2,))
    places, weights, coarse = _clenshaw_curtis("intervals", intervals)
    return ExtendedSource(ends[0] + places[:, None] * (ends[1] - ends[0]), weights, coarse)


@public_call
def disc_source(
    *,
    centre_mm: Any = None,
    radius_mm: float | None = None,
    centre_deg: Any = None,
    radius_deg: float | None = None,
    rings: int = 4,
    angles: int = 8,
) -> ExtendedSource:
    """An evenly bright, incoherent disc about a point [x, y, z] in mm, at right angles to z, or about a direction
    [ax, ay] in degrees of collimated light.

    The intensity is integrated over rings by Clenshaw and Curtis's rule over the square of the radius, and around each
    at equal `angles`; both are even numbers."""
    centre, key = _one_of(("centre_mm", centre_mm, 3), ("centre_deg", centre_deg, 2), ())
    given = {"centre_mm": ("radius_mm", radius_mm), "centre_deg": ("radius_deg", radius_deg)}[key]
    if given[1] is None:
        raise TypeError(f"{given[0]} is not given, expected it beside {key}")
    squares, along, coarse_along = _clenshaw_curtis("rings", rings)
    _even("angles", angles)
    turn = 2.0 * np.pi * np.arange(angles) / angles
    around = np.stack([np.cos(turn), np.sin(turn)], axis=1)
    offsets = number(given[0], given[1]) * np.sqrt(squares[1:, None, None]) * around
    fields = np.tile(centre, (1 + rings * angles, 1))
    fields[1:, :2] += offsets.reshape(-1, 2)
    every, other = np.full(angles, 1.0 / angles), np.where(np.arange(angles) % 2 == 0, 2.0 / angles, 0.0)
    weights = [
        np.concatenate([ring[:1], np.outer(ring[1:], shares).ravel()])
        for ring, shares in ((along, every), (coarse_along, other))
    ]
    return ExtendedSource(fields, weights[0], weights[1])


def _one_of(first: tuple[str, Any, int], second: tuple[str, Any, int], before: tuple[int | str, ...]) -> Any:
    """The one of two arguments that is given, with its name: an array whose last axis has so many numbers, behind axes
    of these lengths; one that has a name in place of a length has one from 1."""
    given = [one for one in (first, second) if one[1] is not None]
    if len(given) != 1:
        raise TypeError(f"{first[0]} or {second[0]} is expected, found {'both' if given else 'neither'}")
    name, value, count = given[0]
    array, wanted = real(name, value), (*before, count)
    fits = (found >= 1 if isinstance(length, str) else found == length for found, length in zip(array.shape, wanted))
    if array.ndim != len(wanted) or not all(fits):
        raise ValueError(f"{name} has shape {array.shape}, expected ({', '.join(map(str, wanted))})")
    if not np.isfinite(array).all():
        raise ValueError(f"{name} holds numbers that are not finite")
    return array, name


def _even(name: str, count: Any) -> None:
    whole = isinstance(count, (int, np.integer)) and not isinstance(count, bool)
    if not whole or count < 2 or count % 2:
        raise RayletError(f"{name} is {shown(count)}, expected an even number from 2")


def _clenshaw_curtis(name: str, intervals: int) -> tuple[NDArray[Any], NDArray[Any], NDArray[Any]]:
    """Nodes from 0 to 1, the weights of the rule, and those of the rule of half the order on every second node."""
    _even(name, intervals)

    def rule(n: int) -> NDArray[Any]:
        # The integral of the interpolating sum of cosines, at angles pi j / n.
        orders = np.arange(0, n + 1, 2)
        integrals = np.where(orders == n, 0.5, 1.0) * np.where(orders == 0, 0.5, 1.0) * 2.0 / (1.0 - orders**2)
        cosines = np.cos(np.pi * np.outer(np.arange(n + 1), orders) / n)
        weights = cosines @ integrals / n
        weights[[0, -1]] *= 0.5
        return np.asarray(weights)

    coarse = np.zeros(intervals + 1)
    coarse[::2] = rule(intervals // 2)
    return 0.5 * (1.0 - np.cos(np.pi * np.arange(intervals + 1) / intervals)), rule(intervals), coarse
