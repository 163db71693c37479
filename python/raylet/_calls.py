"""Public calls, which refuse what no system has where it is given, in their own name.

The library is the judge of arguments: each stands as a key in a small scene of its own. So calls and scene files have
the same limits, the same words and the same guesses.
"""

from __future__ import annotations

import difflib
import functools
import inspect
import re
from collections.abc import Callable, Iterable, Mapping
from typing import Any, ParamSpec, TypeVar

from raylet import _raylet
from raylet._document import taken_out
from raylet._plain import plain
from raylet._refusal import RayletError, shown

Parameters = ParamSpec("Parameters")
Answer = TypeVar("Answer")
Class = TypeVar("Class", bound=type)
Given = TypeVar("Given", bound=Mapping[str, Any])

_DISC = {"disc": {"radius_mm": 1.0}}
# No layer is too small for an aperture that is a point.
_POINT = {"disc": {"radius_mm": 1e-12}}
_STOP = {"kind": "stop", "aperture": _DISC, "thickness_mm": 1.0}
_MIRROR = {"kind": "mirror", "semi_aperture_mm": 1.0, "thickness_mm": -1.0}
_SENSOR = {"kind": "sensor", "pixels": [1, 1], "pitch_um": 1.0}
_SCENE = {"version": 1, "wavelength_um": 0.5, "source": {"kind": "plane"}, "element": [_STOP, _SENSOR]}


#: Where a value stands in a scene of its own: its path, and the keys of the scene.
_PLACES: dict[str, tuple[str, Callable[[Any], dict[str, Any]]]] = {
    "aperture": ("element[0].aperture", lambda value: {"element": [{**_STOP, "aperture": value}, _SENSOR]}),
    "layer": (
        "element[0].layer[0]",
        lambda value: {"element": [{**_STOP, "kind": "doe", "aperture": _POINT, "layer": [value]}, _SENSOR]},
    ),
    "beam taper": ("source.taper", lambda value: {"source": {"kind": "plane", "taper": value}}),
    "cone taper": (
        "source.taper",
        lambda value: {"source": {"kind": "point", "position_mm": [0.0, 0.0, -1.0], "taper": value}},
    ),
    "source": ("source", lambda value: {"source": value}),
    "settings": ("settings", lambda value: {"settings": value}),
    "system": ("", lambda value: value),
}

#: The calls that make what an argument takes.
_MADE_BY = {
    "aperture": "apertures are made by calls such as raylet.disc(1.0)",
    "blocked": "apertures are made by calls such as raylet.disc(1.0)",
    "layer": "layers are made by calls such as raylet.lens(focal_length_mm=50.0)",
    "taper": "tapers are made by raylet.beam_taper and raylet.cone_taper",
    "surface": "each surface is a dictionary of what add_surface takes",
}

#: What is given in another place than some expect.
_ELSEWHERE = {
    "field_deg": "the direction of the light is that of its source, for waves and rays: plane_wave(angle_deg=(x, y)); "
    "trace(Hx, Hy, field_deg=…) adds to it",
    "field_mm": "the light comes from its source, for waves and rays: point_source((x, y, z)); "
    "trace(Hx, Hy, field_mm=…) moves it",
}

#: The calls that choose a source, by its kind.
_SOURCES = {
    "plane": "plane_wave",
    "point": "point_source",
    "gaussian": "gaussian_beam",
    "field": "field_source",
    "fibre": "fibre_source",
}


def checked(call: str, place: str, value: Given, inside: str = "") -> Given:
    """A value that stands at one of the places of a scene, if a scene can have it there; `inside` leads from it to the
    table of the arguments."""
    path, scene = _PLACES[place]
    return _judged(call, value, f"{path}.{inside}" if inside else path, scene)


