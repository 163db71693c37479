"""What a simulation gives."""

from __future__ import annotations

import json
import os
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from raylet._document import npz, write
from raylet._refusal import MOST_WAVES, described

if TYPE_CHECKING:
    import xarray
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


class Result:
    """The complex field on the sensor, with where it is, how it was computed, and its estimated error.

    Attributes
    ----------
    x_mm, y_mm : pixel centres in the sensor's own plane, ascending.
    wavelength_um : vacuum wavelengths.
    standard_error : float64 arrays [y, x] for each wavelength where rays were drawn at random (method "paper").
    report : everything that is known of the run; keys as in docs/result.md.
    """

    def __init__(
        self,
        fields: list[NDArray[np.complex128]],
        axes: tuple[NDArray[np.float64], NDArray[np.float64]],
        report: dict[str, Any],
        *,
        several: bool,
        standard_error: list[NDArray[np.float64] | None],
        title: str = "",
    ) -> None:
        self._fields, self._several = fields, several
        self._stack: NDArray[np.complex128] | None = None
        self.x_mm, self.y_mm = axes
        self.report, self.standard_error, self.title = report, standard_error, title
        self.wavelength_um = [float(channel["wavelength_um"]) for channel in report["channels"]]

    @classmethod
    def _of(cls, answer: Any, *, several: bool, title: str) -> Result:
        fields, x, y, noise, report = answer
        return cls(fields, (x, y), json.loads(report), several=several, standard_error=noise, title=title)

    @property
    def fields(self) -> list[NDArray[np.complex128]]:
        """The field [y, x] of each wavelength, in the memory in which it was computed."""
        return self._fields

    @property
    def field(self) -> NDArray[np.complex128]:
        """Complex amplitude at the pixel centres, exp(+ikz), 1 at the source: [y, x] for one wavelength, [wavelength,
        y, x] where a list of wavelengths was given."""
        if not self._several:
            return self._fields[0]
        if self._stack is None:
            self._stack = np.stack(self._fields)
        return self._stack

    @property
    def intensity(self) -> NDArray[np.float64]:
        """|U|², indexed like :attr:`field`."""
        field = self.field
        return np.square(field.real) + np.square(field.imag)

    @property
    def phase(self) -> NDArray[np.float64]:
        """The argument of the field in rad."""
        return np.asarray(np.angle(self.field))

    @property
    def error(self) -> float | None:
        """Expected relative L2 error of the complex field, the largest of all wavelengths; None where a method does
        not estimate it."""
        errors = [channel["error"] for channel in self.report["channels"]]
        return None if None in errors else float(max(errors))

    @property
    def hops(self) -> list[dict[str, Any]]:
        """How the light was carried from screen to screen, of all wavelengths one after the other."""
        return [hop for channel in self.report["channels"] for hop in channel["hops"]]

    @property
    def tally(self) -> dict[str, int]:
        """Rays by fate, of all hops and wavelengths together."""
        total: dict[str, int] = {}
        for hop in self.hops:
            for fate, count in hop["rays"].items():
                total[fate] = total.get(fate, 0) + count
        return total

    @property
    def methods(self) -> list[str]:
        """The method of each hop."""
        return [hop["plan"]["method"] for hop in self.hops]

    @property
    def power_share(self) -> list[float | None]:
        """For each wavelength the share of the light behind the first element that the sensor receives; None for an
        element without an edge."""
        return [channel["light_share"] for channel in self.report["channels"]]

    @property
    def table(self) -> list[dict[str, Any]]:
        """One row for each wavelength: expected error, its target and whether that is reached, share of the light on
        the sensor, peak and its place, full widths at half of it, radii about the centroid that hold 50 % and 80 % of
        the light on the sensor, methods, and seconds. None where there is no such number."""
        target = self.report["settings"]["target_error"]
        return [_row(channel, target) for channel in self.report["channels"]]

    @property
    def warnings(self) -> list[str]:
        """What a user must know of this result, such as an expected error above the target; empty where all is well."""
        return [
            f"λ = {channel['wavelength_um']:g} µm: {warning}"
            for channel in self.report["channels"]
            for warning in channel.get("warnings", [])
        ]

    @property
    def seconds(self) -> float:
        """How long it took."""
        return float(self.report["seconds"])

    def plot(
        self, what: str | None = None, ax: Axes | None = None, *, channel: int | None = None
    ) -> tuple[Figure, Any]:
        """The picture `sensor.png` of `raylet simulate`, or one panel of it.

        Without `what` and `ax`: intensity, its logarithm and phase, a row for each of up to three wavelengths (of more,
        their sum and the first); the axes are an array [row, column]. `channel` chooses one wavelength.

        With `what` ("intensity", "log", "amplitude" or "phase") or `ax` it is one panel: the intensity of the first
        wavelength unless these say otherwise. Axes have mm, and are labelled in the unit that fits.
        """
        from raylet.plotting import plot_field, plot_sensor

        count = len(self._fields)
        if channel is not None and not 0 <= channel < count:
            raise IndexError(f"channel is {channel}, expected from 0 to {count - 1}")
        shown = (
            slice(None) if channel is None and what is None and ax is None else slice(channel or 0, (channel or 0) + 1)
        )
        fields, waves, axes = self._fields[shown], self.wavelength_um[shown], (self.x_mm, self.y_mm)
        wave = f"λ = {waves[0]:g} µm" if len(fields) == 1 < count else ""
        title = ", ".join(filter(None, (self.title, wave)))
        if what is None and ax is None:
            return plot_sensor(fields, axes, waves, title)
        return plot_field(fields[0], axes, what or "intensity", title, ax)

    def save(self, path: str | os.PathLike[str], *, overwrite: bool = False) -> None:
        """Writes field [wavelength, y, x], x_mm, y_mm and wavelength_um to a .npz file, as `raylet simulate` does.

        The file appears whole or not at all. One that raylet did not write, or that was changed since, is refused
        unless `overwrite` is true.
        """
        waves = np.array(self.wavelength_um)
        content = npz(field=np.stack(self._fields), x_mm=self.x_mm, y_mm=self.y_mm, wavelength_um=waves)
        write({path: content}, overwrite=overwrite)

    def to_xarray(self) -> xarray.Dataset:
        """The field as an `xarray.Dataset`: `field` with the coordinates `wavelength_um`, `y_mm` and `x_mm`, units in
        the attributes. It needs the package xarray."""
        from raylet.exchange.labelled import dataset

        return dataset(np.stack(self._fields), self.x_mm, self.y_mm, np.array(self.wavelength_um))

    def _repr_html_(self) -> str:
        from raylet.plotting import html

        return html(repr(self), self.plot)

    @described
    def __repr__(self) -> str:
        ny, nx = self._fields[0].shape
        pitch = 1e3 * (self.x_mm[1] - self.x_mm[0]) if nx > 1 else 0.0
        lines = [f"<raylet.Result {nx} x {ny} pixels of {pitch:.4g} µm, {self.seconds:.2f} s>"]
        channels = self.report["channels"]
        for channel, share in zip(channels[:MOST_WAVES], self.power_share):
            estimate = _estimate(channel["error"], self.report["settings"]["target_error"])
            light = _light(share, channel["metrics"]["power"])
            lines.append(f"  λ = {channel['wavelength_um']:g} µm: {light}{estimate}")
            lines += [f"    {line}" for hop in channel["hops"] for line in _hop_lines(hop)]
        if len(channels) > MOST_WAVES:
            lines.append(f"  … ({len(channels)} wavelengths)")
        lines += [f"  warning: {warning}" for warning in self.warnings[:MOST_WAVES]]
        return "\n".join(lines)


