"""Optical systems: built in code or read from a scene file."""

from __future__ import annotations

import copy
import json
import os
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, Union

import numpy as np
from numpy.typing import NDArray

from raylet import _raylet
from raylet._arrays import grid
from raylet._document import called, copied, put_in, rebased, taken_out, without_none
from raylet._refusal import RayletError
from raylet._toml import dumps
from raylet.bench import Bench
from raylet.design import Design, design, hologram
from raylet.layers import Aperture, Layer, Pair, constant, pixel_shape
from raylet.progress import Progress, telling
from raylet.result import Result
from raylet.trace import Rays, trace

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Glass = Union[str, Mapping[str, float], float]


def load(path: str | os.PathLike[str]) -> System:
    """The system of a scene file (TOML), with every array that it names.

    >>> import raylet
    >>> system = raylet.load("scenes/spider.toml")
    """
    scene = _raylet.Scene.read(os.fspath(path))
    system = System.__new__(System)
    system._document = without_none(json.loads(scene.to_json()))
    waves = system._document["wavelength_um"]
    system._document["wavelength_um"] = waves[0] if len(waves) == 1 else waves
    # Its text is Python's from now on: no line of the file is meant by what is told of it.
    system._name, system._scene, system._arrays = f"{os.fspath(path)} in Python", scene, {}
    system.field_deg = system.field_mm = None
    return system


def glasses() -> list[str]:
    """The names of all glasses of the catalogue."""
    return _raylet.glasses()


