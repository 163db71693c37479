"""Files that are left: whole or not at all, and never in the place of what raylet did not write."""

from __future__ import annotations

import io
import os
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from raylet import _raylet
from raylet._refusal import type_name


def write(files: Mapping[str | os.PathLike[str], bytes], *, overwrite: bool) -> None:
    """Writes files; all are checked before the first is written."""
    if not isinstance(overwrite, bool):
        raise TypeError(f"overwrite is {type_name(overwrite)}, expected True or False")
    _raylet.write_files([(os.fspath(path), content) for path, content in files.items()], overwrite)


def npy(array: NDArray[Any]) -> bytes:
    """An array as the content of a .npy file."""
    file = io.BytesIO()
    np.save(file, array)
    return file.getvalue()


def npz(**arrays: NDArray[Any]) -> bytes:
    """Arrays by name as the content of a .npz file."""
    file = io.BytesIO()
    np.savez(file, **arrays)  # type: ignore[arg-type]
    return file.getvalue()
