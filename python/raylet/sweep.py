"""What a system gives for several fields, wavelengths and distances."""

from __future__ import annotations

import csv
import io
import os
import warnings
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, TypedDict

import numpy as np
from numpy.typing import NDArray

from raylet import _raylet
from raylet._arrays import real, thread_count
from raylet._document import write
from raylet._refusal import RayletError, described, shown
from raylet.layers import keep_wavelength
from raylet.progress import Progress, reporting
from raylet.result import Result
from raylet.sweep_table import FIELDS, SweepTable

if TYPE_CHECKING:
    from raylet.system import System

#: The key of a field in each kind of source that has fields, and its numbers.
_SOURCES = {"plane": ("angle_deg", 2), "gaussian": ("angle_deg", 2), "point": ("position_mm", 3)}


class RunSettings(TypedDict, total=False):
    """The settings of a run that :meth:`raylet.System.simulate` takes."""

    method: str | None
    target_error: float | None
    threads: int | None
    memory_limit_mb: float | None
    seed: int | None
    progress: Progress


def sweep(system: System, lists: Mapping[str, Any], follow: bool, settings: RunSettings) -> Sweep:
    """Runs a system for each field, wavelength in µm and distance in mm of three lists, whose names are those of the
    caller's arguments; a list that is None is not varied."""
    names = list(lists)
    if lists[names[1]] is None and len(system.wavelength_um) > 1:
        raise TypeError(f"{names[1]} is not given, expected which of the system's several wavelengths to take")
    fields, waves, distances = (
        None if lists[name] is None else _checked(name, lists[name], axes) for name, axes in zip(names, (2, 1, 1))
    )
    if fields is not None:
        _check_fields(names[0], fields, system._document["source"]["kind"])
    if distances is not None and len(system._document["element"]) < 2:
        raise RayletError(f"{names[2]} lead from the last element to the sensor, found no element")
    systems = [
        _at(system, field, wave, distance, follow)
        for field in _or_as_it_is(fields)
        for wave in _or_as_it_is(waves)
        for distance in _or_as_it_is(distances)
    ]
    results = run_all(systems, **settings)
    for result in results:
        # The line that is warned of is the user's: three calls lead from it to here.
        for warning in result.warnings:
            warnings.warn(warning, stacklevel=4)
    angles, lengths, ways = (None if values is None else values.tolist() for values in (fields, waves, distances))
    return Sweep(angles, lengths, ways, results)


def run_all(
    systems: Sequence[System],
    *,
    method: str | None = None,
    target_error: float | None = None,
    threads: int | None = None,
    memory_limit_mb: float | None = None,
    seed: int | None = None,
    progress: Progress = None,
) -> list[Result]:
    """The results of systems that run side by side, each at all its wavelengths; warns of nothing."""
    chosen = {"method": method, "target_error": target_error, "memory_limit_mb": memory_limit_mb}
    given = {key: value for key, value in chosen.items() if value is not None}
    scenes = [system._compiled(seed, given) for system in systems]
    arrays = [system._arrays for system in systems]
    with reporting(progress, "to '{}'" if len(systems) == 1 else "{}") as report:
        answers = _raylet.simulate(scenes, arrays, thread_count(threads), report)
    return [
        Result._of(answer, several=isinstance(system._document["wavelength_um"], list), title=system.title)
        for system, answer in zip(systems, answers)
    ]


def _checked(name: str, given: Any, axes: int) -> NDArray[np.float64]:
    """A list of real numbers, or of fields."""
    values = real(name, given)
    if values.size == 0:
        raise ValueError(f"{name} is empty, expected at least one")
    if values.ndim != axes:
        wanted = "(runs,)" if axes == 1 else "(runs, 2) for angles or (runs, 3) for places"
        raise ValueError(f"{name} has shape {values.shape}, expected {wanted}")
    return values


def _check_fields(name: str, fields: NDArray[np.float64], kind: str) -> None:
    """Refuses fields that the source has not."""
    if kind not in _SOURCES:
        raise TypeError(f"{name} is given for a source of kind {shown(kind)}, expected one of {', '.join(_SOURCES)}")
    key, count = _SOURCES[kind]
    if fields.shape[1] != count:
        wanted = f"({len(fields)}, {count}) for the {key} of a source of kind {shown(kind)}"
        raise ValueError(f"{name} has shape {fields.shape}, expected {wanted}")


def _or_as_it_is(values: NDArray[np.float64] | None) -> list[Any]:
    """The values that are varied; one run as the system is where there are none."""
    return [None] if values is None else values.tolist()


