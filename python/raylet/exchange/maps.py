"""Measured maps: heights, phases and fields on a grid, in the formats of instruments and of other programs."""

from __future__ import annotations

import os
from dataclasses import dataclass
from typing import Union

import numpy as np
from numpy.typing import NDArray

from raylet import _raylet
from raylet._arrays import number
from raylet._calls import public_call
from raylet._refusal import RayletError, described, shown


@dataclass(frozen=True, eq=False, repr=False)
class Map:
    """Samples on a grid, as :func:`read_map` finds them.

    Attributes
    ----------
    values : [y, x] as the file has them, in its `unit`; the first row is at the smallest y. NaN where one is missing.
    pitch_um : distance of neighbouring samples along x and y; None where the file does not say it.
    unit : such as "m"; None where the file does not say it.
    quantity : what the values are, such as "height"; "" where the file does not say it.
    doubts : what the file leaves open. Scenes refuse a map with doubts.
    """

    values: Union[NDArray[np.float64], NDArray[np.complex128]]
    pitch_um: tuple[float, float] | None
    unit: str | None
    quantity: str
    doubts: list[str]

    @property
    def missing(self) -> NDArray[np.bool_]:
        """Where samples are missing."""
        return np.asarray(np.isnan(self.values))

    @property
    def height_um(self) -> NDArray[np.float64]:
        """The values in µm, for the key `height_um`; refused where the file does not say a unit of length."""
        factor = _raylet.unit_factor(self.unit, "height_um") if self.unit is not None else None
        if factor is None or self.values.dtype.kind == "c":
            raise RayletError(f"a map in {shown(self.unit)}, expected real values in a unit of length such as m or nm")
        return np.asarray(factor * self.values, dtype=np.float64)

    @described
    def __repr__(self) -> str:
        ny, nx = self.values.shape
        pitch = "" if self.pitch_um is None else f" of {self.pitch_um[0]:.6g} x {self.pitch_um[1]:.6g} µm"
        lost = int(np.count_nonzero(self.missing))
        quantity = f", {self.quantity}" if self.quantity else ""
        unit = f" in {self.unit}" if self.unit else ""
        text = f"<raylet.Map {nx} x {ny}{pitch}{quantity}{unit}, {lost} missing>"
        return "\n".join([text] + [f"  doubt: {doubt}" for doubt in self.doubts])


@public_call
def read_map(path: str | os.PathLike[str], *, key: str | None = None, fill: float | str | None = None) -> Map:
    """Reads a map: a file of Zygo's MetroPro (.dat), a TIFF picture, a FITS or HDF5 file, or a NumPy file.

    `key` names an array of a .npz or HDF5 file, or an extension of a FITS file. `fill` puts a number, or with "nearest"
    the nearest sample, in the place of missing samples; without it they are NaN. The page "Fields and maps" of the
    guide has units and orientations of the formats.
    """
    value, nearest = None, False
    if isinstance(fill, str):
        if fill != "nearest":
            raise RayletError(f'fill is {shown(fill)}, expected a number or "nearest"')
        nearest = True
    elif fill is not None:
        value = number("fill", fill)
    real, samples, pitch, unit, quantity, doubts = _raylet.read_map(path, key, value, nearest)
    values = real if samples is None else samples
    assert values is not None
    return Map(values, None if pitch is None else (pitch[0], pitch[1]), unit, quantity, doubts)
