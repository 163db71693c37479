"""Pictures with matplotlib, of what `raylet simulate` shows; every function returns (figure, axes)."""

from __future__ import annotations

import base64
import io
import json
import textwrap
from collections.abc import Callable, Sequence
from html import escape
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from raylet import _raylet
from raylet._refusal import shown

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


def _axes(ax: Axes | None, size: tuple[float, float]) -> tuple[Any, Any]:
    if ax is not None:
        return ax.figure, ax
    try:
        import matplotlib.pyplot as plt
    except ImportError as error:
        raise ImportError("pictures need matplotlib: pip install matplotlib") from error
    return plt.subplots(figsize=size, layout="constrained")


def _image(figure: Any, ax: Any, values: Any, extent: Any, label: str, **how: Any) -> None:
    """Values as colours over an extent in mm, with a colour bar and few ticks."""
    # What is dark has no phase: grey, which no phase is.
    ax.set_facecolor("0.75")
    across, up = (abs(extent[1] - extent[0]), abs(extent[3] - extent[2]) * how.get("aspect", 1.0))
    image = ax.imshow(values, extent=extent, origin="lower", interpolation="nearest", **how)

    # The size in inches that the picture will have; its bar is as high, or higher than a thin strip.
    room = ax.get_position().size * figure.get_size_inches()
    size = np.array([across, up]) * min(room[0] / across, room[1] / up)
    high = max(1.0, 0.9 / size[1])
    gap = 0.1 if high == 1.0 else 0.25
    bar = ax.inset_axes((1.0 + gap / size[0], 0.5 - 0.5 * high, 0.12 / size[0], high))
    figure.colorbar(image, cax=bar, label=label)
    for axis, length in ((ax.xaxis, size[0] / 0.6), (ax.yaxis, size[1] / 0.3)):
        axis.get_major_locator().set_params(nbins=int(min(5, max(1, length))), min_n_ticks=1)
    ax.set(xlabel="x in mm", ylabel="y in mm")


def _in_unit(axis: Any, name: str, plan: dict[str, Any]) -> None:
    """Labels an axis, whose values are in mm, in the unit of the picture."""
    axis.set_major_formatter(lambda value, _: f"{round(value * plan['per_mm'], 9):g}")
    axis.set_label_text(f"{name} in {plan['unit']}")


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


#: What the centres of a sensor's pixels are called here: x and y in mm.
_Centres = tuple[NDArray[np.float64], NDArray[np.float64]]


def sensor_panels(axes: _Centres, wavelengths_um: Sequence[float]) -> dict[str, Any]:
    """What `raylet simulate` shows of these wavelengths on a sensor: rows of panels, their unit and their stretch."""
    names = [f"λ = {wave:.12g} µm" for wave in wavelengths_um]
    plan: dict[str, Any] = json.loads(_raylet.sensor_panels(axes[0].tolist(), axes[1].tolist(), names))
    return plan


def plot_sensor(
    fields: Sequence[NDArray[np.complex128]],
    axes: _Centres,
    wavelengths_um: Sequence[float],
    title: str,
) -> tuple[Figure, Any]:
    """The light on a sensor in the panels of `raylet simulate`; the axes are an array [row, column]."""
    plan = sensor_panels(axes, wavelengths_um)
    rows, aspect = plan["rows"], _aspect(plan)

    # Rows as high as their pictures, in columns as wide.
    high = 2.4 if plan["line"] is not None else float(np.clip(2.7 / aspect, 0.9, 3.4))
    wide = float(np.clip(high * aspect, 1.2, 2.9)) + 1.5
    columns = max(len(row["panels"]) for row in rows)
    figure, grid = _subplots(len(rows), columns, (columns * wide, len(rows) * (high + 1.1) + 0.4))
    for row, line in zip(rows, grid):
        channel = row["channel"]
        field = fields[channel] if channel is not None else None
        intensity = sum(map(_intensity, fields)) if field is None else _intensity(field)
        for ax, (what, name) in zip(line, row["panels"]):
            _panel(figure, ax, what, (intensity, field), axes, plan)
            ax.set_title("\n".join(filter(None, (name, row["note"], _stretched(plan)))), fontsize="medium")
        for ax in line[len(row["panels"]) :]:
            ax.remove()
    if title:
        figure.suptitle("\n".join(textwrap.wrap(title, max(12, int(8.0 * columns * wide)))))
    return figure, grid