def checked_element(call: str, element: Given, before: Iterable[Mapping[str, Any]]) -> Given:
    """An element, if a scene can have it behind those before it: of these it counts how often they turn the light."""
    back = sum(map(_turns, before)) % 2 == 1
    first = [_MIRROR] if back else [_STOP]
    ahead = -1.0 if back != _turns(element) else 1.0

    def scene(value: dict[str, Any]) -> dict[str, Any]:
        rest = [value] if value["kind"] == "sensor" else [{"thickness_mm": ahead, **value}, _SENSOR]
        return {"element": [*first, *rest]}

    return _judged(call, element, "element[1]", scene)


def _turns(element: Mapping[str, Any]) -> bool:
    """Whether an element turns the light back."""
    return element["kind"] == "mirror" or (element["kind"] == "doe" and element.get("reflect") is True)


def _judged(call: str, value: Given, path: str, scene: Callable[[Any], dict[str, Any]]) -> Given:
    """A value, if the library has the scene with it; `path` leads to the table of the arguments."""
    try:
        held = _with_heights(plain(taken_out(value, "", {})))
        _raylet.Scene.build({**_SCENE, **scene(held)}, call)
    except RayletError as error:
        if error.path:
            _renamed(error, call, _below(error.path, path))
        elif not str(error).startswith(call):
            error.args = (f"{call}: {error}",)
        raise
    except (TypeError, ValueError) as error:
        error.args = (f"{call}: {error}",)
        raise
    return value


def _with_heights(value: Any) -> Any:
    """A document whose reliefs of a size have heights, also those that a design is to find."""
    if isinstance(value, list):
        return [_with_heights(item) for item in value]
    if not isinstance(value, dict):
        return value
    blank = {"height_um": "to be found"} if value.get("kind") == "height" and "size" in value else {}
    return {**blank, **{key: _with_heights(item) for key, item in value.items()}}


def refusal(call: str, path: str, found: str, expected: str) -> RayletError:
    """What is raised for an argument that the library never sees."""
    error = RayletError()
    error.found, error.expected = found, expected
    return _renamed(error, call, path)


def listed(value: Any) -> Any:
    """A list of what is given, for a single dictionary that of it alone; what is no list is left to be refused."""
    if isinstance(value, Mapping):
        return [value]
    return list(value) if isinstance(value, Iterable) and not isinstance(value, (str, bytes)) else value


def parameter_paths(call: str, name: str, paths: Any) -> list[str]:
    """A list of paths in the scene, from a list or a single one."""
    if isinstance(paths, str):
        return [paths]
    if not isinstance(paths, (list, tuple)) or not all(isinstance(path, str) for path in paths):
        raise TypeError(f"{call}: {name} is {shown(paths)}, expected a list of paths such as 'element[0].radius_mm'")
    return list(paths)


def public_call(function: Callable[Parameters, Answer]) -> Callable[Parameters, Answer]:
    """A public function that refuses unknown arguments by its own name."""
    return _called(f"raylet.{function.__name__}", function)


def public_calls(public: Class) -> Class:
    """A class whose public methods, its own and those that it has from others, are known by its name."""
    members = {name: member for base in reversed(public.__mro__[:-1]) for name, member in vars(base).items()}
    for name, member in members.items():
        title = public.__name__ if name == "__init__" else f"{public.__name__}.{name}"
        if inspect.isfunction(member) and (name == "__init__" or not name.startswith("_")):
            setattr(public, name, _called(title, member))
        elif isinstance(member, property) and member.fget is not None:
            setattr(public, name, property(_called(title, member.fget)))
    return public


def unknown_argument(call: str, key: str, known: Iterable[str]) -> TypeError:
    """What is raised for an argument that a call does not have."""
    names = sorted(known)
    hint = _hint(key, names)
    told = f"{call} has no argument {shown(key)}{f'; {hint}' if hint else ''}"
    return TypeError(f"{told}\nIts arguments: {', '.join(names) or 'none'}")


