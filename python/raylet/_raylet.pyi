"""
The extension module. Its words are those of the library; the package around it is what users meet.
"""

from os import PathLike
from typing import Any, Final, SupportsFloat, SupportsIndex, final

from _typeshed import Incomplete, SupportsGetItem, SupportsLenAndGetItem
from numpy import complex128, float64, int64, uint8
from numpy.typing import NDArray

__all__ = [
    "__version__",
    "LensFolder",
    "LinearisedSystem",
    "Passage",
    "Scene",
    "beams",
    "catalog",
    "check",
    "chief_landing",
    "design",
    "element",
    "export_array",
    "export_file",
    "export_lens",
    "export_lens_file",
    "export_scene",
    "gather",
    "gather_adjoint",
    "glasses",
    "hologram",
    "layout",
    "parts",
    "read_beam",
    "read_map",
    "read_masks",
    "scatter",
    "scatter_adjoint",
    "schema",
    "sensor_panels",
    "simulate",
    "trace",
    "trace_adjoint",
    "unit_factor",
    "write_beam",
    "write_files",
]

__version__: Final[str]

@final
class LensFolder:
    """
    The lens files of a folder.
    """
    def __new__(cls, /, path: str | PathLike[str], index: str | PathLike[str] | None) -> LensFolder:
        """
        Lists a folder and reads its lens files, those that an index has not.
        """
    def counts(self, /) -> tuple[int, int]:
        """
        How many lens files it has, and how many of them were read now.
        """
    def faults(self, /) -> list[tuple[str, str]]:
        """
        The files that could not be read, each with why.
        """
    def search(
        self,
        /,
        ranges: tuple[
            tuple[SupportsFloat | SupportsIndex, SupportsFloat | SupportsIndex] | None,
            tuple[SupportsFloat | SupportsIndex, SupportsFloat | SupportsIndex] | None,
            tuple[SupportsFloat | SupportsIndex, SupportsFloat | SupportsIndex] | None,
        ],
        maker: str | None,
        words: str | None,
    ) -> list[tuple[str, str]]:
        """
        The lenses that fit ranges of focal lengths, diameters and f-numbers, and words.
        """

@final
class LinearisedSystem:
    """
    Frozen plans of a scene whose pixels and parameters vary.
    """
    def __new__(
        cls,
        /,
        scene: Scene,
        arrays: dict[str, NDArray[Any]],
        elements: SupportsGetItem[int, str],
        parameters: SupportsGetItem[int, str],
        threads: SupportsIndex | None,
    ) -> LinearisedSystem:
        """
        Plans a scene about the values of its parameters; `elements` are the names of those whose pixels vary,
        `parameters` the paths of the parameters that do.
        """
    def forward(
        self,
        /,
        scene: Scene,
        arrays: dict[str, NDArray[Any]],
        pixels: list[NDArray[Any]],
        parameters: SupportsGetItem[int, SupportsFloat | SupportsIndex],
        threads: SupportsIndex | None,
    ) -> tuple[list[NDArray[complex128]], Passage]:
        """
        Light through the system with these pixels (phases float64 or transmissions complex128, [y, x], for each
        element) and parameters: the fields [y, x] of all wavelengths, and the passage.
        """
    def parameters(self, /) -> list[float]:
        """
        The parameters as the scene has them: of a radius the curvature, 1/radius.
        """

@final
class Passage:
    """
    The record of a forward pass through a linearised system, for its gradient.
    """
    def adjoint(
        self, /, fields_bar: list[NDArray[Any]], threads: SupportsIndex | None
    ) -> tuple[list[Any], list[float]]:
        """
        The gradient of a real loss, from the cotangents ∂L/∂Re U + i ∂L/∂Im U of the fields [y, x] of all
        wavelengths: for each element by its phases (float64) or transmissions (complex128, ∂L/∂Re t + i ∂L/∂Im t),
        and by the parameters.
        """

@final
class Scene:
    """
    A scene that was read; it never changes.
    """
    @staticmethod
    def build(document: dict[str, Any], name: str | PathLike[str]) -> Scene:
        """
        The scene of a document of plain values; messages call its file `name`, whose folder is that of its arrays.
        """
    @staticmethod
    def catalog_lens(name: str, numbers: tuple[SupportsIndex, SupportsIndex | None]) -> tuple[Scene, str, list[str]]:
        """
        The scene of a lens that raylet carries, by its part number, with the report and what may make it another lens.
        """
    @staticmethod
    def import_lens(
        path: str | PathLike[str],
        numbers: tuple[SupportsIndex, SupportsIndex | None, SupportsIndex | None],
        skip_unknown: bool,
        glasses: dict[str, str],
        glass_files: SupportsGetItem[int, str | PathLike[str]],
    ) -> tuple[Scene, str, list[str], list[tuple[str, NDArray[float64]]]]:
        """
        The scene of a lens file of another program, the report of what was changed and left out, what may make the
        scene another lens, and arrays that it names, by the paths of their fields. The numbers are those of the field,
        the wavelength and the configuration, from 1.
        """
    @staticmethod
    def read(path: str | PathLike[str]) -> Scene:
        """
        The scene of a file, with every array that it names; those that a design may still have to make can be
        missing until they are needed.
        """
    def to_json(self, /) -> str:
        """
        The scene as JSON, with every default.
        """
    def to_toml(self, /) -> str:
        """
        The scene as TOML, with every default.
        """
    def with_settings(self, /, settings: dict[str, Any]) -> Scene:
        """
        The same scene with other settings, given as plain values by the keys of the table `[settings]`.
        """