class System:
    """Light, elements along an axis in the order light meets them, and a sensor.

    Lengths are in mm unless a name says otherwise, wavelengths in µm. Each element stands `thickness_mm` behind the one
    before it; a radius is positive when its centre lies at larger z. Every `add_…` returns the system, so calls can be
    chained; keys are those of scene files, where each is explained (`raylet schema`).

    Parameters
    ----------
    wavelength_um : vacuum wavelength, or several.
    ambient : medium outside the elements: a catalogue name or a constant index.
    field_deg, field_mm : what a normalised field coordinate `Hx, Hy` of one means in :meth:`trace`, for collimated
        light and for point sources.
    """

    field_deg: float | None
    field_mm: float | None

    def __init__(
        self,
        wavelength_um: float | Sequence[float],
        *,
        title: str = "",
        ambient: Glass = "air",
        seed: int = 1,
        field_deg: float | None = None,
        field_mm: float | None = None,
    ) -> None:
        self._document: dict[str, Any] = {
            "version": 1,
            "title": title,
            "wavelength_um": _plain(wavelength_um),
            "ambient": constant(ambient),
            "seed": seed,
            "source": {"kind": "plane"},
            "element": [],
            "settings": {},
        }
        self._name = "system"
        self._scene: _raylet.Scene | None = None
        self._arrays: dict[str, NDArray[Any]] = {}
        self.field_deg, self.field_mm = field_deg, field_mm

    # Light.

    def plane_wave(self, *, angle_deg: Sequence[float] = (0.0, 0.0), beam_radius_mm: float | None = None) -> System:
        """Collimated light of unit amplitude with direction cosines sin ax, sin ay."""
        return self._set("source", {"kind": "plane", "angle_deg": angle_deg, "beam_radius_mm": beam_radius_mm})

    def point_source(self, position_mm: Sequence[float], *, beam_radius_mm: float | None = None) -> System:
        """Light of a point [x, y, z], z < 0 before the first element, of unit amplitude at that element's vertex."""
        source = {"kind": "point", "position_mm": position_mm, "beam_radius_mm": beam_radius_mm}
        return self._set("source", source)

    # Elements.

    def add(self, kind: str, **keys: Any) -> System:
        """Adds an element of any kind by the keys of a scene file."""
        element = {"kind": kind, **keys}
        if "glass" in element:
            element["glass"] = constant(element["glass"])
        self._document["element"].append(element)
        self._scene = None
        return self

    def add_surface(
        self,
        *,
        radius_mm: float | None = None,
        thickness_mm: float | None = None,
        glass: Glass | None = None,
        semi_aperture_mm: float | None = None,
        **keys: Any,
    ) -> System:
        """Adds a refracting surface; `glass` is behind it, the ambient medium where it is not given."""
        given = {"radius_mm": radius_mm, "thickness_mm": thickness_mm, "semi_aperture_mm": semi_aperture_mm}
        return self.add("surface", glass=glass, **given, **keys)

    def add_lens(self, *surfaces: Mapping[str, Any], thickness_mm: float | None = None, **keys: Any) -> System:
        """Adds surfaces that move as one, each a dictionary of what :meth:`add_surface` takes."""
        rows = [{**surface} for surface in surfaces]
        for row in rows:
            if "glass" in row:
                row["glass"] = constant(row["glass"])
        return self.add("lens", surface=rows, thickness_mm=thickness_mm, **keys)

    def add_mirror(
        self,
        *,
        radius_mm: float | None = None,
        thickness_mm: float | None = None,
        semi_aperture_mm: float | None = None,
        **keys: Any,
    ) -> System:
        """Adds a mirror; after it thicknesses are negative, after another one positive again."""
        given = {"radius_mm": radius_mm, "thickness_mm": thickness_mm, "semi_aperture_mm": semi_aperture_mm}
        return self.add("mirror", **given, **keys)

    def add_doe(
        self,
        *layers: Layer,
        aperture: Aperture,
        thickness_mm: float | None = None,
        name: str | None = None,
        **keys: Any,
    ) -> System:
        """Adds a diffractive element, the product of layers (see :mod:`raylet.layers`) within an aperture."""
        return self.add("doe", layer=list(layers), aperture=aperture, thickness_mm=thickness_mm, name=name, **keys)

    def add_paraxial_lens(
        self, focal_length_mm: float, *, aperture: Aperture, thickness_mm: float | None = None, **keys: Any
    ) -> System:
        """Adds an ideal thin lens."""
        given = {"focal_length_mm": focal_length_mm, "aperture": aperture, "thickness_mm": thickness_mm}
        return self.add("paraxial_lens", **given, **keys)

    def add_stop(self, aperture: Aperture, *, thickness_mm: float | None = None, **keys: Any) -> System:
        """Adds an opening in an opaque screen."""
        return self.add("stop", aperture=aperture, thickness_mm=thickness_mm, **keys)

    def add_coordinate_break(
        self,
        *,
        decenter_mm: Sequence[float] = (0.0, 0.0),
        tilt_deg: Sequence[float] = (0.0, 0.0, 0.0),
        thickness_mm: float = 0.0,
    ) -> System:
        """Shifts, then turns the axis for all that follows."""
        turn = {"decenter_mm": decenter_mm, "tilt_deg": tilt_deg, "thickness_mm": thickness_mm}
        return self.add("coordinate_break", **turn)

    def add_sensor(self, *, pixels: Sequence[int], pitch_um: Pair, **keys: Any) -> System:
        """Adds the sensor: the field is wanted at the centres of [nx, ny] pixels. It is the last element."""
        return self.add("sensor", pixels=pixels, pitch_um=pitch_um, **keys)

    def settings(self, **settings: Any) -> System:
        """Chooses how the system is computed; keys of the table `[settings]` of scene files."""
        return self._set("settings", {**self._document["settings"], **settings})

    def with_pixels(
        self, element: str, *, phase: Any = None, amplitude: Any = None, transmission: Any = None
    ) -> System:
        """The same system with other pixels, of the same number, in an element's first layer of pixels."""
        given = {"phase": phase, "amplitude": amplitude, "transmission": transmission}
        held = {key: grid(key, value) for key, value in given.items() if value is not None}
        if not held:
            raise TypeError("with_pixels takes a phase, an amplitude or a transmission")
        other = self._copy()
        row = other._document["element"][self._number_of(element)]
        layers = [layer for layer in row.get("layer", []) if layer.get("kind") == "pixels"]
        if not layers:
            raise RayletError(f"element '{element}' has no layer of pixels")
        old, shape = layers[0], pixel_shape(layers)
        for key, array in held.items():
            if shape not in (None, array.shape):
                raise ValueError(f"{key} has shape {array.shape}, expected {shape}, as the element's pixels have")
        for key in ("phase", "amplitude", "transmission", "key", "size", "phase_scale"):
            old.pop(key, None)
        old.update(held)
        return other

    # What it does.

    def simulate(
        self,
        *,
        method: str | None = None,
        target_error: float | None = None,
        threads: int | None = None,
        memory_limit_mb: float | None = None,
        seed: int | None = None,
        progress: Progress = None,
    ) -> Result:
        """Carries the light of every wavelength to the sensor.

        Ctrl-C ends it at once. Results have the same bits for any number of threads.

        Parameters
        ----------
        method : "auto", "beamlet", "plane" or "paper".
        target_error : relative error of the complex field that automatic choices aim at; 1e-3 unless the scene says
            otherwise.
        threads : processors to use; all of them by default.
        memory_limit_mb : most memory that arrays may take, in 10⁶ bytes.
        seed : of whatever is drawn at random.
        progress : a function of (share done, what is being done), True for a tqdm bar, False for nothing; by default a
            bar where tqdm is installed and somebody watches.
        """
        chosen = {"method": method, "target_error": target_error, "memory_limit_mb": memory_limit_mb}
        scene = self._compiled(seed, {key: value for key, value in chosen.items() if value is not None})
        with telling(progress) as tell:
            answer = _raylet.simulate(scene, self._arrays, _threads(threads), tell)
        return Result._of(answer, several=isinstance(self._document["wavelength_um"], list), title=self.title)

    def bench(self, *elements: str, numbers: Sequence[str] = (), threads: int | None = None) -> Bench:
        """The system as a function of the pixels of some elements and of some of its numbers, with its gradient.

        `numbers` are paths in the scene, such as "element[1].surface[0].radius_mm" (whose curvature then varies) or
        "element[0].thickness_mm".
        """
        if isinstance(numbers, str):
            raise TypeError(f"numbers is the string {numbers!r}, expected a list of paths")
        return Bench(self, elements, numbers, _threads(threads))

    def trace(
        self,
        Hx: Any = 0.0,
        Hy: Any = 0.0,
        Px: Any = 0.0,
        Py: Any = 0.0,
        *,
        field_deg: float | None = None,
        field_mm: float | None = None,
        channel: int = 0,
        derivatives: str | Sequence[str] = (),
        threads: int | None = None,
    ) -> Rays:
        """Single rays through the whole system, by geometrical optics.

        A smooth element turns rays by the gradient of its phase; pixels let them go straight on.

        Parameters
        ----------
        Hx, Hy : normalised field: angles added to the source's in units of `field_deg` (for a point source shifts of
            it in units of `field_mm`), which default to the system's.
        Px, Py : normalised pupil: where the ray meets the first element, in units of the half widths of its opening.
        channel : index of the wavelength.
        derivatives : paths of numbers, such as "element[0].radius_mm", by which landings are differentiated; for a
            radius by its curvature.
        threads : how many to use; all processors' by default. They change no bit.
        """
        scale = (field_deg or self.field_deg, field_mm or self.field_mm)
        source = json.loads(self._compiled().to_json())["source"]
        names = [derivatives] if isinstance(derivatives, str) else list(derivatives)
        return trace(self, source, (Hx, Hy, Px, Py), scale, channel, names, _threads(threads))

    # What is sought.

    def hologram(
        self,
        target: Any = None,
        *,
        element: str | None = None,
        size_mm: Sequence[float] | None = None,
        iterations: int | None = None,
        efficiency_goal: float | None = None,
        naive: bool = False,
        threads: int | None = None,
        progress: Progress = None,
        **keys: Any,
    ) -> Design:
        """The phase with which the sensor shows a picture, by Gerchberg and Saxton's iteration on the paraxial train.

        What is not given is that of the scene's table `[hologram]`, whose other keys can be given as well.

        Parameters
        ----------
        target : the picture: a PNG file, or values from 0 as an array [y, x], y upwards.
        element : name of the element, whose first layer of pixels is sought; the only one with pixels by default.
        size_mm : width and height of the picture on the sensor.
        efficiency_goal : share of the light that the picture is to have; what is found has somewhat less. Without it
            iterations buy likeness with light where the element is too small to resolve the picture (λ × distance /
            width).
        naive : with all lenses behind the element as one thin lens at the first vertex.

        The scores are the normalised correlation of the intensity with the softened picture (`ncc`), the same over the
        whole sensor (`ncc_sensor`), and the share of the light in the picture (`efficiency`).
        """
        if not isinstance(naive, bool):
            raise TypeError(f"naive is {type(naive).__name__}, expected True or False")
        table = {"target": target, "element": element, "size_mm": size_mm, "iterations": iterations}
        given = {**table, "efficiency_goal": efficiency_goal, **keys}
        return hologram(self, given, naive=naive, threads=_threads(threads), progress=progress)

    def design(
        self,
        *,
        element: Sequence[Mapping[str, Any]] | None = None,
        loss: Sequence[Mapping[str, Any]] | None = None,
        variable: Sequence[Mapping[str, Any]] | None = None,
        hologram: Mapping[str, Any] | None = None,
        field: Sequence[Mapping[str, Any]] | None = None,
        iterations: int | None = None,
        checkpoints: str | os.PathLike[str] | None = None,
        resume: bool = False,
        threads: int | None = None,
        progress: Progress = None,
        **keys: Any,
    ) -> Design:
        """A design by gradients through the real system, as `raylet design` does it.

        What is not given is that of the scene's table `[design]`, whose other keys can be given as well; pictures may
        be arrays [y, x], y upwards. Ctrl-C ends it; with `checkpoints` it can be gone on with.

        Parameters
        ----------
        element : the elements whose pixels are sought: dictionaries with `name`, and what is `free` ("phase",
            "amplitude", "both", "two_phase", "height"), `start` ("flat", "random", "file" for what the system has;
            "spread" and "paraxial" for the element of `hologram`), `levels`, `highest_um`, `block`, `blur`,
            `smoothness`.
        loss : what is wanted: dictionaries with `kind` ("likeness", "mse", "efficiency", "encircled_energy", "spot",
            "overlap") and the keys of that kind.
        variable : numbers that are sought: dictionaries with `path`, such as "element[1].surface[0].radius_mm", and
            `scale` (the size of a step), `lowest`, `highest`.
        hologram : the table `[hologram]` with `target`, `element` and `size_mm`: its element and its picture are
            taken where `element` and `loss` are not given.
        field : directions or places of the source: dictionaries with `angle_deg` or `position_mm`.
        checkpoints : a folder where the state of the search is kept, every `checkpoint` iterations (10 by default).
        resume : go on from the last of these checkpoints, as if never stopped; the result has the same bits.
        """
        given = {"element": element, "loss": loss, "variable": variable, "field": field, "iterations": iterations}
        if resume and checkpoints is None:
            raise TypeError("resume goes on from checkpoints, expected their folder as checkpoints")
        keeping = None if checkpoints is None else (checkpoints, bool(resume))
        tables = ({**given, **keys}, hologram or {})
        return design(self, *tables, keeping=keeping, threads=_threads(threads), progress=progress)

    # What it looks like.

    def draw(self, ax: Axes | None = None, *, channel: int = 0) -> tuple[Figure, Axes]:
        """The section through the system with a few rays."""
        from raylet.plotting import draw_layout

        layout = json.loads(_raylet.layout(self._compiled(), self._arrays, channel))
        return draw_layout(layout, self.title, ax)

    def plot(self, element: str, ax: Axes | None = None, *, channel: int = 0) -> tuple[Figure, Axes]:
        """The phase of a diffractive element, where it is open."""
        from raylet.plotting import plot_phase

        values, bounds = self.transmission(element, channel=channel)
        return plot_phase(values, bounds, element, ax)

    def transmission(
        self, element: str, *, channel: int = 0
    ) -> tuple[NDArray[np.complex128], tuple[float, float, float, float]]:
        """The complex transmission [y, x] of a diffractive element at the centres of equal cells, and the box
        (x_min, x_max, y_min, y_max) in mm that they fill; zero where it is not open."""
        if not isinstance(element, str):
            raise TypeError(f"element is {type(element).__name__}, expected the name of one")
        values, bounds = _raylet.element(self._compiled(), self._arrays, element, channel)
        low_x, high_x, low_y, high_y = bounds
        return values, (low_x, high_x, low_y, high_y)

    @property
    def title(self) -> str:
        """Its title."""
        return str(self._document.get("title", ""))

    @property
    def wavelength_um(self) -> list[float]:
        """Its wavelengths in vacuum."""
        given = self._document["wavelength_um"]
        return list(given) if isinstance(given, list) else [given]

    @property
    def parts(self) -> list[dict[str, Any]]:
        """Its screens and surfaces in the order light meets them: name, kind, position, radii, tilt, extent, medium."""
        parts: list[dict[str, Any]] = json.loads(_raylet.parts(self._compiled(), self._arrays, 0))
        return parts

    def to_toml(self) -> str:
        """The scene file of the system, with every default; arrays in memory are named but not in it."""
        return self._compiled().to_toml()

    def save(self, path: str | os.PathLike[str]) -> None:
        """Writes a scene file that :func:`load` and the command line read, and arrays in memory beside it (.npy)."""
        folder, name = os.path.split(os.fspath(path))
        os.makedirs(folder or ".", exist_ok=True)
        document = copied(self._document)
        rebased(document, os.path.dirname(self._name), folder)
        arrays: dict[str, NDArray[Any]] = {}
        taken_out(document, "", arrays)
        for place, array in arrays.items():
            file = f"{os.path.splitext(name)[0]}.{place.replace('[', '').replace(']', '')}.npy"
            np.save(os.path.join(folder, file), array)
            put_in(document, {place: file})
        with open(path, "w", encoding="utf-8") as scene:
            scene.write(dumps(document))

    def __repr__(self) -> str:
        waves = ", ".join(f"{wave:g}" for wave in self.wavelength_um)
        head = f"<raylet.System{f' {self.title!r}' if self.title else ''}, λ = {waves} µm"
        try:
            parts = self.parts
        except RayletError as error:
            return f"{head}, {len(self._document['element'])} elements; not complete: {error.args[0].splitlines()[0]}>"
        return f"{head}>\n{_table(parts)}"

    # How it is handed to the library.

    def _set(self, key: str, value: Any) -> System:
        self._document[key] = value
        self._scene = None
        return self

    def _copy(self) -> System:
        """The same system with a document of its own, whose arrays are shared."""
        other = copy.copy(self)
        other._document, other._scene = copied(self._document), None
        return other

    def _number_of(self, element: str) -> int:
        names = called(self._document)
        if element not in names:
            known = ", ".join(repr(name) for name in names) or "none"
            raise RayletError(f"no element is called {element!r}; there are: {known}")
        return names.index(element)

    def _compiled(self, seed: int | None = None, settings: Mapping[str, Any] | None = None) -> _raylet.Scene:
        """The library's scene, with other settings where they are given."""
        if self._scene is None:
            self._arrays = {}
            document = taken_out(self._document, "", self._arrays)
            self._scene = _raylet.Scene.parse(dumps(document), self._name)
        scene = self._scene
        if seed is not None:
            document = {**taken_out(self._document, "", {}), "seed": seed}
            scene = _raylet.Scene.parse(dumps(document), self._name)
        return scene.with_settings(dumps(settings)) if settings else scene


