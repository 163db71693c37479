"""Phases of elements and shapes of surfaces that are functions of x and y.

Each function is called once, with x in mm as a row and y in mm as a column of an array, and gives an array of [y, x] or
what broadcasts to it. Between its samples is a bicubic spline, whose error is some pitch⁴/100 times the fourth
derivative: half the pitch, a sixteenth of the error.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from raylet._arrays import evaluated, real
from raylet._calls import public_call
from raylet._refusal import RayletError
from raylet.layers import Layer, Pair, phase_grid

#: Intervals between samples along an axis where no pitch is given, the fewest for a spline, and the most.
_INTERVALS, _FEWEST, _MOST = 256, 3, 20_000


@public_call
def phase_function(
    phase: Callable[[Any, Any], Any],
    *,
    extent_mm: Pair,
    pitch_um: Pair | None = None,
    centre_mm: Sequence[float] = (0.0, 0.0),
    rotation_deg: float = 0.0,
) -> Layer:
    """A smooth phase in rad that is a function of x and y in mm: a :func:`raylet.phase_grid`.

    `extent_mm` is the full width along both axes or along each, about the centre of the phase; it reaches to the edge
    of the aperture or beyond. Samples stand `pitch_um` apart or a little closer, or without it at 1/256 of the extent.
    The phase has no jumps of 2π."""
    pitch, values = _samples("phase_function", "phase", phase, extent_mm, pitch_um)
    return phase_grid(pitch_um=pitch, phase=values, centre_mm=centre_mm, rotation_deg=rotation_deg)


@public_call
def sag_function(sag: Callable[[Any, Any], Any], *, extent_mm: Pair, pitch_um: Pair | None = None) -> dict[str, Any]:
    """A shape of a surface whose sag in mm is a function of x and y in mm: what surfaces, mirrors and elements take as
    `shape`. It is added to their conic.

    `extent_mm` is the full width along both axes or along each, about the vertex, and the surface ends there. Samples
    stand `pitch_um` apart or a little closer, or without it at 1/256 of the extent."""
    pitch, values = _samples("sag_function", "sag", sag, extent_mm, pitch_um)
    return {"kind": "grid", "pitch_um": pitch, "height_um": 1e3 * values}


def _samples(
    call: str, name: str, function: Any, extent_mm: Pair, pitch_um: Pair | None
) -> tuple[list[float], NDArray[np.float64]]:
    """The pitch [x, y] in µm of a centred grid over an extent, and the values [y, x] of a function on it."""
    extent = 1e3 * _pair(f"raylet.{call}: extent_mm", extent_mm)
    wanted = extent / _INTERVALS if pitch_um is None else _pair(f"raylet.{call}: pitch_um", pitch_um)
    counts = np.maximum(np.ceil(extent / wanted * (1.0 - 1e-12)), _FEWEST)
    if counts.max() > _MOST:
        raise RayletError(
            f"raylet.{call}: pitch_um makes {counts.max() + 1:.0f} samples along an axis, expected at most {_MOST + 1}"
        )
    pitch = extent / counts
    x, y = (1e-3 * step * (np.arange(int(count) + 1) - 0.5 * count) for step, count in zip(pitch, counts))
    return pitch.tolist(), real(f"raylet.{call}: {name}(x, y)", evaluated(f"raylet.{call}: {name}", function, x, y))


def _pair(name: str, value: Any) -> NDArray[np.float64]:
    """One number above zero for both axes, or two."""
    given = real(name, value)
    if given.shape not in ((), (2,)) or not (np.isfinite(given) & (given > 0.0)).all():
        raise RayletError(f"{name} is {given.tolist()}, expected a number above zero, or two for x and y")
    return np.broadcast_to(given, 2)