def _at(system: System, field: Any, wavelength_um: Any, distance_mm: Any, follow: bool) -> System:
    """The system in another field, at another wavelength, with its sensor at another distance."""
    other = system._copy()
    document = other._document
    if field is not None:
        document["source"] = {**document["source"], _SOURCES[document["source"]["kind"]][0]: field}
    if wavelength_um is not None:
        made_for = system.wavelength_um[0]
        for element in document["element"]:
            keep_wavelength(element.get("layer", []), made_for)
        document["wavelength_um"] = wavelength_um
    if distance_mm is not None:
        document["element"][-2]["thickness_mm"] = distance_mm
    return _following(other) if follow else other


def _following(system: System) -> System:
    """The system with its sensor about the chief ray."""
    landing = _raylet.chief_landing(system._compiled(), system._arrays)
    if landing is None:
        raise RayletError("the chief ray does not come to the sensor, expected that it does: set follow=False")
    moved = system._copy()
    row = moved._document["element"][-1]
    row["decenter_mm"] = [old + aside for old, aside in zip(row.get("decenter_mm", (0.0, 0.0)), landing)]
    return moved


class Sweep:
    """The results of a system for several fields, wavelengths and distances: :meth:`raylet.System.simulate`.

    Printed, or as the last line of a notebook's cell, it is a table with a line for each run.

    Attributes
    ----------
    fields : angles [ax, ay] in degrees, or places [x, y, z] in mm of a point source; None where they were not varied.
    wavelengths_um : vacuum wavelengths; None where they were not varied.
    distances_mm : distances of the sensor from the element before it; None where they were not varied.
    results : the results, an array of objects with one axis for each list that was given, in this order.
    """

    def __init__(
        self,
        fields: list[list[float]] | None,
        wavelengths_um: list[float] | None,
        distances_mm: list[float] | None,
        results: list[Result],
    ) -> None:
        self.fields, self.wavelengths_um, self.distances_mm = fields, wavelengths_um, distances_mm
        self.results = np.empty(len(results), dtype=object)
        self.results[:] = results
        self.results = self.results.reshape([len(values) for values in self._varied().values()])

    def _varied(self) -> dict[str, list[Any]]:
        """The lists that were given, by the names of their axes."""
        lists = {"field": self.fields, "wavelength": self.wavelengths_um, "distance": self.distances_mm}
        return {name: values for name, values in lists.items() if values is not None}

    @property
    def dims(self) -> tuple[str, ...]:
        """The names of the axes of :attr:`field`."""
        return (*self._varied(), "y", "x")

    @property
    def field(self) -> NDArray[np.complex128]:
        """The complex fields, with the axes :attr:`dims`."""
        all_fields = np.stack([result.field for result in self.results.flat])
        return all_fields.reshape(self.results.shape + all_fields.shape[1:])

    @property
    def intensity(self) -> NDArray[np.float64]:
        """|U|², with the axes :attr:`dims`."""
        field = self.field
        return np.square(field.real) + np.square(field.imag)

    def incoherent(self, weights: Any = None) -> NDArray[np.float64]:
        """The intensity [y, x] of fields and wavelengths that do not interfere: Σ w |U|², with one weight for each run
        in the order of :attr:`results`; one for all without them."""
        shape = self.results.shape
        given = np.ones(shape) if weights is None else real("weights", weights)
        if given.shape != shape:
            raise ValueError(f"weights have shape {given.shape}, expected {shape}, one for each run")
        return np.asarray(np.tensordot(given, self.intensity, axes=given.ndim))

    @property
    def table(self) -> list[dict[str, Any]]:
        """One row for each run, in the order of :attr:`results`: what was varied, then the columns of
        :attr:`raylet.Result.table`. `pandas.DataFrame(sweep.table)` takes it as it is."""
        rows = []
        for place, result in np.ndenumerate(self.results):
            at: dict[str, Any] = {}
            for index, (name, values) in zip(place, self._varied().items()):
                if name == "field":
                    at.update(zip(FIELDS[len(values[index])], values[index]))
                elif name == "distance":
                    at["distance_mm"] = values[index]
            rows += [{**at, **row} for row in result.table]
        return rows

    def save_table(self, path: str | os.PathLike[str], *, overwrite: bool = False) -> None:
        """Writes :attr:`table` as a CSV file with the columns of the `table.csv` of `raylet simulate`.

        The file appears whole or not at all. One that raylet did not write, or that was changed since, is refused
        unless `overwrite` is true.
        """
        rows, file = self.table, io.StringIO()
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(rows[0])
        writer.writerows([_csv_cell(cell) for cell in row.values()] for row in rows)
        write({path: file.getvalue().encode()}, overwrite=overwrite)

    def _printed(self) -> SweepTable:
        return SweepTable(f"raylet.Sweep {' x '.join(self.dims)}: {self.results.size} runs", self.table)

    def _repr_html_(self) -> str:
        return self._printed().html()

    @described
    def __repr__(self) -> str:
        return self._printed().text()


def _csv_cell(value: Any) -> Any:
    """A cell of a CSV file, as `raylet simulate` writes it."""
    return str(value).lower() if isinstance(value, bool) else value