def plot_field(
    field: NDArray[np.complex128],
    axes: _Centres,
    what: str,
    title: str,
    ax: Axes | None,
) -> tuple[Figure, Axes]:
    """One panel of a field on a sensor."""
    if what not in _QUANTITIES:
        raise ValueError(f"{shown(what)} cannot be plotted, expected one of {', '.join(_QUANTITIES)}")
    plan = sensor_panels(axes, [0.0])
    size = (8.0, 3.0) if plan["line"] is not None else (5.6, float(np.clip(3.9 / _aspect(plan) + 1.2, 2.2, 4.6)))
    figure, ax = _axes(ax, size)
    _panel(figure, ax, what, (_intensity(field), field), axes, plan)
    _entitle(ax, ", ".join(filter(None, (title, _stretched(plan)))))
    return figure, ax


def _subplots(rows: int, columns: int, size: tuple[float, float]) -> tuple[Any, Any]:
    try:
        import matplotlib.pyplot as plt
    except ImportError as error:
        raise ImportError("pictures need matplotlib: pip install matplotlib") from error
    return plt.subplots(rows, columns, figsize=size, layout="constrained", squeeze=False)


def _intensity(field: NDArray[np.complex128]) -> NDArray[np.float64]:
    return np.square(field.real) + np.square(field.imag)


def _aspect(plan: dict[str, Any]) -> float:
    """Width over height of a picture as it is shown."""
    (x0, x1), (y0, y1) = plan["ranges_mm"]
    across, up = plan["stretch"]
    return float((x1 - x0) * across / ((y1 - y0) * up))


def _stretched(plan: dict[str, Any]) -> str:
    """Words for the stretch of a picture; a curve has none."""
    factors = [f"{name} stretched ×{factor:g}" for name, factor in zip("xy", plan["stretch"]) if factor > 1.0]
    return "" if plan["line"] is not None else ", ".join(factors)


#: What can be shown of a field, with the names of the values.
_QUANTITIES = {"intensity": "|U|²", "amplitude": "|U|", "log": "|U|² / maximum", "phase": "phase in rad"}


def _panel(figure: Any, ax: Any, what: str, light: Any, axes: _Centres, plan: dict[str, Any]) -> None:
    """A quantity of light, given by its intensity and its field: colours, or a curve for a single line of pixels."""
    from matplotlib.colors import LogNorm

    intensity, field = light
    most, lowest = float(intensity.max()), 10.0 ** -plan["decades"]
    how: dict[str, Any] = {"cmap": "inferno", "vmin": 0.0}
    values = intensity
    if what == "amplitude":
        values = np.sqrt(intensity)
    elif what == "log":
        values, how = intensity / (most or 1.0), {"cmap": "inferno", "norm": LogNorm(lowest, 1.0)}
    elif what == "phase":
        values = np.where(intensity > plan["phase_floor"] * most, np.angle(field), np.nan)
        how = {"cmap": "twilight", "vmin": -np.pi, "vmax": np.pi}

    # An image of a single line would be too thin to see.
    along = plan["line"]
    if along is not None:
        ax.plot(axes[along], values.ravel())
        ax.set(ylabel=_QUANTITIES[what], yscale="log" if what == "log" else "linear")
        if what == "log":
            ax.set_ylim(lowest, 1.5)
        _in_unit(ax.xaxis, "xy"[along], plan)
        return
    if what == "log":
        values = np.maximum(values, lowest)
    extent = [edge for ends in plan["ranges_mm"] for edge in ends]
    across, up = plan["stretch"]
    _image(figure, ax, values, extent, _QUANTITIES[what], aspect=up / across, **how)
    _in_unit(ax.xaxis, "x", plan)
    _in_unit(ax.yaxis, "y", plan)


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
    named = sorted(labels, key=lambda label: float(label["at"][0]))
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