def beams(place: Incomplete, bundle: Incomplete, ways: Incomplete) -> tuple[NDArray[complex128], NDArray[complex128]]:
    """
    The amplitudes (rays,) and curvatures (rays, 3) in 1/mm of the beamlets of rays on the sensor.
    """

def catalog() -> list[tuple[str, str]]:
    """
    The lenses that raylet carries: part numbers, and facts as JSON.
    """

def check(scene: Scene, arrays: dict[str, NDArray[Any]], channel: SupportsIndex) -> list[tuple[str, bool, str]]:
    """
    What there is to say about a system before it is run: of each finding the hop, whether it is a warning, the words.
    """

def chief_landing(scene: Scene, arrays: dict[str, NDArray[Any]]) -> tuple[float, float] | None:
    """
    Where the chief ray of the first wavelength meets the sensor, in mm on the sensor's axes; None where it does not.
    """

def design(
    scene: Scene,
    arrays: dict[str, NDArray[Any]],
    keeping: Incomplete | None,
    threads: SupportsIndex | None,
    progress: Any | None,
) -> tuple[
    list[tuple[str, NDArray[float64]]],
    list[tuple[str, float]],
    tuple[list[float], float, int, str | None],
    list[tuple[int, int, list[tuple[str, float]]]],
    Scene,
]:
    """
    Runs the `[design]` of a scene.

    Returns (arrays by their paths in the scene, parameters by name, (loss after each iteration, loss of what was found,
    evaluations, what was wrong with the newest checkpoint), (field, wavelength, losses by kind) of each run, the scene
    with its parameters).
    """

def element(
    scene: Scene, arrays: dict[str, NDArray[Any]], name: str, channel: SupportsIndex
) -> tuple[NDArray[complex128], list[float]]:
    """
    The transmission of a diffractive element over its aperture: complex [y, x] at the centres of equal cells, and
    the box [x_min, x_max, y_min, y_max] in mm.
    """

def export_array(array: Any, target: str | PathLike[str], choices: str) -> tuple[str, list[tuple[str, float]]]:
    """
    Exports the cells of an array of float64 or complex128.
    """

def export_file(
    source: str | PathLike[str], target: str | PathLike[str], choices: str
) -> tuple[str, list[tuple[str, float]]]:
    """
    Exports the element of a file; `choices` is JSON.
    """

def export_lens(
    scene: Scene, target: str | PathLike[str], skip_unknown: bool, overwrite: bool
) -> tuple[str, list[tuple[str, float]], list[str]]:
    """
    Writes a scene as a lens file.
    """

def export_lens_file(
    source: str | PathLike[str], target: str | PathLike[str], skip_unknown: bool, overwrite: bool
) -> tuple[str, list[tuple[str, float]], list[str]]:
    """
    Writes a scene file or another lens file as a lens file.
    """

def export_scene(
    scene: Scene, arrays: dict[str, NDArray[Any]], target: str | PathLike[str], choices: str
) -> tuple[str, list[tuple[str, float]]]:
    """
    Exports an element of a scene, some of whose arrays are in memory.
    """

def gather(place: Incomplete, bundle: Incomplete, sum: Incomplete) -> NDArray[complex128]:
    """
    The field that rays bring to the pixel centres of the sensor, [y, x].
    """

def gather_adjoint(
    place: Incomplete, bundle: Incomplete, sum: Incomplete, field_bar: NDArray[complex128]
) -> dict[str, Any]:
    """
    The conjugate transpose of [`gather`], as a dictionary of arrays: cotangents of weight, path (1/mm), place and
    optical cosines on the sensor's axes; of beamlets their amplitudes and curvatures too.
    """

def glasses() -> list[str]:
    """
    The names of all glasses.
    """

def hologram(
    scene: Scene, arrays: dict[str, NDArray[Any]], naive: bool, threads: SupportsIndex | None, progress: Any | None
) -> tuple[str, NDArray[float64], list[float]]:
    """
    The phase in rad [y, x] with which the sensor shows a picture, on the paraxial train: its path in the scene, what
    goes there, and (NCC with the softened picture, NCC over the sensor, share of the light in it).
    """

def layout(
    scene: Scene,
    arrays: dict[str, NDArray[Any]],
    channel: SupportsIndex,
    fields: SupportsGetItem[int, SupportsGetItem[int, SupportsFloat | SupportsIndex]],
) -> str:
    """
    The section through a system as JSON, with the light of some fields, or of those that the scene names: rays,
    surfaces, glass and labels as points (z, transverse) in mm.
    """

