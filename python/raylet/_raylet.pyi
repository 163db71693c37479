# The extension module. Its words are those of the library; the package around it is what users meet.
from collections.abc import Callable, Mapping, Sequence
from typing import Any, final

import numpy as np
from numpy.typing import NDArray

__all__ = [
    "Bench",
    "Passage",
    "RayletError",
    "Scene",
    "__version__",
    "beams",
    "design",
    "element",
    "gather",
    "gather_adjoint",
    "glasses",
    "hologram",
    "layout",
    "parts",
    "scatter",
    "scatter_adjoint",
    "simulate",
    "trace",
]
__version__: str

_Arrays = Mapping[str, NDArray[Any]]
_Complex = NDArray[np.complex128]
_Real = NDArray[np.float64]

class RayletError(ValueError):
    path: str
    found: str
    expected: str
    hint: str

@final
class Scene:
    @staticmethod
    def parse(text: str, name: str) -> Scene: ...
    @staticmethod
    def read(path: str) -> Scene: ...
    def with_settings(self, settings: str) -> Scene: ...
    def to_toml(self) -> str: ...
    def to_json(self) -> str: ...

@final
class Passage:
    def adjoint(self, fields_bar: list[Any], threads: int | None) -> tuple[list[Any], list[float]]: ...

@final
class Bench:
    def __new__(
        cls, scene: Scene, arrays: _Arrays, elements: Sequence[str], numbers: Sequence[str], threads: int | None
    ) -> Bench: ...
    def numbers(self) -> list[float]: ...
    def forward(
        self, scene: Scene, arrays: _Arrays, pixels: list[Any], numbers: Sequence[float], threads: int | None
    ) -> tuple[list[_Complex], Passage]: ...

def simulate(
    scene: Scene,
    arrays: _Arrays,
    threads: int | None,
    progress: Callable[[float, float, str], Any] | None,
) -> tuple[list[_Complex], _Real, _Real, list[_Real | None], str]: ...
def hologram(
    scene: Scene,
    arrays: _Arrays,
    naive: bool,
    threads: int | None,
    progress: Callable[[float, float, str], Any] | None,
) -> tuple[str, _Real, list[float]]: ...
def design(
    scene: Scene,
    arrays: _Arrays,
    threads: int | None,
    progress: Callable[[float, float, str], Any] | None,
) -> tuple[
    list[tuple[str, _Real]],
    list[tuple[str, float]],
    tuple[list[float], float, int],
    list[tuple[int, int, list[tuple[str, float]]]],
    Scene,
]: ...
def trace(
    scene: Scene, arrays: _Arrays, channel: int, pupil: _Real, light: _Real, numbers: Sequence[str]
) -> tuple[_Real, _Real, _Real, NDArray[np.uint8], _Real]: ...
def layout(scene: Scene, arrays: _Arrays, channel: int) -> str: ...
def parts(scene: Scene, arrays: _Arrays, channel: int) -> str: ...
def element(scene: Scene, arrays: _Arrays, name: str, channel: int) -> tuple[_Complex, list[float]]: ...
def glasses() -> list[str]: ...
def scatter(
    scene: Scene, arrays: _Arrays, place: tuple[str, int], bundle: Mapping[str, Any], choices: Mapping[str, Any]
) -> dict[str, Any]: ...
def scatter_adjoint(
    scene: Scene,
    arrays: _Arrays,
    place: tuple[str, int],
    rays: tuple[Mapping[str, Any], Mapping[str, Any]],
    drawn: tuple[Mapping[str, Any], _Complex],
) -> tuple[_Complex | None, _Complex]: ...
def beams(
    place: tuple[Scene, _Arrays, int], bundle: Mapping[str, Any], ways: Mapping[str, Any]
) -> tuple[_Complex, _Complex]: ...
def gather(place: tuple[Scene, _Arrays, int], bundle: Mapping[str, Any], sum: Mapping[str, Any]) -> _Complex: ...
def gather_adjoint(
    place: tuple[Scene, _Arrays, int], bundle: Mapping[str, Any], sum: Mapping[str, Any], field_bar: _Complex
) -> dict[str, Any]: ...
