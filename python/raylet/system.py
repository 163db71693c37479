"""Optical systems: built in code or read from a scene file."""

from __future__ import annotations

import json
import os
import warnings
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, Literal, Union, overload

import numpy as np
from numpy.typing import NDArray

from raylet import _raylet
from raylet._arrays import number, real, thread_count
from raylet._calls import parameter_paths, public_calls
from raylet._document import put_in, without_none
from raylet._refusal import MOST_WAVES, RayletError, cut, described, shown, type_name
from raylet.design import Design, design, hologram
from raylet.linearised_system import LinearisedSystem
from raylet.prescription import Prescription
from raylet.progress import Progress
from raylet.result import Result
from raylet.sweep import RunSettings, Sweep, run_all, sweep
from raylet.trace import Part, Rays, trace, trace_from

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from typing_extensions import Unpack

#: Fields of light, and wavelengths or distances.
Fields = Union[Sequence[Sequence[float]], NDArray[np.float64]]
Numbers = Union[Sequence[float], NDArray[np.float64]]


def load(
    path: str | os.PathLike[str],
    *,
    field: int = 1,
    wavelength: int | None = None,
    configuration: int | None = None,
    skip_unknown: bool = False,
    glasses: Mapping[str, str] | None = None,
    glass_files: Sequence[str | os.PathLike[str]] = (),
) -> System:
    """The system of a scene file (TOML) with every array that it names, or of a lens file: of OpticStudio (.zmx, .zar),
    of CODE V (.seq), or a table of surfaces (.csv).

    >>> import raylet
    >>> system = raylet.load("scenes/spider.toml")

    For a lens file `field`, `wavelength` and `configuration` are numbers from 1, the primary wavelength and the
    configuration of the file by default; surfaces of unknown types are planes, and unknown commands left out, if
    `skip_unknown`; `glasses` has names of the catalogue in place of those of the file; `glass_files` are catalogues
    (.agf) in which glasses are sought first. The attribute `import_report` of the system says what was changed and left
    out, and a warning what may make it another lens.
    """
    report = ""
    arrays: list[tuple[str, NDArray[np.float64]]] = []
    if os.fspath(path).lower().endswith((".zmx", ".zar", ".seq", ".csv")):
        for name, value in (("field", field), ("wavelength", wavelength), ("configuration", configuration)):
            given = value is not None or name == "field"
            if given and (not isinstance(value, int) or value < 1):
                raise RayletError(f"raylet.load: {name} is {shown(value)}, expected a number from 1")
        if isinstance(glass_files, (str, os.PathLike)):
            raise RayletError("raylet.load: glass_files is one path, expected a list of paths")
        scene, report, doubts, arrays = _raylet.Scene.import_lens(
            os.fspath(path),
            (field, wavelength, configuration),
            skip_unknown,
            dict(glasses or {}),
            [os.fspath(file) for file in glass_files],
        )
        for doubt in doubts:
            warnings.warn(doubt, stacklevel=2)
    elif (field, wavelength, configuration, skip_unknown, glasses, tuple(glass_files)) != (
        1,
        None,
        None,
        False,
        None,
        (),
    ):
        raise RayletError(
            "raylet.load: field, wavelength, configuration, skip_unknown, glasses and glass_files are for lens files "
            "(.zmx, .zar, .seq, .csv) alone"
        )
    else:
        scene = _raylet.Scene.read(os.fspath(path))
    return imported(scene, report, os.fspath(path), arrays)


def imported(
    scene: _raylet.Scene, report: str, name: str, arrays: Sequence[tuple[str, NDArray[np.float64]]] = ()
) -> System:
    """A system of a scene that was read, of the report of its import, and of arrays by the paths of their fields."""
    system = System.__new__(System)
    system.import_report = report
    system._document = without_none(json.loads(scene.to_json()))
    waves = system._document["wavelength_um"]
    system._document["wavelength_um"] = waves[0] if len(waves) == 1 else waves
    put_in(system._document, dict(arrays))
    # From now on messages name the Python object, and no line of the file.
    system._name, system._scene, system._arrays = f"{name} in Python", scene, {}
    return system


def schema() -> dict[str, Any]:
    """The JSON Schema of scenes: every key of every element, layer, shape and setting, with what it means."""
    found: dict[str, Any] = json.loads(_raylet.schema())
    return found


def glasses() -> list[str]:
    """The names of all glasses of the catalogue."""
    return _raylet.glasses()