def _hint(key: str, known: list[str]) -> str:
    """That raylet does not have what an argument asks for, in the library's words, where else it is given, or the
    argument that was meant."""
    try:
        _raylet.Scene.build({**_SCENE, key: 0}, "")
    except RayletError as error:
        if error.hint and not error.hint.startswith("did you mean"):
            return error.hint
    if key in _ELSEWHERE:
        return _ELSEWHERE[key]
    near = difflib.get_close_matches(key, known, n=1)
    return f"did you mean {near[0]}?" if near else ""


def _called(name: str, function: Callable[Parameters, Answer]) -> Callable[Parameters, Answer]:
    """A function that names itself in what it refuses."""
    signature = inspect.signature(function)

    @functools.wraps(function)
    def called(*args: Parameters.args, **given: Parameters.kwargs) -> Answer:
        try:
            signature.bind(*args, **given)
        except TypeError as error:
            raise _misfit(name, signature, given, error) from None
        try:
            return function(*args, **given)
        except TypeError as error:
            # Python names the class from which a method comes, and not the call.
            twice = re.search(r"got multiple values for keyword argument ('\w+')$", str(error))
            if twice:
                raise TypeError(f"{name}: {twice[1]} is given twice, or stands for what is given in order") from None
            raise
        except RayletError as error:
            if not error.call:
                told_of_system(error, name, args[0] if args else None, given)
            raise

    return called


def _misfit(call: str, signature: inspect.Signature, given: Mapping[str, Any], error: TypeError) -> TypeError:
    """What is raised for arguments that do not fit a signature."""
    known = [name for name in signature.parameters if name != "self"]
    for key in given:
        if key not in known:
            return unknown_argument(call, key, known)
    return TypeError(f"{call}: {error}\nIts arguments: {', '.join(known) or 'none'}")


def told_of_system(error: RayletError, running: str, system: Any, given: Mapping[str, Any]) -> None:
    """Says which call gave a system that has been built in Python what a run refuses: the call, the element, the
    argument."""
    document = getattr(system, "_document", None)
    match = re.fullmatch(r"(?:(element)\[(\d+)\]|(\w+))\.?(.*)", error.path)
    if document is None or match is None:
        return
    table, number, rest = match[1] or match[3], match[2], match[4]
    given_here = re.split(r"[.\[]", rest or table)[0] in given
    if rest == "kind" and number is not None:
        _renamed(error, running, f"element[{number}]", path=error.path)
    elif number is None and (given_here or table == "element"):
        _renamed(error, running, "" if table == "element" else rest or table, path=error.path)
    elif table in ("hologram", "design"):
        _renamed(error, f"System.{table}", rest, path=error.path)
    elif system._name == "system":
        _renamed(error, _giver(document, table, number), rest or _head(table), path=error.path)


def _head(table: str) -> str:
    """The argument of `System` that a top-level key is, if it is one."""
    return "" if table in ("element", "source", "settings") else table


def _giver(document: Mapping[str, Any], table: str, number: str | None) -> str:
    """The call that gave a part of a document, with the element that it made."""
    if number is not None:
        row = document["element"][int(number)]
        name = f" {shown(row['name'])}" if row.get("name") else ""
        return f"System.add_{row['kind']}, element[{number}]{name}"
    if table == "source":
        return f"System.{_SOURCES.get(document['source']['kind'], 'source')}"
    return "System.settings" if table == "settings" else "System"


def _below(path: str, top: str) -> str:
    """The rest of a path below another one."""
    return path[len(top) :].lstrip(".") if path.startswith(top) else path


def _renamed(error: RayletError, call: str, argument: str, *, path: str | None = None) -> RayletError:
    """An error that names a call and its argument."""
    error.call, error.path = call, argument if path is None else path
    name = re.split(r"[.\[]", re.sub(r"\[\d+\]$", "", argument))[-1]
    if not error.hint and error.expected.startswith("a table"):
        error.hint = _MADE_BY.get(name, "")
    hint = f"\nhint: {error.hint}" if error.hint else ""
    place = f"{call}: {argument}" if argument else call
    error.args = (f"{place}: found {error.found}, expected {error.expected}{hint}",)
    return error
