"""Lens files: systems written for other programs, lenses that raylet carries, folders of lens files of your own."""

from __future__ import annotations

import json
import os
import warnings
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Union, overload

from raylet import _raylet
from raylet._calls import public_call, public_calls
from raylet._refusal import RayletError, shown
from raylet.fabrication import ExportReport
from raylet.system import System, imported

#: A system, or the name of a scene (.toml) or of another lens file.
LensSource = Union[System, str, "os.PathLike[str]"]


@dataclass(frozen=True)
class Lens:
    """A lens in a list. Lengths are in mm, along the unfolded axis, at the primary wavelength of its file."""

    #: The path of its file, or its part number.
    path: str
    #: The title in the file, or what it is.
    name: str
    maker: str | None
    focal_length_mm: float | None
    diameter_mm: float
    f_number: float | None
    #: Surfaces that bend light.
    surfaces: int
    wavelength_um: float


@public_call
def export_lens(
    source: LensSource, path: str | os.PathLike[str], *, skip_unknown: bool = False, overwrite: bool = False
) -> ExportReport:
    """Writes a system as a lens file of OpticStudio (.zmx) or CODE V (.seq); the end of `path` decides.

    `source` may be the name of a scene or of another lens file, too. The report says what was changed and left out.
    Elements that the file cannot hold, such as grids of pixels, are refused, or left out with a warning if
    `skip_unknown`. Files that raylet did not write are refused unless `overwrite` is true."""
    target = os.fspath(path)
    if isinstance(source, System):
        made = _raylet.export_lens(source._compiled(), target, skip_unknown, overwrite)
    elif isinstance(source, (str, os.PathLike)):
        made = _raylet.export_lens_file(os.fspath(source), target, skip_unknown, overwrite)
    else:
        raise RayletError(f"raylet.export_lens: source is {shown(source)}, expected a system or the name of a file")
    text, numbers, doubts = made
    for doubt in doubts:
        warnings.warn(doubt, stacklevel=3)
    return ExportReport(text, dict(numbers))


@overload
def catalog() -> list[Lens]: ...
@overload
def catalog(name: str, *, field: int = ..., wavelength: int | None = ...) -> System: ...
@public_call
def catalog(name: str | None = None, *, field: int = 1, wavelength: int | None = None) -> System | list[Lens]:
    """The system of a lens that raylet carries, by its part number; without a name all of them.

    >>> import raylet
    >>> [lens.path for lens in raylet.catalog() if lens.maker == "Thorlabs"]
    ['ACL3026U', 'LA1131-A']
    >>> system = raylet.catalog("65-564")

    `field` and `wavelength` are numbers from 1, as of :func:`raylet.load`."""
    if name is None:
        return [_lens(*row) for row in _raylet.catalog()]
    if not isinstance(name, str):
        raise RayletError(f"raylet.catalog: name is {shown(name)}, expected a part number such as '65-564'")
    for word, value in (("field", field), ("wavelength", wavelength)):
        if value is not None and (not isinstance(value, int) or value < 1):
            raise RayletError(f"raylet.catalog: {word} is {shown(value)}, expected a number from 1")
    scene, report, _ = _raylet.Scene.catalog_lens(name, (field, wavelength))
    return imported(scene, report, name)


@public_calls
class LensFolder:
    """The lens files (.zmx, .zar, .seq) of a folder and of the folders in it, as a list that can be searched.

    All files are read once. With `index`, the name of a file that raylet may write, only files of another size or time
    than there are read again.

    >>> import raylet
    >>> folder = raylet.LensFolder("scenes/prescriptions")
    >>> [lens.name for lens in folder.search(focal_length_mm=(99, 101), text="achromatic")]
    ['32327 Achromatic Lens']
    """

    def __init__(self, path: str | os.PathLike[str], *, index: str | os.PathLike[str] | None = None) -> None:
        self._path = os.fspath(path)
        self._folder = _raylet.LensFolder(self._path, None if index is None else os.fspath(index))

    def __len__(self) -> int:
        return self._folder.counts()[0]

    def __repr__(self) -> str:
        return f"LensFolder({self._path!r}): {len(self)} lens files, {len(self.faults)} of them not read"

    @property
    def read(self) -> int:
        """How many files were read now; the index had the others."""
        return self._folder.counts()[1]

    @property
    def faults(self) -> dict[str, str]:
        """The files that could not be read, each with why."""
        return dict(self._folder.faults())

    def search(
        self,
        *,
        focal_length_mm: Sequence[float] | None = None,
        diameter_mm: Sequence[float] | None = None,
        f_number: Sequence[float] | None = None,
        maker: str | None = None,
        text: str | None = None,
    ) -> list[Lens]:
        """The lenses that fit, by their paths: ranges from the smallest to the largest value, a part of the maker's
        name, and words of the name or the path. Capitals do not matter. :func:`raylet.load` reads one by its path."""
        ranges = (
            _range("focal_length_mm", focal_length_mm),
            _range("diameter_mm", diameter_mm),
            _range("f_number", f_number),
        )
        return [_lens(*row) for row in self._folder.search(ranges, maker, text)]


def _lens(path: str, facts: str) -> Lens:
    known: dict[str, Any] = json.loads(facts)
    return Lens(path, **known)


def _range(name: str, value: Sequence[float] | None) -> tuple[float, float] | None:
    """A pair of numbers, the smaller one first."""
    if value is None:
        return None
    try:
        low, high = (float(number) for number in value)
    except (TypeError, ValueError):
        low, high = 1.0, 0.0
    if not low <= high:
        expected = "two numbers, the smaller one first"
        raise RayletError(f"LensFolder.search: {name} is {shown(value)}, expected {expected}")
    return low, high