@public_calls
class System(Prescription):
    """Light, elements along an axis in the order light meets them, and a sensor.

    Lengths are in mm unless a name says otherwise, wavelengths in µm. Each element stands `thickness_mm` behind the one
    before it; a radius is positive when its centre lies at larger z. Every `add_…` returns the system, so calls can be
    chained; keys are those of scene files, where each is explained (:func:`raylet.schema`).

    The direction of the light is that of its source, :meth:`plane_wave` with `angle_deg`, for waves and rays alike.

    Parameters
    ----------
    wavelength_um : vacuum wavelength, or several.
    ambient : medium outside the elements: a catalogue name or a constant index.
    """

    #: What the import of a lens file changed and left out, as :func:`raylet.load` reports it; "" for other systems.
    import_report: str = ""

    # What it does.

    @overload
    def simulate(
        self,
        *,
        fields: Fields,
        wavelengths: Numbers | None = None,
        distances: Numbers | None = None,
        follow: bool = False,
        **settings: Unpack[RunSettings],
    ) -> Sweep: ...

    @overload
    def simulate(
        self,
        *,
        fields: Fields | None = None,
        wavelengths: Numbers,
        distances: Numbers | None = None,
        follow: bool = False,
        **settings: Unpack[RunSettings],
    ) -> Sweep: ...

    @overload
    def simulate(
        self,
        *,
        fields: Fields | None = None,
        wavelengths: Numbers | None = None,
        distances: Numbers,
        follow: bool = False,
        **settings: Unpack[RunSettings],
    ) -> Sweep: ...

    @overload
    def simulate(
        self,
        *,
        fields: None = None,
        wavelengths: None = None,
        distances: None = None,
        follow: Literal[False] = False,
        **settings: Unpack[RunSettings],
    ) -> Result: ...

    def simulate(
        self,
        *,
        fields: Fields | None = None,
        wavelengths: Numbers | None = None,
        distances: Numbers | None = None,
        follow: bool = False,
        method: str | None = None,
        target_error: float | None = None,
        threads: int | None = None,
        memory_limit_mb: float | None = None,
        seed: int | None = None,
        progress: Progress = None,
    ) -> Result | Sweep:
        """Carries the light of every wavelength to the sensor.

        With `fields`, `wavelengths` or `distances` it does so for each of them, and for each combination, and returns
        one stack of complex fields, labelled by what was varied: a :class:`raylet.Sweep`. Without them it returns a
        :class:`raylet.Result`.

        A result that misses its target error, or has no light on the sensor, warns (:attr:`Result.warnings`). Ctrl-C
        ends the run at once. Results have the same bits for any number of threads.

        Parameters
        ----------
        fields : angles [ax, ay] of the source in degrees, or places [x, y, z] of a point source in mm.
        wavelengths : vacuum wavelengths in µm, in place of the system's. Phases keep the wavelength they are made for.
        distances : distances in mm of the sensor from the element before it.
        follow : whether the sensor moves aside with the chief ray of each run, the ray through the middle of the
            element that limits the light; `x_mm` and `y_mm` of a result are on its own axes.
        method : "auto", "beamlet", "local_bands", "plane" or "paper".
        target_error : relative error of the complex field that automatic choices aim at, by the power of ten at or
            below it; 1e-3 unless the scene says otherwise.
        threads : processors to use; all of them by default. Several runs share them side by side: the first one has
            them all, and shows how many of the others fit into the memory limit together.
        memory_limit_mb : most memory that arrays may take, in 10⁶ bytes; half of what is free at the start if `None`.
            Each of several runs is planned with all of it, so that its bits are those that it has alone. The fields on
            the sensor, which the stack holds, come on top.
        seed : of whatever is drawn at random.
        progress : a function of (share done, what is being done), True for a tqdm bar, False for nothing; by default a
            bar where tqdm is installed and somebody watches.
        """
        settings: RunSettings = {
            **{"method": method, "target_error": target_error, "threads": threads},
            **{"memory_limit_mb": memory_limit_mb, "seed": seed, "progress": progress},
        }
        lists = {"fields": fields, "wavelengths": wavelengths, "distances": distances}
        if any(values is not None for values in lists.values()):
            return sweep(self, lists, follow, settings)
        if follow:
            raise TypeError("follow goes with fields, wavelengths or distances, found none of them")
        (result,) = run_all([self], **settings)
        for warning in result.warnings:
            warnings.warn(warning, stacklevel=3)
        return result

    def sweep(
        self,
        *,
        fields: Fields | None = None,
        wavelengths_um: Numbers | None = None,
        distances_mm: Numbers | None = None,
        follow: bool = False,
        **settings: Unpack[RunSettings],
    ) -> Sweep:
        """The long form of :meth:`simulate` with lists: the names of these arguments say their units."""
        lists = {"fields": fields, "wavelengths_um": wavelengths_um, "distances_mm": distances_mm}
        if all(values is None for values in lists.values()):
            raise TypeError("sweep takes fields, wavelengths_um or distances_mm, found none of them")
        return sweep(self, lists, follow, settings)

    def linearised(
        self,
        *elements: str,
        parameters: Sequence[str] = (),
        method: str | None = None,
        target_error: float | None = None,
        threads: int | None = None,
        memory_limit_mb: float | None = None,
        seed: int | None = None,
    ) -> LinearisedSystem:
        """The system as a function of the pixels of some elements and of some of its parameters, with its gradient.

        `parameters` are paths in the scene, such as "element[1].surface[0].radius_mm" (whose curvature then varies) or
        "element[0].thickness_mm". The settings are those of :meth:`simulate`.
        """
        paths = parameter_paths("System.linearised", "parameters", parameters)
        chosen = {"method": method, "target_error": target_error, "memory_limit_mb": memory_limit_mb}
        scene = self._compiled(seed, {key: value for key, value in chosen.items() if value is not None})
        return LinearisedSystem(self, elements, paths, thread_count(threads), scene)

    def trace(
        self,
        Hx: Any = 0.0,
        Hy: Any = 0.0,
        Px: Any = 0.0,
        Py: Any = 0.0,
        *,
        start_mm: Any = None,
        cosines: Any = None,
        field_deg: float | None = None,
        field_mm: float | None = None,
        channel: int = 0,
        parts: Part | Sequence[Part] | None = None,
        derivatives: str | Sequence[str] = (),
        threads: int | None = None,
    ) -> Rays:
        """Single rays through the whole system, by geometrical optics.

        A smooth element turns rays by the gradient of its phase; pixels let them go straight on.

        Parameters
        ----------
        Hx, Hy : normalised field: angles added to those of the source in units of `field_deg`, for a point source
            shifts of it in units of `field_mm`. At zero rays have the direction of the source, as waves have.
        Px, Py : normalised pupil: where the ray meets the first element, in units of the half widths of its aperture.
        start_mm, cosines : in place of these, points [x, y, z] (rays, 3) in mm before the first element and direction
            cosines [L, M, N] (rays, 3), both global: rays that are not those of the source. One point serves all
            directions, and one direction all points. A ray that does not meet the first element is lost.
        channel : index of the wavelength.
        parts : names or indices of the parts at which rays are recorded, −1 for the sensor; all by default. A ray takes
            56 bytes at each.
        derivatives : paths of parameters, such as "element[0].radius_mm", by which landings are differentiated; for a
            radius by its curvature. Through surfaces, mirrors and stops only.
        threads : how many to use; all processors' by default. They change no bit.
        """
        names = parameter_paths("System.trace", "derivatives", derivatives)
        if start_mm is not None or cosines is not None:
            if start_mm is None or cosines is None:
                raise TypeError("trace takes start_mm and cosines together, found one of them")
            if any(np.any(value) for value in (Hx, Hy, Px, Py)):
                raise TypeError("trace takes start_mm and cosines in place of Hx, Hy, Px, Py, found both")
            return trace_from(self, start_mm, cosines, self._channel(channel), parts, names, thread_count(threads))
        chosen = {"field_deg": field_deg, "field_mm": field_mm}
        scale = [None if value is None else number(f"System.trace: {key}", value) for key, value in chosen.items()]
        source = json.loads(self._compiled().to_json())["source"]
        return trace(
            self,
            source,
            (Hx, Hy, Px, Py),
            (scale[0], scale[1]),
            self._channel(channel),
            parts,
            names,
            thread_count(threads),
        )

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

        The scores are the normalised correlation of the intensity with the softened picture (`ncc`), the same over the
        whole sensor (`ncc_sensor`), and the share of the light in the picture (`efficiency`).

        Parameters
        ----------
        target : the picture: a PNG file, or values from 0 as an array [y, x], y upwards.
        element : name of the element, whose first layer of pixels is sought; the only one with pixels by default.
        size_mm : width and height of the picture on the sensor.
        efficiency_goal : share of the light that the picture is to have; what is found has somewhat less. Without it
            iterations buy likeness with light where the element is too small to resolve the picture (λ × distance /
            width).
        naive : with all lenses behind the element as one thin lens at the first vertex.
        """
        if not isinstance(naive, bool):
            raise TypeError(f"naive is {type_name(naive)}, expected True or False")
        table = {"target": target, "element": element, "size_mm": size_mm, "iterations": iterations}
        given = {**table, "efficiency_goal": efficiency_goal, **keys}
        return hologram(self, given, naive=naive, threads=thread_count(threads), progress=progress)

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
        loss : the losses: dictionaries with `kind` ("likeness", "mse", "efficiency", "encircled_energy", "spot",
            "overlap") and the keys of that kind.
        variable : parameters that are sought: dictionaries with `path`, such as "element[1].surface[0].radius_mm", and
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
        return design(self, *tables, keeping=keeping, threads=thread_count(threads), progress=progress)

    def check(self) -> list[str]:
        """What there is to know before a run, such as light that is clipped, pixels that do not fill their aperture,
        orders that do not propagate: lines that begin with "warning" or "note"."""
        lines: dict[str, None] = {}
        for channel in range(len(self.wavelength_um)):
            for hop, grave, text in _raylet.check(self._compiled(), self._arrays, channel):
                lines[f"{'warning' if grave else 'note'}, {hop}: {text}"] = None
        return list(lines)

    # What it looks like.

    def draw(
        self, ax: Axes | None = None, *, fields: Sequence[Sequence[float]] | None = None, channel: int = 0
    ) -> tuple[Figure, Axes]:
        """The section through the system with a few rays of each field, in a colour for each.

        Rays start where they come through to the sensor. `fields` are angles [ax, ay] of the source in degrees, or
        places [x, y, z] of a point source in mm; by default that of the source and those of the table `[design]`.
        """
        from raylet.plotting import draw_layout

        given = np.zeros((0, 2)) if fields is None else real("fields", fields)
        if given.ndim != 2 or given.shape[1] not in (2, 3) or (fields is not None and len(given) == 0):
            raise ValueError(
                f"fields have shape {given.shape}, expected one or more [ax, ay] in degrees or [x, y, z] in mm"
            )
        channel = self._channel(channel)
        layout = json.loads(_raylet.layout(self._compiled(), self._arrays, channel, given.tolist()))
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
            raise TypeError(f"element is {type_name(element)}, expected the name of one")
        values, bounds = _raylet.element(self._compiled(), self._arrays, element, self._channel(channel))
        low_x, high_x, low_y, high_y = bounds
        return values, (low_x, high_x, low_y, high_y)

    @property
    def parts(self) -> list[dict[str, Any]]:
        """Its screens and surfaces in the order light meets them: name, kind, position, radii, tilt, extent, medium."""
        parts: list[dict[str, Any]] = json.loads(_raylet.parts(self._compiled(), self._arrays, 0))
        return parts

    def _repr_html_(self) -> str:
        from raylet.plotting import html

        return html(repr(self), self.draw)

    @described
    def __repr__(self) -> str:
        waves = _shown_waves(self.wavelength_um)
        head = f"<raylet.System{f' {shown(self.title)}' if self.title else ''}, λ = {waves} µm"
        try:
            parts = self.parts
        except Exception as error:
            lines = str(error).splitlines() or [type(error).__name__]
            return f"{head}, {len(self._document['element'])} elements; not complete: {cut(lines[0])}>"
        return f"{head}>\n{_table(parts)}"


def _shown_waves(waves: Sequence[Any]) -> str:
    """Wavelengths, the first of very many."""
    first = (f"{wave:g}" if isinstance(wave, float) else shown(wave) for wave in waves[:MOST_WAVES])
    more = f", … ({len(waves)} wavelengths)" if len(waves) > MOST_WAVES else ""
    return ", ".join(first) + more


def _table(parts: Sequence[Mapping[str, Any]]) -> str:
    """Parts as lines of a table; x, y and tilts where there are any."""
    across = [axis for axis in (0, 1) if any(abs(part["position_mm"][axis]) > 1e-9 for part in parts)]
    tilted = any(abs(angle) > 1e-9 for part in parts for angle in part["tilt_deg"])

    def row(part: Mapping[str, Any]) -> list[str]:
        radius = [f"{radius:.6g}" if radius is not None else "∞" for radius in part["radii_mm"]]
        radii = radius[0] if radius[0] == radius[1] else "/".join(radius)
        bounds = part["bounds_mm"]
        extent = f"{bounds[1] - bounds[0]:.5g} x {bounds[3] - bounds[2]:.5g}" if bounds else ""
        place = [f"{part['position_mm'][axis]:.6g}" for axis in (*across, 2)]
        turn = ["/".join(f"{round(angle, 6) + 0.0:.6g}" for angle in part["tilt_deg"])] if tilted else []
        return [part["name"], part["kind"], *place, *turn, radii, extent, part["medium"]]

    places = [*("xy"[axis] + "/mm" for axis in across), "z/mm", *(["tilt/°"] if tilted else [])]
    rows = [["name", "kind", *places, "radius/mm", "extent/mm", "behind"], *map(row, parts)]
    widths = [max(len(line[i]) for line in rows) for i in range(len(rows[0]))]
    return "\n".join("  " + "  ".join(text.ljust(width) for text, width in zip(line, widths)).rstrip() for line in rows)
