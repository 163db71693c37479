"""Pictures with matplotlib; every function returns (figure, axes)."""

from __future__ import annotations

import base64
import io
import textwrap
from collections.abc import Callable
from html import escape
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from raylet._refusal import shown

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

#: Phases are shown where the intensity is above this share of its maximum.
_DARK = 1e-4


def _axes(ax: Axes | None, size: tuple[float, float]) -> tuple[Any, Any]:
    if ax is not None:
        return ax.figure, ax
    try:
        import matplotlib.pyplot as plt
    except ImportError as error:
        raise ImportError("pictures need matplotlib: pip install matplotlib") from error
    return plt.subplots(figsize=size, layout="constrained")


def _edges(centres: NDArray[np.float64]) -> tuple[float, float]:
    half = 0.5 * (centres[-1] - centres[0]) / (len(centres) - 1) if len(centres) > 1 else 5e-4
    return float(centres[0] - half), float(centres[-1] + half)


def _image(figure: Any, ax: Any, values: Any, extent: tuple[float, ...], label: str, **how: Any) -> None:
    # What is dark has no phase: grey, which no phase is.
    ax.set_facecolor("0.75")
    image = ax.imshow(values, extent=extent, origin="lower", interpolation="nearest", **how)
    # As high as the picture, whose own shape the axes have.
    figure.colorbar(image, cax=ax.inset_axes((1.03, 0.0, 0.05, 1.0)), label=label)
    ax.set(xlabel="x in mm", ylabel="y in mm")
    ax.locator_params(nbins=5)


def html(text: str, draw: Callable[[], tuple[Figure, Axes]]) -> str:
    """A picture and a text for notebooks; the text alone where there is no matplotlib, or nothing to draw."""
    words = f"<pre>{escape(text)}</pre>"
    try:
        import matplotlib.pyplot as plt

        figure, _ = draw()
    except Exception:  # an unfinished system has no picture, and its text says what is missing
        return words
    page = io.BytesIO()
    figure.savefig(page, format="png", dpi=80)
    plt.close(figure)
    picture = base64.b64encode(page.getvalue()).decode()
    return f'<img alt="" src="data:image/png;base64,{picture}"/>{words}'


def plot_field(
    field: NDArray[np.complex128],
    axes: tuple[NDArray[np.float64], NDArray[np.float64]],
    what: str,
    title: str,
    ax: Axes | None,
) -> tuple[Figure, Axes]:
    """A field on a sensor."""
    intensity = np.square(field.real) + np.square(field.imag)
    most = float(intensity.max())
    choices: dict[str, tuple[Any, str, dict[str, Any]]] = {
        "intensity": (intensity, "|U|²", {"cmap": "inferno", "vmin": 0.0}),
        "amplitude": (np.sqrt(intensity), "|U|", {"cmap": "inferno", "vmin": 0.0}),
        "log": (
            10.0 * np.log10(np.maximum(intensity / (most or 1.0), 1e-8)),
            "|U|² in dB of its peak",
            {"cmap": "inferno"},
        ),
        "phase": (
            np.where(intensity > _DARK * most, np.angle(field), np.nan),
            "phase in rad",
            {"cmap": "twilight", "vmin": -np.pi, "vmax": np.pi},
        ),
    }
    if what not in choices:
        raise ValueError(f"{shown(what)} cannot be plotted, expected one of {', '.join(choices)}")
    figure, ax = _axes(ax, (5.6, 4.6))
    values, label, how = choices[what]
    _image(figure, ax, values, (*_edges(axes[0]), *_edges(axes[1])), label, **how)
    _entitle(ax, title)
    return figure, ax


def plot_phase(
    values: NDArray[np.complex128], bounds: tuple[float, float, float, float], name: str, ax: Axes | None
) -> tuple[Figure, Axes]:
    """The phase of an element's transmission where it is open."""
    figure, ax = _axes(ax, (5.6, 4.6))
    phase = np.where(values == 0.0, np.nan, np.angle(values))
    _image(figure, ax, phase, bounds, "phase in rad", cmap="twilight", vmin=-np.pi, vmax=np.pi)
    ax.set_title(f"Element '{name}'")
    return figure, ax