def parts(scene: Scene, arrays: dict[str, NDArray[Any]], channel: SupportsIndex) -> str:
    """
    The parts of a system in the order light meets them, as JSON.
    """

def read_beam(
    path: str | PathLike[str], component: str, sphere: bool
) -> tuple[NDArray[complex128], NDArray[float64], NDArray[float64], NDArray[float64], str]:
    """
    Reads a field.
    """

def read_map(
    path: str | PathLike[str], key: str | None, fill: SupportsFloat | SupportsIndex | None, nearest: bool
) -> tuple[NDArray[float64] | None, NDArray[complex128] | None, list[float] | None, str | None, str, list[str]]:
    """
    Reads a map; missing samples become `fill`, or the nearest other one.
    """

def read_masks(path: str | PathLike[str], choices: str) -> tuple[NDArray[int64], int]:
    """
    The levels [y, x] of a mask file, and their number.
    """

def scatter(place: Incomplete, bundle: Incomplete, choices: Incomplete) -> dict[str, Any]:
    """
    The rays that leave an element, as a dictionary of arrays.
    """

def scatter_adjoint(
    place: Incomplete, bundle: Incomplete, choices: Incomplete, drawn: Incomplete, weight_bar: NDArray[complex128]
) -> tuple[NDArray[complex128] | None, NDArray[complex128]]:
    """
    The conjugate transpose of [`scatter`] by weights: cotangents of the element's pixels (complex [y, x], or None
    where it is not one grid of box or point pixels, alone or times analytic phases) and of the arriving weights.
    """

def schema() -> str:
    """
    The JSON Schema of scenes, in which every key is explained.
    """

def sensor_panels(
    x_mm: SupportsGetItem[int, SupportsFloat | SupportsIndex],
    y_mm: SupportsGetItem[int, SupportsFloat | SupportsIndex],
    names: SupportsGetItem[int, str],
) -> str:
    """
    The panels of a sensor's picture as JSON: what `raylet simulate` shows of runs with these names on pixels with these
    centres in x and y.
    """

def simulate(
    scenes: SupportsGetItem[int, Scene],
    arrays: SupportsGetItem[int, dict[str, NDArray[Any]]],
    threads: SupportsIndex | None,
    progress: Any | None,
) -> list[tuple[list[NDArray[complex128]], NDArray[float64], NDArray[float64], list[NDArray[float64] | None], str]]:
    """
    Carries the light of every wavelength of several scenes to their sensors, side by side; the settings are those
    of the first scene.

    Returns for each scene (fields, x, y, standard errors, report as JSON): for each wavelength the complex field
    [y, x], whose memory is the library's own; the pixel centres in mm; float64 [y, x] or None.
    """

def trace(
    scene: Scene,
    arrays: dict[str, NDArray[Any]],
    channel: SupportsIndex,
    starts: Incomplete,
    recorded: SupportsGetItem[int, SupportsIndex],
    tracks: NDArray[float64],
    parameters: SupportsGetItem[int, str],
    threads: SupportsIndex | None,
) -> tuple[NDArray[uint8], NDArray[float64]]:
    """
    Rays by their `starts`, a dictionary: either places "x" and "y" (rays) on the first screen, in units of the half
    widths of its aperture, and "light" (rays, 3), unit directions of a collimated source or places in mm of a point
    source; or points "start_mm" (rays, 3) and their unit "cosines" (rays, 3), both global, from where paths count. One
    entry of "light", "start_mm" or "cosines" serves all.

    Fills `tracks` (7, parts, rays) with the points in mm, the directions behind and the optical paths in mm at the
    `recorded` parts. Returns fates (rays; 0 arrived, else the number of the loss) and derivatives (parameters, 5, rays)
    of x, y, L, M, path on the sensor. What a lost ray did not reach is NaN.
    """

def trace_adjoint(
    scene: Scene,
    arrays: dict[str, NDArray[Any]],
    channel: SupportsIndex,
    starts: Incomplete,
    by_landings: SupportsLenAndGetItem[NDArray[float64] | None],
    parameters: SupportsGetItem[int, str],
    threads: SupportsIndex | None,
) -> list[float]:
    """
    The gradient of a number by `parameters`, from its derivatives `by_landings` by x, y, L, M, path of rays on the
    sensor: five arrays (rays), or None for zero. The rays have these `starts`, as `trace` takes them. Derivatives by
    lost rays do not count.
    """

def unit_factor(unit: str, key: str) -> float | None:
    """
    The factor from a unit to that of a key of a scene; None where they do not fit.
    """

def write_beam(
    field: NDArray[complex128],
    x_mm: NDArray[float64],
    y_mm: NDArray[float64],
    wavelength_um: NDArray[float64],
    path: str | PathLike[str],
    wavelength: SupportsIndex | None,
    overwrite: bool,
) -> str:
    """
    Writes a field [wavelength, y, x], and gives the report.
    """

def write_files(files: SupportsGetItem[int, tuple[str | PathLike[str], bytes | bytearray]], overwrite: bool) -> None:
    """
    Writes files; all are checked before the first is written. Those that raylet did not write are replaced with
    `overwrite` only.
    """
