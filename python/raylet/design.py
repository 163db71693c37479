"""Designed systems: holograms on the paraxial train, and designs by gradients through the real system."""

from __future__ import annotations

import hashlib
import json
import os
import warnings
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from raylet import _raylet
from raylet._document import copied, element_names, put_in, taken_out, without_none
from raylet._plain import plain
from raylet._refusal import described
from raylet.progress import Progress, reporting

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from raylet.system import System

#: What stands in a layer in place of an array that is still to be found.
_TO_COME = "to be found"

#: The keys of what is free in a pixel.
_KEYS = {
    "phase": ("phase",),
    "amplitude": ("amplitude",),
    "both": ("phase", "amplitude"),
    "height": ("height_um",),
}


class Design:
    """The result of a search.

    Attributes
    ----------
    system : the system with it.
    arrays : what was found for the pixels, by its path in the scene: phases in rad, amplitudes, heights in µm.
    parameters : the parameters that were found, by their names; of a radius the curvature, "1/….radius_mm".
    scores : numbers that say how good it is, by name.
    course : the loss at the start and after each iteration; empty for a hologram.
    """

    def __init__(
        self,
        system: System,
        arrays: Mapping[str, NDArray[np.float64]],
        scores: Mapping[str, float],
        *,
        parameters: Mapping[str, float] | None = None,
        course: Sequence[float] = (),
    ) -> None:
        self.system, self.arrays, self.scores = system, dict(arrays), dict(scores)
        self.parameters = dict(parameters or {})
        self.course: NDArray[np.float64] = np.array(course, dtype=np.float64)

    def plot(self, ax: Axes | None = None) -> tuple[Figure, Axes]:
        """The loss at the start and after each iteration of a design."""
        if len(self.course) == 0:
            raise ValueError("a hologram has no course, expected a design by gradients")
        from raylet.plotting import plot_course

        return plot_course(self.course, self.system.title, ax)

    @described
    def __repr__(self) -> str:
        scores = "; ".join(f"{name}: {value:.5g}" for name, value in self.scores.items())
        lines = [f"<raylet.Design, {scores}>"]
        lines += [f"  {path}: {array.shape[1]} x {array.shape[0]}" for path, array in self.arrays.items()]
        lines += [f"  {name} = {value:.10g}" for name, value in self.parameters.items()]
        return "\n".join(lines)


def hologram(
    system: System, table: Mapping[str, Any], *, naive: bool, threads: int | None, progress: Progress
) -> Design:
    """The phase that shows a picture, by Gerchberg and Saxton's iteration on the paraxial train."""
    document = _with_table(system._document, "hologram", table)
    task, pixelled = document.get("hologram", {}), _pixelled(document)
    if "element" not in task and len(pixelled) == 1:
        task["element"] = pixelled[0]
    _make_room(document, document.get("hologram", {}).get("element"), "phase")
    scene, arrays = _compiled(system, document)
    with reporting(progress, "{}") as report:
        path, phase, scores = _raylet.hologram(scene, arrays, naive, threads, report)
    found = {path: phase}
    return Design(_with(system, found), found, dict(zip(("ncc", "ncc_sensor", "efficiency"), scores)))


