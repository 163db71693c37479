"""Pictures with matplotlib; every function returns (figure, axes)."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

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
    image = ax.imshow(values, extent=extent, origin="lower", interpolation="nearest", **how)
    # As high as the picture, whose own shape the axes have.
    figure.colorbar(image, cax=ax.inset_axes((1.03, 0.0, 0.05, 1.0)), label=label)
    ax.set(xlabel="x in mm", ylabel="y in mm")
    ax.locator_params(nbins=5)


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
        raise ValueError(f"{what!r} cannot be plotted, expected one of {', '.join(choices)}")
    figure, ax = _axes(ax, (5.6, 4.6))
    values, label, how = choices[what]
    _image(figure, ax, values, (*_edges(axes[0]), *_edges(axes[1])), label, **how)
    ax.set_title(title)
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
    for label in layout["labels"]:
        ax.annotate(label["text"], label["at"], xytext=(0, 6), textcoords="offset points", ha="center", fontsize=8)
    ax.set(xlabel="z in mm", ylabel=f"{layout['transverse']} in mm", title=title)
    if _proportion(ax) < 8.0:
        ax.set_aspect("equal", adjustable="datalim")
    ax.margins(y=0.15)
    return figure, ax


def _proportion(ax: Any) -> float:
    """Length over height of what is drawn."""
    (left, right), (low, high) = ax.get_xlim(), ax.get_ylim()
    return float((right - left) / max(high - low, 1e-12))


def plot_course(losses: NDArray[np.float64], title: str, ax: Axes | None) -> tuple[Figure, Axes]:
    """The loss of a design at its start and after each iteration."""
    figure, ax = _axes(ax, (5.6, 3.6))
    ax.plot(losses)
    ax.set(xlabel="iteration", ylabel="loss", title=title)
    return figure, ax
