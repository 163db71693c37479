"""What raylet refuses."""

from __future__ import annotations


class RayletError(ValueError):
    """What raylet refuses: where it is, what was found there, what was expected.

    Attributes
    ----------
    path : the field, such as "element[1].surface[0].glass".
    found : what was found there.
    expected : what was expected.
    hint : what may have been meant. Each is "" where there is none.
    """

    path: str = ""
    found: str = ""
    expected: str = ""
    hint: str = ""


# Users import it from here, and read this name.
RayletError.__module__ = "raylet"