def _plain(wavelength_um: Any) -> Any:
    if isinstance(wavelength_um, np.ndarray) and wavelength_um.ndim == 0:
        return float(wavelength_um)
    if isinstance(wavelength_um, (Sequence, np.ndarray)) and not isinstance(wavelength_um, str):
        return [float(wave) for wave in wavelength_um]
    return wavelength_um


def _threads(threads: Any) -> int | None:
    if threads is None or (isinstance(threads, (int, np.integer)) and not isinstance(threads, bool)):
        if threads is not None and not 1 <= threads <= 1024:
            raise ValueError(f"threads is {threads}, expected from 1 to 1024")
        return None if threads is None else int(threads)
    raise TypeError(f"threads is {type(threads).__name__}, expected a whole number")


def _table(parts: Sequence[Mapping[str, Any]]) -> str:
    """Parts as lines of a table."""

    def row(part: Mapping[str, Any]) -> list[str]:
        radius = [f"{radius:.6g}" if radius is not None else "∞" for radius in part["radii_mm"]]
        radii = radius[0] if radius[0] == radius[1] else "/".join(radius)
        bounds = part["bounds_mm"]
        extent = f"{bounds[1] - bounds[0]:.5g} x {bounds[3] - bounds[2]:.5g}" if bounds else ""
        return [part["name"], part["kind"], f"{part['position_mm'][2]:.6g}", radii, extent, part["medium"]]

    rows = [["name", "kind", "z/mm", "radius/mm", "extent/mm", "behind"], *map(row, parts)]
    widths = [max(len(line[i]) for line in rows) for i in range(len(rows[0]))]
    return "\n".join("  " + "  ".join(text.ljust(width) for text, width in zip(line, widths)).rstrip() for line in rows)
