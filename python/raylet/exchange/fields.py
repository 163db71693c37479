"""Complex fields with their axes, from and to files of other programs."""

from __future__ import annotations

import os
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np
from numpy.typing import NDArray

from raylet import _raylet
from raylet._arrays import numbers, real
from raylet._calls import public_call
from raylet._refusal import RayletError, described

if TYPE_CHECKING:
    import xarray


class _Fields(Protocol):
    """What is written: a result, or a sampled field."""

    @property
    def field(self) -> NDArray[np.complex128]: ...


@dataclass(frozen=True, eq=False, repr=False)
class SampledField:
    """A complex field on a grid.

    Attributes
    ----------
    field : complex amplitude, exp(+ikz): [wavelength, y, x], or [y, x] of one wavelength; rows grow with y.
    x_mm, y_mm : positions of columns and rows, ascending.
    wavelength_um : vacuum wavelengths.
    report : what a beam file said, such as its scale; "" for other files.
    """

    field: NDArray[np.complex128]
    x_mm: NDArray[np.float64]
    y_mm: NDArray[np.float64]
    wavelength_um: NDArray[np.float64]
    report: str = ""

    def to_xarray(self) -> xarray.Dataset:
        """The field as an `xarray.Dataset`; see :meth:`raylet.Result.to_xarray`."""
        from raylet.exchange.labelled import dataset

        return dataset(*_whole(self))

    def placed(self, wavelength_um: Any) -> tuple[NDArray[np.complex128], tuple[float, float], tuple[float, float]]:
        """Samples [y, x], pitch in µm and the place of their middle in mm, of a field of one wavelength as a source."""
        values, x, y, waves = _whole(self)
        wanted = np.atleast_1d(wavelength_um)
        if len(waves) != 1 or len(wanted) != 1 or abs(waves[0] - wanted[0]) > 1e-9 * wanted[0]:
            raise RayletError(
                f"a field at {_listed(waves)} µm, expected the one wavelength of the system: {_listed(wanted)} µm"
            )
        steps, middles = [], []
        for name, axis in (("x_mm", x), ("y_mm", y)):
            step = (axis[-1] - axis[0]) / (len(axis) - 1) if len(axis) > 1 else 0.0
            even = axis[0] + step * np.arange(len(axis))
            if not step > 0.0 or np.abs(axis - even).max() > 1e-6 * step:
                raise RayletError(f"{name} with unequal steps, expected ascending, equally spaced positions")
            steps.append(1e3 * step)
            middle = 0.5 * (axis[0] + axis[-1])
            middles.append(middle if abs(middle) > 1e-9 * step else 0.0)
        return values[0], (steps[0], steps[1]), (middles[0], middles[1])

    @described
    def __repr__(self) -> str:
        shape, waves = np.shape(self.field), np.atleast_1d(self.wavelength_um)
        return f"<raylet.SampledField {shape[-1]} x {shape[-2]}, {len(waves)} wavelengths>"


@public_call
def read_beam(path: str | os.PathLike[str], *, component: str = "x", sphere: bool = False) -> SampledField:
    """Reads a field: a folder of results, a .npz, FITS or HDF5 file, or a beam file of OpticStudio (.zbf).

    `component` ("x" or "y") and `sphere` are those of `raylet convert`, for beam files.
    """
    field, x, y, waves, report = _raylet.read_beam(path, component, sphere)
    return SampledField(field, x, y, waves, report)


@public_call
def write_beam(
    field: _Fields,
    path: str | os.PathLike[str],
    *,
    wavelength: int | None = None,
    overwrite: bool = False,
) -> str:
    """Writes the field of a result or a :class:`SampledField`; the end of `path` decides on the format: .fits, .h5,
    .npz or .zbf. Gives the report of `raylet convert`.

    `wavelength` takes one of several, counted from 1. Files that raylet did not write are refused unless `overwrite` is
    true.
    """
    values, x, y, waves = _whole(field)
    return _raylet.write_beam(values, x, y, waves, path, wavelength, overwrite)


def _listed(waves: NDArray[Any]) -> str:
    """Wavelengths as text."""
    return ", ".join(f"{wave:.9g}" for wave in waves)


def _whole(
    given: Any,
) -> tuple[NDArray[np.complex128], NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """Field [wavelength, y, x], positions and wavelengths of a result or a sampled field."""
    values = np.ascontiguousarray(numbers("field", given.field), dtype=np.complex128)
    if values.ndim not in (2, 3):
        raise ValueError(f"field has shape {values.shape}, expected [y, x] or [wavelength, y, x]")
    values = values if values.ndim == 3 else values[None]
    axes = [
        np.ascontiguousarray(np.atleast_1d(real(name, getattr(given, name))))
        for name in ("x_mm", "y_mm", "wavelength_um")
    ]
    for name, axis, length in zip(("x_mm", "y_mm", "wavelength_um"), axes, values.shape[::-1]):
        if axis.shape != (length,):
            raise ValueError(f"{name} has shape {axis.shape}, expected ({length},) as field has shape {values.shape}")
    return values, axes[0], axes[1], axes[2]
