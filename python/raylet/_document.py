"""A scene as Python holds it, a document with arrays in it, and the files in which both are left."""

from __future__ import annotations

import io
import os
import re
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from raylet import _raylet
from raylet._arrays import grid
from raylet._refusal import check_level, type_name

#: Keys that hold an array, or the name of its file: of sources, layers, shapes, holograms and losses.
ARRAYS = ("samples", "phase", "amplitude", "transmission", "height_um", "target", "picture", "mask")

#: What stands in a document in place of an array in memory.
_IN_MEMORY = "array in memory"


def taken_out(value: Any, path: str, arrays: dict[str, NDArray[Any]], level: int = 0) -> Any:
    """A document whose arrays in memory are moved to `arrays`, by their paths."""
    check_level(level, path)
    if isinstance(value, Mapping):
        inside = {}
        for key, item in value.items():
            here = f"{path}.{key}" if path else str(key)
            if key in ARRAYS and not isinstance(item, (str, os.PathLike, int, float, np.number, type(None))):
                arrays[here] = grid(here, item)
                item = _IN_MEMORY
            inside[key] = taken_out(item, here, arrays, level + 1)
        return inside
    if isinstance(value, (list, tuple)):
        return [taken_out(item, f"{path}[{i}]", arrays, level + 1) for i, item in enumerate(value)]
    return value


def put_in(document: Any, arrays: Mapping[str, Any]) -> None:
    """Puts arrays, or the names of their files, into a document at their paths."""
    for path, array in arrays.items():
        *way, last = [int(step) if step.isdigit() else step for step in re.findall(r"\w+", path)]
        place = document
        for step in way:
            place = place[step]
        place[last] = array
        place.pop("key", None)


def rebased(value: Any, before: str, after: str) -> None:
    """Names the files of a document in the folder `before` as they are seen from the folder `after`."""
    for key, item in value.items() if isinstance(value, dict) else enumerate(value):
        if isinstance(item, (dict, list)):
            rebased(item, before, after)
        elif key in ARRAYS and isinstance(item, (str, os.PathLike)):
            value[key] = os.path.relpath(os.path.join(before, item), after or ".")


def element_names(document: Mapping[str, Any]) -> list[str]:
    """What the elements of a document are called: by their names, or by their places where they have none."""
    return [row.get("name") or f"element[{number}]" for number, row in enumerate(document["element"])]


def copied(value: Any, path: str = "", level: int = 0) -> Any:
    """A copy of a document that shares its arrays."""
    check_level(level, path)
    if isinstance(value, Mapping):
        return {key: copied(item, f"{path}.{key}", level + 1) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [copied(item, f"{path}[{i}]", level + 1) for i, item in enumerate(value)]
    return value


def without_none(value: Any) -> Any:
    """A document without the keys that have no value."""
    if isinstance(value, Mapping):
        return {key: without_none(item) for key, item in value.items() if item is not None}
    return [without_none(item) for item in value] if isinstance(value, list) else value


def write(files: Mapping[str | os.PathLike[str], bytes], *, overwrite: bool) -> None:
    """Writes files, whole or not at all and never in the place of what raylet did not write; all are checked before the
    first is written."""
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