#: Estimates and sums over pixels are no more exact than these: an error that is above the target by less is not marked,
#: and a share of the light above one by less is all of the light.
NEAR, SUM = 1.1, 1e-3


def _row(channel: dict[str, Any], target_error: float) -> dict[str, Any]:
    """A wavelength's row of the table, with the columns of `table.csv` (docs/result.md)."""
    metrics = channel["metrics"]
    steps = [hop["plan"]["method"] for hop in channel["hops"]]
    peak, radii = (metrics[key] or [None, None] for key in ("peak_mm", "encircled_um"))
    return {
        "wavelength_um": channel["wavelength_um"],
        "error": channel["error"],
        "target_error": target_error,
        "target_reached": channel["target_reached"],
        "light_share": channel["light_share"],
        "peak": metrics["peak"],
        "peak_x_mm": peak[0],
        "peak_y_mm": peak[1],
        "fwhm_x_um": metrics["fwhm_um"][0],
        "fwhm_y_um": metrics["fwhm_um"][1],
        "radius_50_um": radii[0],
        "radius_80_um": radii[1],
        "method": " ".join(dict.fromkeys(steps)),
        "seconds": channel["seconds"],
    }


def above_target(error: float, target: float) -> str:
    """The mark of an expected error that misses the target; empty for others."""
    return f" (above the target {target:.0e})" if error > NEAR * target else ""


def light_share(share: float) -> str:
    """A share of the light. More than all of it is an error of the method, and no share."""
    return "more than came" if share > 1.0 + SUM else f"{min(share, 1.0):.2%}"


def _estimate(error: float | None, target: float) -> str:
    """An expected error in words, marked where it misses the target."""
    return "" if error is None else f", expected field error {error:.1e}{above_target(error, target)}"


def _light(share: float | None, power: float) -> str:
    """The light on the sensor in words."""
    if share is None:
        return f"{power:.4e} mm² of the light on the sensor"
    if share > 1.0 + SUM:
        return "more light on the sensor than came"
    return f"{light_share(share)} of the light on the sensor"


def _hop_lines(hop: dict[str, Any]) -> list[str]:
    plan, counts = hop["plan"], hop["rays"]
    rays = ", ".join(f"{count} {fate}" for fate, count in counts.items() if count)
    lines = [f"{plan['from']} to {plan['to']}: {plan['method']} ({plan['why']})" + (f"; rays: {rays}" if rays else "")]
    warnings = [rim["warning"] for rim in hop.get("rims", []) if rim.get("warning")]
    return lines + [f"  warning: {warning}" for warning in warnings]
