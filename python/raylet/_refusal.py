"""What raylet refuses, and how much of a value its messages show."""

from __future__ import annotations

import functools
import reprlib
from collections.abc import Callable
from typing import Any

#: The most characters of a value that a message shows.
MOST_SHOWN = 200

#: How deep lists and tables may lie in each other: deeper ones contain themselves, or are no system.
MOST_LEVELS = 50

#: The most wavelengths of a system or a result that are shown.
MOST_WAVES = 20

#: The most bits of a whole number whose digits are shown.
MOST_BITS = 1000


class _Short(reprlib.Repr):
    """Short texts of values. The whole text of a large value is never made."""

    def repr_int(self, x: int, level: int) -> str:
        bits = x.bit_length()
        return f"<whole number of {bits} bits>" if bits > MOST_BITS else super().repr_int(x, level)

    def repr_instance(self, x: Any, level: int) -> str:
        if isinstance(x, str):
            return self.repr_str(str.__getitem__(x, slice(0, 2 * MOST_SHOWN)), level)
        if isinstance(x, bytes | bytearray | memoryview | list | tuple | dict | set | frozenset):
            return f"<{type(x).__name__} of {len(x)} values>"
        return super().repr_instance(x, level)


_short = _Short()
_short.maxstring = _short.maxother = MOST_SHOWN
_short.maxlist = _short.maxtuple = _short.maxdict = _short.maxset = 8
_short.maxlong = 60


class RayletError(ValueError):
    """What raylet refuses: where it is, what was found there, what was expected.

    Attributes
    ----------
    path : the field, such as "element[1].surface[0].glass", or the argument of a call, such as "radius_mm".
    found : what was found there.
    expected : what was expected.
    hint : what may have been meant.
    call : the call that gave it, such as "System.add_surface, element[1] 'front'". Each is "" where there is none.
    """

    path: str = ""
    found: str = ""
    expected: str = ""
    hint: str = ""
    call: str = ""


# Users import it from here, and read this name.
RayletError.__module__ = "raylet"


def shown(value: Any) -> str:
    """At most 200 characters of a value for a message."""
    return cut(_short.repr(value))


def cut(text: str) -> str:
    """At most 200 characters of a text."""
    return text if len(text) <= MOST_SHOWN else f"{text[:MOST_SHOWN]}… ({len(text)} characters)"


def type_name(value: Any) -> str:
    """The name of a value's type, at most 200 characters of it."""
    return cut(type(value).__name__)


def check_level(level: int, path: str) -> None:
    """Refuses a value that lies too deep in lists or tables."""
    if level > MOST_LEVELS:
        raise RayletError(f"{cut(path)} lies more than {MOST_LEVELS} lists or tables deep, or contains itself")


def described(method: Callable[[Any], str]) -> Callable[[Any], str]:
    """A `__repr__` that never raises: where the object is not whole, it says so."""

    @functools.wraps(method)
    def describe(self: Any) -> str:
        try:
            return method(self)
        except Exception as error:  # whatever is wrong is what there is to say
            lines = str(error).splitlines() or [type(error).__name__]
            return f"<{type(self).__module__}.{type(self).__name__}, not complete: {cut(lines[0])}>"

    return describe
