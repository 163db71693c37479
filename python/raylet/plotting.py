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
    values, label, how = choices[what]
    if 1 in field.shape and field.size > 1:
        return _curve(values, axes, label, title, ax)
    figure, ax = _axes(ax, (5.6, 4.6))
    _image(figure, ax, values, (*_edges(axes[0]), *_edges(axes[1])), label, **how)
    _entitle(ax, title)
    return figure, ax


def _curve(
    values: NDArray[np.float64],
    axes: tuple[NDArray[np.float64], NDArray[np.float64]],
    label: str,
    title: str,
    ax: Axes | None,
) -> tuple[Figure, Axes]:
    """A single row or column of pixels, of which an image would be too thin to see."""
    figure, ax = _axes(ax, (8.0, 3.0))
    along = 0 if values.shape[0] == 1 else 1
    ax.plot(axes[along], values.ravel())
    ax.set(xlabel=f"{'xy'[along]} in mm", ylabel=label)
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
    rays = [np.array(ray["points"], dtype=float) for ray in layout["rays"]]
    glass = [[*points, points[0]] for points in layout["glass"]]
    outlines = [np.array(points) for points in (*glass, *(curve["points"] for curve in layout["surfaces"]))]
    everything = np.concatenate(
        [*rays, *outlines, np.array([label["at"] for label in layout["labels"]]).reshape(-1, 2)]
    )
    wide, high = np.maximum(np.ptp(everything, axis=0), 1e-9)

    # A high section, as of a folded system, has a high figure, and rays close to each other are thin.
    figure, ax = _axes(ax, (8.0, 3.6) if wide > 1.3 * high else (max(3.6, 6.0 * wide / high + 1.2), 6.5))
    for polygon in layout["glass"]:
        ax.fill(*np.array(polygon).T, color="tab:cyan", alpha=0.18, linewidth=0.0)
    width = _ray_width(rays, min(500.0 / wide, 200.0 / high if wide > 1.3 * high else 400.0 / high))
    for ray, points in zip(layout["rays"], rays):
        ax.plot(*points.T, color=_COLOURS[ray["group"] % len(_COLOURS)], linewidth=width)
    for curve in layout["surfaces"]:
        ax.plot(*np.array(curve["points"]).T, **_STYLES[curve["kind"]])
    ax.set(xlabel="z in mm", ylabel=f"{layout['transverse']} in mm")
    _entitle(ax, title)
    _frame(ax, layout["labels"], outlines)
    if layout["ray_groups"]:
        lines = [ax.plot([], [], color=_COLOURS[i % len(_COLOURS)])[0] for i in range(len(layout["ray_groups"]))]
        ax.legend(lines, layout["ray_groups"], fontsize=7.0, loc="lower left", handlelength=1.2)
    return figure, ax


#: Colours of fields, or of how elements turned rays.
_COLOURS = ("tab:orange", "tab:purple", "tab:olive", "tab:pink", "tab:brown", "tab:gray")


def _ray_width(rays: list[NDArray[np.float64]], scale: float) -> float:
    """The width of rays in points, where a millimetre has so many: less for those that are close to each other."""
    starts = np.array([ray[0] for ray in rays if len(ray)]).reshape(-1, 2)
    gaps = scale * np.hypot(*np.diff(starts, axis=0).T)
    return float(np.clip(0.25 * np.min(gaps[gaps > 1e-6], initial=4.0), 0.3, 0.8))


#: Size of names, about how wide a letter is, and the height of a line, in points.
_LETTERS, _LETTER, _LINE = 8.0, 5.0, 10.5


def _frame(ax: Any, labels: list[dict[str, Any]], outlines: list[NDArray[np.float64]]) -> None:
    """Names above their places, and limits with room for them; a millimetre is as long as high, but in long systems."""
    (left, low), (right, high) = ax.dataLim.min, ax.dataLim.max
    box = 72.0 * ax.get_position().size * ax.figure.get_size_inches()
    equal = right - left < 8.0 * (high - low)
    named = _merged(labels)
    drawn = np.concatenate([_filled(points) for points in outlines] or [np.zeros((0, 2))])

    # Names take a share of the height, which changes the scale, and this the places of names: a few rounds.
    share = 0.0
    for _ in range(4):
        height = 1.1 * (high - low) / (1.0 - share)
        length = 1.1 * (right - left)
        if equal:
            height = max(height, length * box[1] / box[0])
            length = height * box[0] / box[1]
        scale = box / (length, height)
        lifts, top = _lifts(named, scale, drawn)
        share = min(0.7, max(0.0, (top - high * scale[1]) / box[1]))
    for label, lift in zip(named, lifts):
        place: dict[str, Any] = {"xytext": (0.0, lift), "textcoords": "offset points"}
        if lift > 2.0 * _LINE:
            place["arrowprops"] = {"arrowstyle": "-", "linewidth": 0.5, "color": "0.6", "shrinkA": 0.0, "shrinkB": 2.0}
        veil = {"facecolor": "white", "alpha": 0.7, "linewidth": 0.0, "pad": 0.5}
        ax.annotate(label["text"], label["at"], ha="center", fontsize=_LETTERS, bbox=veil, **place)

    # The rest of the height is left around what is drawn.
    if equal:
        ax.set_aspect("equal")
    aside, below = 0.5 * (length - right + left), 0.5 * ((1.0 - share) * height - high + low)
    ax.set(xlim=(left - aside, right + aside), ylim=(low - below, low - below + height))


def _merged(labels: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """Labels along the axis; neighbours of one name share a label above the highest of them."""
    runs: list[list[dict[str, Any]]] = []
    for label in sorted(labels, key=lambda label: float(label["at"][0])):
        if runs and runs[-1][0]["text"] == label["text"]:
            runs[-1].append(label)
        else:
            runs.append([label])
    merged = []
    for run in runs:
        text = run[0]["text"] if len(run) == 1 else f"{len(run)} × {run[0]['text']}"
        places = np.array([label["at"] for label in run], dtype=float)
        merged.append({"text": text, "at": (float(places[:, 0].mean()), float(places[:, 1].max()))})
    return merged


def _filled(points: NDArray[np.float64]) -> NDArray[np.float64]:
    """A line with points between its corners."""
    steps = np.linspace(0.0, 1.0, 16, endpoint=False)[:, None, None]
    between = points[:-1] + steps * np.diff(points, axis=0)
    return np.concatenate([between.reshape(-1, 2), points[-1:]])


def _lifts(
    labels: list[dict[str, Any]], scale: NDArray[np.float64], drawn: NDArray[np.float64]
) -> tuple[list[float], float]:
    """How far above its place each name touches no other and nothing drawn, and the top of all, in points."""
    placed: list[tuple[float, float, float]] = []
    lifts = []
    dots = drawn * scale
    for label in labels:
        (x, y), half = np.array(label["at"]) * scale, 0.5 * _LETTER * len(label["text"])

        # Above the highest of the parts below the name, unless that is another arm of a folded system.
        below = dots[np.abs(dots[:, 0] - x) < half + 2.0, 1]
        near = below[below < y + 15.0 * _LINE]
        height = max(y, float(near.max(initial=y))) + 6.0
        while any(abs(x - other) < half + width and abs(height - taken) < _LINE for other, taken, width in placed):
            height += _LINE
        placed.append((float(x), height, half))
        lifts.append(float(height - y))
    return lifts, max((height + 1.5 * _LINE for _, height, _ in placed), default=0.0)


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
