"""Systems that are sought: holograms on the paraxial train, and designs by gradients through the real system."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from raylet import _raylet
from raylet._document import copied, put_in, taken_out, without_none
from raylet._toml import dumps
from raylet.progress import Progress, telling

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from raylet.system import System

#: What stands in a layer in place of an array that is still to be found.
_TO_COME = "to be found"

#: The keys of what is free in a pixel.
_KEYS = {"phase": ("phase",), "amplitude": ("amplitude",), "both": ("phase", "amplitude")}


class Design:
    """What was sought and found.

    Attributes
    ----------
    system : the system with it.
    arrays : what was found for the pixels, by its path in the scene: phases in rad, amplitudes, heights in µm.
    numbers : the numbers that were found, by their names; of a radius the curvature, "1/….radius_mm".
    scores : what tells how good it is, by name.
    course : the loss after each iteration; empty for a hologram.
    """

    def __init__(
        self,
        system: System,
        arrays: Mapping[str, NDArray[np.float64]],
        scores: Mapping[str, float],
        *,
        numbers: Mapping[str, float] | None = None,
        course: Sequence[float] = (),
    ) -> None:
        self.system, self.arrays, self.scores = system, dict(arrays), dict(scores)
        self.numbers = dict(numbers or {})
        self.course: NDArray[np.float64] = np.array(course, dtype=np.float64)

    def plot(self, ax: Axes | None = None) -> tuple[Figure, Axes]:
        """The loss after each iteration."""
        from raylet.plotting import plot_course

        return plot_course(self.course, self.system.title, ax)

    def __repr__(self) -> str:
        scores = ", ".join(f"{name} {value:.5g}" for name, value in self.scores.items())
        lines = [f"<raylet.Design, {scores}>"]
        lines += [f"  {path}: {array.shape[1]} x {array.shape[0]}" for path, array in self.arrays.items()]
        lines += [f"  {name} = {value:.10g}" for name, value in self.numbers.items()]
        return "\n".join(lines)


def hologram(
    system: System, table: Mapping[str, Any], *, naive: bool, threads: int | None, progress: Progress
) -> Design:
    """The phase that shows a picture, by Gerchberg and Saxton's iteration on the paraxial train."""
    document = _asking(system, "hologram", table)
    paths = _make_room(document, document.get("hologram", {}).get("element"), ["phase"])
    scene, arrays = _compiled(system, document)
    with telling(progress, "{}") as tell:
        phase, scores = _raylet.hologram(scene, arrays, naive, threads, tell)
    found = dict.fromkeys(paths, phase)
    return Design(_with(system, found), found, dict(zip(("ncc", "ncc_sensor", "efficiency"), scores)))


def design(system: System, table: Mapping[str, Any], *, threads: int | None, progress: Progress) -> Design:
    """What the table `[design]` asks for."""
    document = _asking(system, "design", table)
    rows = document.get("design", {}).get("element")
    if not rows:
        rows = [{"name": document.get("hologram", {}).get("element")}]
    for row in rows:
        if isinstance(row, Mapping):
            _make_room(document, row.get("name"), _KEYS.get(str(row.get("free", "phase")), ()))
    scene, arrays = _compiled(system, document)
    with telling(progress, "{}") as tell:
        pixels, numbers, course, parts, made = _raylet.design(scene, arrays, threads, tell)
    losses, loss, evaluations = course
    scores = {"loss": loss, "evaluations": evaluations}
    for field, wave, kinds in parts:
        scores |= {f"{kind}, field {field}, wavelength {wave}": value for kind, value in kinds}
    system = _with(system, dict(pixels), made if numbers else None)
    return Design(system, dict(pixels), scores, numbers=dict(numbers), course=losses)


def _asking(system: System, name: str, table: Mapping[str, Any]) -> dict[str, Any]:
    """The system's document with a table, whose keys replace those that it has."""
    document: dict[str, Any] = copied(system._document)
    given = {key: value for key, value in table.items() if value is not None}
    document[name] = {**(document.get(name) or {}), **copied(given)}
    if not document[name]:
        del document[name]
    return document


def _make_room(document: Any, element: Any, keys: Sequence[str]) -> list[str]:
    """Makes room for what is to be found in the first layer of pixels of an element, and tells its paths in the scene.
    What is no such layer is left for the library to refuse."""
    for number, row in enumerate(document["element"]):
        for place, layer in enumerate(row.get("layer") or []):
            if row.get("name") != element or layer.get("kind") != "pixels":
                continue
            held = [layer[key] for key in ("phase", "amplitude") if isinstance(layer.get(key), np.ndarray)]
            if layer.get("size") is None and held:
                layer["size"] = list(held[0].shape[::-1])
            for key in keys:
                layer.setdefault(key, _TO_COME)
            return [f"element[{number}].layer[{place}].{key}" for key in keys]
    return []


def _compiled(system: System, document: Any) -> tuple[_raylet.Scene, dict[str, NDArray[Any]]]:
    """A document as the library has it, and its arrays in memory."""
    arrays: dict[str, NDArray[Any]] = {}
    text = dumps(taken_out(document, "", arrays))
    return _raylet.Scene.parse(text, system._name), arrays


def _with(system: System, found: Mapping[str, NDArray[Any]], scene: _raylet.Scene | None = None) -> System:
    """The system with arrays at their paths, and with the numbers of a scene."""
    made = system._copy()
    if scene is not None:
        arrays: dict[str, NDArray[Any]] = {}
        taken_out(system._document, "", arrays)
        numbered = without_none(json.loads(scene.to_json()))
        made._document |= {key: numbered[key] for key in ("element", "source", "settings", "ambient")}
        put_in(made._document, arrays)
    put_in(made._document, found)
    return made
