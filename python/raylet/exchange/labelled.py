"""Fields whose axes have names and units, for xarray."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    import xarray


def dataset(
    field: NDArray[np.complex128], x_mm: NDArray[Any], y_mm: NDArray[Any], wavelength_um: NDArray[Any]
) -> xarray.Dataset:
    """A field [wavelength, y, x] with its axes."""
    try:
        import xarray
    except ImportError as error:
        raise ImportError("to_xarray needs the package xarray: pip install xarray") from error
    axes = {
        "wavelength_um": ("wavelength_um", wavelength_um, {"units": "um", "long_name": "vacuum wavelength"}),
        "y_mm": ("y_mm", y_mm, {"units": "mm", "long_name": "y on the sensor"}),
        "x_mm": ("x_mm", x_mm, {"units": "mm", "long_name": "x on the sensor"}),
    }
    words = {"units": "1", "long_name": "complex amplitude, exp(+ikz), 1 at the source"}
    return xarray.Dataset({"field": (tuple(axes), field, words)}, coords=axes)