_STYLES: dict[str, dict[str, Any]] = {
    "surface": {"color": "0.2", "linewidth": 1.0},
    "mirror": {"color": "0.2", "linewidth": 2.0},
    "doe": {"color": "tab:red", "linewidth": 2.0},
    "stop": {"color": "tab:green", "linewidth": 1.0, "linestyle": ":"},
    "sensor": {"color": "tab:blue", "linewidth": 3.0},
    "screen": {"color": "0.5", "linestyle": "--"},
}


def draw_layout(layout: dict[str, Any], title: str, ax: Axes | None) -> tuple[Figure, Axes]:
    """A section through a system: glass, surfaces, rays and names."""
    figure, ax = _axes(ax, (8.0, 3.6))
    for polygon in layout["glass"]:
        ax.fill(*np.array(polygon).T, color="tab:cyan", alpha=0.18, linewidth=0.0)
    for ray in layout["rays"]:
        points = np.array(ray["points"], dtype=float)
        ax.plot(*points.T, color=("tab:orange", "tab:purple", "tab:olive")[ray["group"] % 3], linewidth=0.8)
    for curve in layout["surfaces"]:
        ax.plot(*np.array(curve["points"]).T, **_STYLES[curve["kind"]])
    ax.set(xlabel="z in mm", ylabel=f"{layout['transverse']} in mm")
    _entitle(ax, title)
    _frame(ax, layout["labels"])
    return figure, ax


#: Size of names, about how wide a letter is, and the height of a line, in points.
_LETTERS, _LETTER, _LINE = 8.0, 5.0, 10.5


def _frame(ax: Any, labels: list[dict[str, Any]]) -> None:
    """Names above their places, and limits with room for them; a millimetre is as long as high, but in long systems."""
    (left, low), (right, high) = ax.dataLim.min, ax.dataLim.max
    box = 72.0 * ax.get_position().size * ax.figure.get_size_inches()
    equal = right - left < 8.0 * (high - low)

    # A name goes into the first line where it stands beside the others.
    length = max(1.1 * (right - left), (high - low) * box[0] / box[1] if equal else 0.0)
    taken: list[float] = []
    for label in sorted(labels, key=lambda label: float(label["at"][0])):
        middle, half = label["at"][0] * box[0] / length, 0.5 * _LETTER * len(label["text"])
        line = next((i for i, end in enumerate(taken) if end < middle - half), len(taken))
        taken[line : line + 1] = [middle + half]
        place = {"xytext": (0.0, 6.0 + _LINE * line), "textcoords": "offset points"}
        ax.annotate(label["text"], label["at"], ha="center", fontsize=_LETTERS, **place)

    # They take a share of the height above; the rest is left around what is drawn.
    share = (6.0 + _LINE * (len(taken) + 0.5)) / box[1]
    height = 1.1 * (high - low) / (1.0 - share)
    if equal:
        ax.set_aspect("equal")
        height = max(height, 1.1 * (right - left) * box[1] / box[0])
        length = max(length, height * box[0] / box[1])
    aside, below = 0.5 * (length - right + left), 0.5 * ((1.0 - share) * height - high + low)
    ax.set(xlim=(left - aside, right + aside), ylim=(low - below, low - below + height))


def _entitle(ax: Any, title: str) -> None:
    """A title in lines that fit."""
    width = ax.get_position().width * ax.figure.get_size_inches()[0]
    ax.set_title("\n".join(textwrap.wrap(title, max(12, int(10.0 * width)))))


def plot_course(losses: NDArray[np.float64], title: str, ax: Axes | None) -> tuple[Figure, Axes]:
    """The loss of a design at its start and after each iteration."""
    figure, ax = _axes(ax, (5.6, 3.6))
    ax.plot(losses)
    ax.locator_params(axis="x", integer=True)
    ax.set(xlabel="iteration", ylabel="loss")
    _entitle(ax, title)
    return figure, ax
