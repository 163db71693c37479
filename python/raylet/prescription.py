"""What a system is made of: light, elements in the order light meets them, and how they are computed."""

from __future__ import annotations

import copy
import functools
import json
import os
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, Union

import numpy as np
from numpy.typing import NDArray

from raylet import _raylet
from raylet._arrays import grid, real
from raylet._calls import checked, checked_element, unknown_argument
from raylet._document import copied, element_names, npy, put_in, rebased, taken_out, write
from raylet._plain import dumps, plain
from raylet._refusal import RayletError, shown, type_name
from raylet.exchange.fields import SampledField
from raylet.layers import ARRAY_OF, Aperture, Layer, Pair, constant, pixel_shape
from raylet.sources import Taper, sampled

if TYPE_CHECKING:
    from typing_extensions import Self

Glass = Union[str, Mapping[str, Any], float]


class Prescription:
    """What :class:`raylet.System` is made of."""

    def __init__(
        self,
        wavelength_um: float | Sequence[float],
        *,
        title: str = "",
        ambient: Glass = "air",
        seed: int = 1,
    ) -> None:
        light = {"wavelength_um": _plain(wavelength_um), "ambient": constant(ambient)}
        head = checked("System", "system", {"version": 1, "title": title, **light, "seed": seed})
        self._document: dict[str, Any] = {**head, "source": {"kind": "plane"}, "element": [], "settings": {}}
        self._name = "system"
        self._scene: _raylet.Scene | None = None
        self._arrays: dict[str, NDArray[Any]] = {}

    # Light.

    def plane_wave(
        self,
        *,
        angle_deg: Sequence[float] = (0.0, 0.0),
        taper: Taper | None = None,
        beam_radius_mm: float | None = None,
    ) -> Self:
        """Collimated light of unit amplitude with direction cosines sin ax, sin ay; with a :func:`raylet.beam_taper` a
        laser beam."""
        source = {"kind": "plane", "angle_deg": angle_deg, "taper": taper, "beam_radius_mm": beam_radius_mm}
        return self._light("plane_wave", source)

    def point_source(
        self, position_mm: Sequence[float], *, taper: Taper | None = None, beam_radius_mm: float | None = None
    ) -> Self:
        """Light of a point [x, y, z], z < 0 before the first element, with unit amplitude and phase zero at that
        element's vertex; with a :func:`raylet.cone_taper` that of a laser diode."""
        source = {"kind": "point", "position_mm": position_mm, "taper": taper, "beam_radius_mm": beam_radius_mm}
        return self._light("point_source", source)

    def gaussian_beam(
        self,
        waist_radius_um: Pair,
        *,
        waist_mm: Sequence[float] = (0.0, 0.0, 0.0),
        angle_deg: Sequence[float] = (0.0, 0.0),
        rotation_deg: float = 0.0,
        beam_radius_mm: float | None = None,
    ) -> Self:
        """A Gaussian beam of unit amplitude at the centre of its waist, `waist_mm` [x, y, z] from the first element's
        vertex. `waist_radius_um` is where the intensity is 1/e² of that in the middle, along both axes or along each;
        for a single-mode fibre half its mode field diameter."""
        source = {"waist_radius_um": waist_radius_um, "waist_mm": waist_mm, "angle_deg": angle_deg}
        aside = {"rotation_deg": rotation_deg, "beam_radius_mm": beam_radius_mm}
        return self._light("gaussian_beam", {"kind": "gaussian", **source, **aside})

    def field_source(
        self,
        samples: Any,
        *,
        pitch_um: Pair | None = None,
        distance_mm: float,
        size: Sequence[int] | None = None,
        decenter_mm: Sequence[float] = (0.0, 0.0),
        tilt_deg: Sequence[float] = (0.0, 0.0, 0.0),
    ) -> Self:
        """A field of your own on a plane `distance_mm` before the first element's vertex, about the axis.

        A :class:`raylet.SampledField`, such as :func:`raylet.read_beam` gives, has its pitch and place with it. Other
        `samples` [y, x] are complex and stand at the Nyquist rate or closer; between them the field has their band, and
        beyond them it is zero. They may be an array, the name of a .npy file, or a function of x and y in mm (arrays),
        which is called once for `size` [nx, ny] samples."""
        if isinstance(samples, SampledField):
            if pitch_um is not None:
                raise RayletError("System.field_source: pitch_um for a SampledField, which has its own")
            samples, pitch_um, middle = samples.placed(self._document["wavelength_um"])
            if any(middle):
                if any(tilt_deg):
                    raise RayletError(
                        f"System.field_source: tilt_deg {shown(tilt_deg)} for a field with its middle at"
                        f" {shown(list(middle))} mm, expected a field about the axis"
                    )
                decenter_mm = [a + b for a, b in zip(decenter_mm, middle)]
        elif pitch_um is None:
            raise RayletError("System.field_source needs pitch_um: the distance of neighbouring samples in µm")
        plane = {"distance_mm": distance_mm, "decenter_mm": decenter_mm, "tilt_deg": tilt_deg}
        keys = {"kind": "field", "samples": "of its own", "pitch_um": pitch_um, "size": size, **plane}
        checked("System.field_source", "source", keys)
        if callable(samples):
            samples = sampled(samples, pitch_um, size)
        elif not isinstance(samples, (str, os.PathLike)):
            samples = grid("System.field_source: samples", samples)
        return self._light("field_source", {**keys, "samples": samples})

    def fibre_source(
        self,
        *,
        distance_mm: float,
        mode_field_diameter_um: float | None = None,
        core_radius_um: float | None = None,
        numerical_aperture: float | None = None,
        mode: Sequence[int] = (0, 1),
        rotation_deg: float = 0.0,
        decenter_mm: Sequence[float] = (0.0, 0.0),
        tilt_deg: Sequence[float] = (0.0, 0.0, 0.0),
    ) -> Self:
        """A mode of a fibre that ends `distance_mm` before the first element's vertex: the Gaussian of
        `mode_field_diameter_um`, or the mode LP_lm of a step-index fibre of `core_radius_um` and `numerical_aperture`.

        The mode field diameter is where the intensity is 1/e² of that in the middle, at all wavelengths. `mode` is
        [l, m]: (0, 1) is the fundamental mode, (1, 1) the next. A maximum lies at `rotation_deg`, from x towards y. Its
        largest amplitude is one."""
        profile = {"core_radius_um": core_radius_um, "numerical_aperture": numerical_aperture}
        fibre = {"mode_field_diameter_um": mode_field_diameter_um, **profile, "mode": mode}
        plane = {"distance_mm": distance_mm, "decenter_mm": decenter_mm, "tilt_deg": tilt_deg}
        return self._light("fibre_source", {"kind": "fibre", **fibre, "rotation_deg": rotation_deg, **plane})

    # Elements.

    def add(self, kind: str, **keys: Any) -> Self:
        """Adds an element of any kind by the keys of a scene file."""
        self._check_keys(kind, keys)
        element = {"kind": kind, **keys}
        if "glass" in element:
            element["glass"] = constant(element["glass"])
        name = f" {shown(keys['name'])}" if keys.get("name") else ""
        rows = self._document["element"]
        rows.append(checked_element(f"System.add_{kind}, element[{len(rows)}]{name}", element, rows))
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
    ) -> Self:
        """Adds a refracting surface; `glass` is behind it, the ambient medium where it is not given."""
        given = {"radius_mm": radius_mm, "thickness_mm": thickness_mm, "semi_aperture_mm": semi_aperture_mm}
        return self.add("surface", glass=glass, **given, **keys)

    def add_lens(self, *surfaces: Mapping[str, Any], thickness_mm: float | None = None, **keys: Any) -> Self:
        """Adds surfaces that move as one, each a dictionary of what :meth:`add_surface` takes."""
        rows = [
            {**surface, "glass": constant(surface["glass"])}
            if isinstance(surface, Mapping) and "glass" in surface
            else surface
            for surface in surfaces
        ]
        return self.add("lens", surface=rows, thickness_mm=thickness_mm, **keys)

    def add_mirror(
        self,
        *,
        radius_mm: float | None = None,
        thickness_mm: float | None = None,
        semi_aperture_mm: float | None = None,
        **keys: Any,
    ) -> Self:
        """Adds a mirror; after it thicknesses are negative, after another one positive again."""
        given = {"radius_mm": radius_mm, "thickness_mm": thickness_mm, "semi_aperture_mm": semi_aperture_mm}
        return self.add("mirror", **given, **keys)

    def add_doe(
        self,
        *layers: Layer,
        aperture: Aperture,
        thickness_mm: float | None = None,
        glass: Glass | None = None,
        name: str | None = None,
        **keys: Any,
    ) -> Self:
        """Adds a diffractive element, the product of layers (see :mod:`raylet.layers`) within an aperture. With a
        `glass` behind it, it stands on an interface, such as a surface of a lens, which refracts too."""
        given = {"aperture": aperture, "thickness_mm": thickness_mm, "glass": glass, "name": name}
        return self.add("doe", layer=list(layers), **given, **keys)

    def add_paraxial_lens(
        self, focal_length_mm: float, *, aperture: Aperture, thickness_mm: float | None = None, **keys: Any
    ) -> Self:
        """Adds an ideal thin lens."""
        given = {"focal_length_mm": focal_length_mm, "aperture": aperture, "thickness_mm": thickness_mm}
        return self.add("paraxial_lens", **given, **keys)

    def add_stop(self, aperture: Aperture, *, thickness_mm: float | None = None, **keys: Any) -> Self:
        """Adds an aperture in an opaque screen."""
        return self.add("stop", aperture=aperture, thickness_mm=thickness_mm, **keys)

    def add_coordinate_break(
        self,
        *,
        decenter_mm: Sequence[float] = (0.0, 0.0),
        tilt_deg: Sequence[float] = (0.0, 0.0, 0.0),
        thickness_mm: float = 0.0,
        **keys: Any,
    ) -> Self:
        """Shifts, then turns the axis for all that follows."""
        turn = {"decenter_mm": decenter_mm, "tilt_deg": tilt_deg, "thickness_mm": thickness_mm}
        return self.add("coordinate_break", **turn, **keys)

    def add_sensor(self, *, pixels: Sequence[int], pitch_um: Pair, **keys: Any) -> Self:
        """Adds the sensor: the field is computed at the centres of [nx, ny] pixels. It is the last element."""
        return self.add("sensor", pixels=pixels, pitch_um=pitch_um, **keys)

    def settings(self, **settings: Any) -> Self:
        """Chooses how the system is computed; keys of the table `[settings]` of scene files."""
        chosen = {**self._document["settings"], **settings}
        return self._set("settings", checked("System.settings", "settings", chosen))

    def with_pixels(self, element: str, *, phase: Any = None, amplitude: Any = None, transmission: Any = None) -> Self:
        """The same system with other pixels, of the same number, in an element's first layer of pixels."""
        given = {"phase": phase, "amplitude": amplitude, "transmission": transmission}
        held = {
            key: ARRAY_OF[key](f"System.with_pixels: {key}", value) for key, value in given.items() if value is not None
        }
        if not held:
            raise TypeError("with_pixels takes a phase, an amplitude or a transmission")
        other = self._copy()
        row = other._document["element"][self._number_of(element)]
        layers = [layer for layer in row.get("layer", []) if layer.get("kind") == "pixels"]
        if not layers:
            raise RayletError(f"element {shown(element)} has no layer of pixels")
        old, shape = layers[0], pixel_shape(layers)
        for key, array in held.items():
            if shape not in (None, array.shape):
                raise ValueError(f"{key} has shape {array.shape}, expected {shape}, as the element's pixels have")
        for key in ("phase", "amplitude", "transmission", "key", "size", "phase_scale"):
            old.pop(key, None)
        old.update(held)
        return other

    # What it says.

    @property
    def title(self) -> str:
        """Its title."""
        return str(self._document.get("title", ""))

    @property
    def wavelength_um(self) -> list[float]:
        """Its wavelengths in vacuum."""
        given = self._document["wavelength_um"]
        return list(given) if isinstance(given, list) else [given]

    def to_toml(self) -> str:
        """The scene file of the system, with every default; arrays in memory are named but not in it."""
        return self._compiled().to_toml()

    def save(self, path: str | os.PathLike[str], *, overwrite: bool = False) -> None:
        """Writes a scene file that :func:`load` and the command line read, and arrays in memory beside it (.npy).

        Files that raylet did not write, or that were changed since, are refused unless `overwrite` is true.
        """
        folder, name = os.path.split(os.fspath(path))
        document = copied(self._document)
        rebased(document, os.path.dirname(self._name), folder)
        arrays: dict[str, NDArray[Any]] = {}
        taken_out(document, "", arrays)
        files: dict[str | os.PathLike[str], bytes] = {}
        for place, array in arrays.items():
            file = f"{os.path.splitext(name)[0]}.{place.replace('[', '').replace(']', '')}.npy"
            files[os.path.join(folder, file)] = npy(array)
            put_in(document, {place: file})
        files[path] = dumps(document).encode()
        write(files, overwrite=overwrite)

    # How it is handed to the library.

    @staticmethod
    def _check_keys(kind: str, keys: Mapping[str, Any]) -> None:
        """Refuses keys that no element of this kind has, where they are given."""
        known = _element_keys().get(kind) if isinstance(kind, str) else None
        if known is None:
            raise TypeError(
                f"no element is of kind {shown(kind)}, expected one of {', '.join(sorted(_element_keys()))}"
            )
        for key in keys:
            if key not in known:
                raise unknown_argument(f"System.add_{kind}", key, known)

    def _light(self, call: str, source: dict[str, Any]) -> Self:
        return self._set("source", checked(f"System.{call}", "source", source))

    def _set(self, key: str, value: Any) -> Self:
        self._document[key] = value
        self._scene = None
        return self

    def _copy(self) -> Self:
        """The same system with a document of its own, whose arrays are shared."""
        other = copy.copy(self)
        other._document, other._scene = copied(self._document), None
        return other

    def _number_of(self, element: str) -> int:
        names = element_names(self._document)
        if element not in names:
            known = ", ".join(shown(name) for name in names[:20]) or "none"
            raise RayletError(f"no element is called {shown(element)}; there are: {known}")
        return names.index(element)

    def _channel(self, channel: Any) -> int:
        """The index of a wavelength, if it is one."""
        if isinstance(channel, bool) or not isinstance(channel, (int, np.integer)):
            raise TypeError(f"channel is {type_name(channel)}, expected the index of a wavelength")
        if not 0 <= channel < len(self.wavelength_um):
            raise IndexError(f"channel is {shown(channel)}, expected from 0 to {len(self.wavelength_um) - 1}")
        return int(channel)

    def _compiled(self, seed: int | None = None, settings: Mapping[str, Any] | None = None) -> _raylet.Scene:
        """The library's scene, with other settings where they are given."""
        if self._scene is None:
            self._arrays = {}
            document = taken_out(self._document, "", self._arrays)
            self._scene = _raylet.Scene.build(plain(document), self._name)
        scene = self._scene
        if seed is not None:
            document = {**taken_out(self._document, "", {}), "seed": seed}
            scene = _raylet.Scene.build(plain(document), self._name)
        return scene.with_settings(plain(settings)) if settings else scene


@functools.cache
def _element_keys() -> dict[str, frozenset[str]]:
    """The keys of each kind of element, from the schema."""
    variants = json.loads(_raylet.schema())["$defs"]["Element"]["oneOf"]
    tables = (variant["properties"] for variant in variants)
    return {keys["kind"]["const"]: frozenset(keys) - {"kind"} for keys in tables}


def _plain(wavelength_um: Any) -> Any:
    if isinstance(wavelength_um, np.ndarray) and wavelength_um.ndim == 0:
        return float(wavelength_um)
    if isinstance(wavelength_um, (Sequence, np.ndarray)) and not isinstance(wavelength_um, str):
        waves = real("System: wavelength_um", wavelength_um)
        if waves.ndim != 1:
            raise ValueError(f"System: wavelength_um has shape {waves.shape}, expected a number or a list of them")
        return [float(wave) for wave in waves]
    return wavelength_um