def design(
    system: System,
    table: Mapping[str, Any],
    picture: Mapping[str, Any],
    *,
    keeping: tuple[str | os.PathLike[str], bool] | None,
    threads: int | None,
    progress: Progress,
) -> Design:
    """Runs the table `[design]`, with the picture of `[hologram]`."""
    document = _with_table(system._document, "hologram", picture)
    document = _with_table(document, "design", table)
    rows = document.get("design", {}).get("element")
    if not rows:
        rows = [{"name": document.get("hologram", {}).get("element")}]
    for row in rows:
        if isinstance(row, Mapping):
            start = row.get("start") == "file"
            _make_room(document, row.get("name"), row.get("free", "phase"), start=start)
    scene, arrays = _compiled(system, document)
    kept = None
    if keeping is not None:
        folder, resume = keeping
        kept = {"folder": os.fspath(folder), "rest": _digest(arrays), "resume": resume}
    with reporting(progress, "{}") as report:
        pixels, parameters, course, parts, made = _raylet.design(scene, arrays, kept, threads, report)
    losses, loss, evaluations, warning = course
    if warning is not None:
        warnings.warn(warning, stacklevel=4)
    scores = {"loss": loss, "evaluations": evaluations}
    for field, wave, kinds in parts:
        scores |= {f"{kind}, field {field}, wavelength {wave}": value for kind, value in kinds}
    system = _with(system, dict(pixels), made if parameters else None)
    return Design(system, dict(pixels), scores, parameters=dict(parameters), course=losses)


def _with_table(document: Mapping[str, Any], name: str, table: Mapping[str, Any]) -> dict[str, Any]:
    """A copy of a document with a table, whose keys replace those that it has."""
    copy: dict[str, Any] = copied(document)
    given = {key: value for key, value in table.items() if value is not None}
    copy[name] = {**(copy.get(name) or {}), **copied(given)}
    if not copy[name]:
        del copy[name]
    return copy


def _pixelled(document: Mapping[str, Any]) -> list[str]:
    """What the elements with a layer of pixels are called."""
    rows = zip(element_names(document), document["element"])
    return [name for name, row in rows if any(layer.get("kind") == "pixels" for layer in row.get("layer") or [])]


def _digest(arrays: Mapping[str, NDArray[Any]]) -> str:
    """A checksum of the arrays in memory."""
    digest = hashlib.sha256()
    for path, array in sorted(arrays.items()):
        digest.update(f"{path} {array.dtype.str} {array.shape}".encode())
        digest.update(np.ascontiguousarray(array).data)
    return digest.hexdigest()


def _make_room(document: Any, element: Any, free: Any, *, start: bool = False) -> None:
    """Makes room for what is to be found in an element's first layer of pixels, heights or a sum. What has none is left
    for the library to refuse, and so is what is to be the start."""
    for name, row in zip(element_names(document), document["element"]):
        gridded = [layer for layer in row.get("layer") or [] if layer.get("kind") in ("pixels", "height", "sum")]
        if name != element or not gridded:
            continue
        layer = gridded[0]
        if layer["kind"] == "sum":
            for term in (one for terms in layer["terms"] for one in terms if one.get("kind") == "pixels"):
                _size(term, () if start else ("phase",))
        else:
            _size(layer, () if start else _KEYS.get(str(free), ()))


def _size(layer: dict[str, Any], keys: Sequence[str]) -> None:
    """Gives a layer the size of its arrays in memory, and names for those that are still to be found."""
    held = [layer[key] for key in ("phase", "amplitude", "height_um") if isinstance(layer.get(key), np.ndarray)]
    if layer.get("size") is None and held:
        layer["size"] = list(held[0].shape[::-1])
    for key in keys:
        layer.setdefault(key, _TO_COME)


def _compiled(system: System, document: Any) -> tuple[_raylet.Scene, dict[str, NDArray[Any]]]:
    """A document as the library has it, and its arrays in memory."""
    arrays: dict[str, NDArray[Any]] = {}
    bare = plain(taken_out(document, "", arrays))
    return _raylet.Scene.build(bare, system._name), arrays


def _with(system: System, found: Mapping[str, NDArray[Any]], scene: _raylet.Scene | None = None) -> System:
    """The system with arrays at their paths, and with the parameters of a scene."""
    made = system._copy()
    if scene is not None:
        arrays: dict[str, NDArray[Any]] = {}
        taken_out(system._document, "", arrays)
        numbered = without_none(json.loads(scene.to_json()))
        made._document |= {key: numbered[key] for key in ("element", "source", "settings", "ambient")}
        put_in(made._document, arrays)
    put_in(made._document, found)
    return made
