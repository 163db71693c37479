"""Arrays as the library takes them: 2-D float64 or complex128. Arrays of these types are used without a copy."""

from __future__ import annotations

from typing import Any, Union

import numpy as np
from numpy.typing import NDArray

from raylet._refusal import RayletError, cut, shown, type_name

Grid = Union[NDArray[np.float64], NDArray[np.complex128]]


def numbers(name: str, value: Any) -> NDArray[Any]:
    """Anything array-like as float64 or complex128, aligned and in native byte order; not copied if it is already."""
    try:
        array = np.asarray(value)
    except Exception as error:
        # A list that lies too deep, or contains itself, is refused as such in a scene too.
        refusal = RayletError if isinstance(value, (list, tuple)) else TypeError
        raise refusal(f"{name}: {type_name(value)} is no array ({cut(str(error))})") from error
    if isinstance(value, str):
        raise TypeError(f"{name} is the string {shown(value)}, expected numbers; np.load reads them from a file")
    if isinstance(value, np.ma.MaskedArray) and np.ma.is_masked(value):
        raise ValueError(f"{name} has masked values, expected all of them")
    kind = array.dtype.kind
    if kind not in "biufc":
        raise TypeError(f"{name} has elements of type {array.dtype}, expected real or complex numbers")
    wanted = np.dtype(np.complex128 if kind == "c" else np.float64)
    even = all(stride % wanted.itemsize == 0 for stride in array.strides)
    if array.dtype == wanted and array.flags.aligned and even:
        return array
    return np.ascontiguousarray(array, dtype=wanted).reshape(array.shape)


def grid(name: str, value: Any) -> Grid:
    """A 2-D array [y, x]."""
    array = numbers(name, value)
    if array.ndim != 2:
        raise ValueError(f"{name} has shape {array.shape}, expected two axes [y, x]")
    if array.size == 0:
        raise ValueError(f"{name} has shape {array.shape}, expected at least one value")
    return array


def real_grid(name: str, value: Any) -> NDArray[np.float64]:
    """A 2-D array [y, x] of real numbers."""
    array = grid(name, value)
    if array.dtype.kind == "c":
        raise RayletError(f"{name} is a complex array, expected real numbers")
    return real(name, array)


def evaluated(name: str, function: Any, x: NDArray[np.float64], y: NDArray[np.float64]) -> NDArray[Any]:
    """The values [y, x] of a function that is called once, with x as a row and y as a column."""
    if not callable(function):
        raise TypeError(f"{name} is {type_name(function)}, expected a function of x and y")
    shape = (len(y), len(x))
    try:
        given = function(x[None, :], y[:, None])
    except Exception as error:
        raise RayletError(
            f"{name}(x, y) raised {type_name(error)}: {cut(str(error))}, expected {shape} numbers"
        ) from error
    values = numbers(f"{name}(x, y)", given)
    try:
        values = np.ascontiguousarray(np.broadcast_to(values, shape))
    except ValueError as error:
        raise RayletError(
            f"{name}(x, y) has shape {values.shape}, expected {shape} or what broadcasts to it"
        ) from error
    wrong = np.argwhere(~np.isfinite(values))
    if wrong.size:
        j, i = wrong[0]
        place = f"x = {x[i]:.6g} mm, y = {y[j]:.6g} mm"
        raise RayletError(f"{name}(x, y) is {values[j, i]} at {place}, expected finite numbers")
    return values


def real(name: str, value: Any) -> NDArray[np.float64]:
    """Real numbers of any shape."""
    array = numbers(name, value)
    if array.dtype.kind == "c":
        raise TypeError(f"{name} is complex, expected real numbers")
    return array


def number(name: str, value: Any) -> float:
    """One real number."""
    array = real(name, value)
    if array.ndim != 0:
        raise ValueError(f"{name} has shape {array.shape}, expected one number")
    return float(array)


def columns(name: str, value: Any, width: int, rays: int | None = None) -> NDArray[np.float64]:
    """Rows of `width` real numbers, one for each ray."""
    array = real(name, value)
    if array.ndim != 2 or array.shape[1] != width or rays not in (None, array.shape[0]):
        wanted = "rays" if rays is None else rays
        raise ValueError(f"{name} has shape {array.shape}, expected ({wanted}, {width})")
    return array


def column(name: str, value: Any, rays: int, *, default: float | None = None) -> NDArray[np.float64]:
    """One real number for each ray."""
    array = real(name, default if value is None else value)
    if array.ndim == 0:
        array = np.full(rays, float(array))
    if array.shape != (rays,):
        raise ValueError(f"{name} has shape {array.shape}, expected ({rays},)")
    return array


def complex_column(name: str, value: Any, rays: int) -> NDArray[np.complex128]:
    """One complex number for each ray."""
    array = numbers(name, value).astype(np.complex128, copy=False)
    if array.ndim == 0:
        array = np.full(rays, complex(array))
    if array.shape != (rays,):
        raise ValueError(f"{name} has shape {array.shape}, expected ({rays},)")
    return array


def thread_count(threads: Any) -> int | None:
    """A number of threads; None for all processors."""
    if threads is None or (isinstance(threads, (int, np.integer)) and not isinstance(threads, bool)):
        if threads is not None and not 1 <= threads <= 1024:
            raise ValueError(f"threads is {shown(threads)}, expected from 1 to 1024")
        return None if threads is None else int(threads)
    raise TypeError(f"threads is {type_name(threads)}, expected a whole number")
