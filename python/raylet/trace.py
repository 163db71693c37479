"""Single rays through a system."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from raylet import _raylet
from raylet._arrays import real
from raylet._calls import parameter_paths, told_of_system
from raylet._refusal import RayletError, described, shown

if TYPE_CHECKING:
    from raylet.system import System

Real = NDArray[np.float64]

#: A part of a system by its name or index.
Part = str | int

#: What became of a ray.
FATES = ("arrived", "clipped", "missed", "total reflection", "evanescent", "not converged")


#: How far the length of a direction may be from one.
NOT_UNIT = 1e-6


@dataclass(frozen=True, eq=False)
class RayStart:
    """The system as rays went through it, and how they started."""

    system: System
    starts: dict[str, Any]
    channel: int
    threads: int | None


@dataclass(frozen=True, eq=False)
class Rays:
    """Rays at the parts of a system; the last part is the sensor. What a lost ray did not reach is NaN.

    Attributes
    ----------
    names : names of the recorded parts.
    x, y, z : where each part is met, (parts, rays), global, in mm.
    L, M, N : direction cosines behind it, global.
    opl_mm : optical path up to it, from where the source's phase is zero; of rays with a start of their own from there.
    fate : for each ray one of :data:`FATES`, as an index.
    derivatives : for each requested number, arrays (5, rays): derivatives of x and y (mm) and the optical direction
        cosines on the sensor's axes, and of the optical path (mm).
    """

    names: list[str]
    x: Real
    y: Real
    z: Real
    L: Real
    M: Real
    N: Real
    opl_mm: Real
    fate: NDArray[np.uint8]
    derivatives: dict[str, Real]
    _start: RayStart

    @property
    def arrived(self) -> NDArray[np.bool_]:
        """Which rays reached the sensor."""
        return np.asarray(self.fate == 0)

    def adjoint(
        self,
        parameters: str | Sequence[str],
        *,
        x: Any = 0.0,
        y: Any = 0.0,
        L: Any = 0.0,
        M: Any = 0.0,
        opl_mm: Any = 0.0,
    ) -> Real:
        """The gradient of a real loss by parameters of the system, from its derivatives by where these rays land.

        Rays go there and back once for all parameters, and are not kept at surfaces. Through surfaces, mirrors and
        stops only.

        Parameters
        ----------
        parameters : paths such as "element[0].radius_mm"; of a radius the gradient is by its curvature.
        x, y, L, M, opl_mm : derivatives of the loss by each ray's place (per mm) and optical direction cosines on the
            sensor's axes, and by its optical path (per mm): (rays,), or one number for all. Those of lost rays do not
            count.

        Returns
        -------
        One number for each parameter.

        Examples
        --------
        The mean square of the distances of rays from the axis, and its gradient by a curvature:

        >>> import numpy as np, raylet
        >>> system = raylet.System(wavelength_um=0.55)
        >>> system = system.add_surface(radius_mm=50.0, thickness_mm=4.0, glass=1.5, semi_aperture_mm=5.0)
        >>> system = system.add_surface(semi_aperture_mm=5.0, thickness_mm=90.0)
        >>> system = system.add_sensor(pixels=(8, 8), pitch_um=10.0)
        >>> rays = system.trace(Px=np.linspace(-1.0, 1.0, 11), parts=-1)
        >>> gradient = rays.adjoint("element[0].radius_mm", x=2.0 * rays.x[0] / 11, y=2.0 * rays.y[0] / 11)
        >>> gradient.shape
        (1,)
        """
        paths = parameter_paths("Rays.adjoint", "parameters", parameters)
        rows = {"x": x, "y": y, "L": L, "M": M, "opl_mm": opl_mm}
        by_landings = [self._by_rays(name, value) for name, value in rows.items()]
        start = self._start
        # A copy is compiled, so that rays can be pickled afterwards too.
        scene, arrays = start.system._copy()._compiled(), start.system._arrays
        try:
            found = _raylet.trace_adjoint(scene, arrays, start.channel, start.starts, by_landings, paths, start.threads)
        except RayletError as error:
            told_of_system(error, "Rays.adjoint", start.system, {"parameters": paths})
            raise
        return np.array(found, dtype=np.float64)

    def _by_rays(self, name: str, value: Any) -> Real | None:
        """Derivatives by each ray; None for zero."""
        given, shape = real(name, value), self.fate.shape
        if given.shape not in ((), shape):
            raise ValueError(f"{name} has shape {given.shape}, expected {shape}, or one number")
        if given.ndim == 0 and given == 0.0:
            return None
        each = np.broadcast_to(given, shape)
        if not np.isfinite(each).all() and not np.isfinite(each[self.arrived]).all():
            raise ValueError(f"{name} holds numbers that are not finite for rays that arrived")
        return each

    @described
    def __repr__(self) -> str:
        count = [f"{int(np.sum(self.fate == i))} {fate}" for i, fate in enumerate(FATES) if np.any(self.fate == i)]
        return f"<raylet.Rays: {', '.join(count) or 'none'}; at {len(self.names)} parts: {', '.join(self.names)}>"


def trace(
    system: System,
    source: dict[str, Any],
    coordinates: tuple[Any, Any, Any, Any],
    scale: tuple[float | None, float | None],
    channel: int,
    parts: Part | Sequence[Part] | None,
    parameters: Sequence[str],
    threads: int | None,
) -> Rays:
    """Rays of normalised field and pupil coordinates."""
    given = [real(name, value) for name, value in zip(("Hx", "Hy", "Px", "Py"), coordinates)]
    if not all(np.isfinite(value).all() for value in given):
        raise ValueError("Hx, Hy, Px, Py hold numbers that are not finite")
    try:
        shape = np.broadcast_shapes(*(value.shape for value in given))
    except ValueError as error:
        shapes = ", ".join(str(value.shape) for value in given)
        raise ValueError(f"Hx, Hy, Px, Py have shapes {shapes}, expected such as go together") from error
    # One direction of light serves all rays: millions of them need no arrays of their own.
    one = given[0].size == given[1].size == 1
    Hx, Hy = (value.reshape(1) if one else np.broadcast_to(value, shape).ravel() for value in given[:2])
    Px, Py = (np.broadcast_to(value, shape).ravel() for value in given[2:])
    starts = {"x": Px, "y": Py, "light": _light(source, Hx, Hy, scale)}
    return _followed(system, starts, channel, parts, parameters, threads)


def trace_from(
    system: System,
    start_mm: Any,
    cosines: Any,
    channel: int,
    parts: Part | Sequence[Part] | None,
    parameters: Sequence[str],
    threads: int | None,
) -> Rays:
    """Rays from points in mm with direction cosines."""
    given = {"start_mm": real("start_mm", start_mm), "cosines": real("cosines", cosines)}
    rows = {name: np.atleast_2d(value) for name, value in given.items()}
    for name, value in rows.items():
        if value.ndim != 2 or value.shape[1] != 3:
            raise ValueError(f"{name} has shape {given[name].shape}, expected (rays, 3)")
        if not np.isfinite(value).all():
            raise ValueError(f"{name} holds numbers that are not finite")
    if 1 not in (len(rows["start_mm"]), len(rows["cosines"])) and len(rows["start_mm"]) != len(rows["cosines"]):
        raise ValueError(
            f"{len(rows['start_mm'])} start_mm for {len(rows['cosines'])} cosines, expected as many, or one"
        )
    directions = rows["cosines"]
    lengths = np.sqrt(np.sum(directions * directions, axis=1))
    if np.any(np.abs(lengths - 1.0) > NOT_UNIT):
        worst = lengths[np.argmax(np.abs(lengths - 1.0))]
        raise ValueError(f"cosines hold a direction of length {worst:.6g}, expected 1: L² + M² + N² = 1")
    starts = {"start_mm": rows["start_mm"], "cosines": directions / lengths[:, np.newaxis]}
    return _followed(system, starts, channel, parts, parameters, threads)


def _followed(
    system: System,
    starts: dict[str, Any],
    channel: int,
    parts: Part | Sequence[Part] | None,
    parameters: Sequence[str],
    threads: int | None,
) -> Rays:
    """The rays of these starts, at some parts of the system or at all."""
    names = [part["name"] for part in system.parts]
    chosen = _numbers(names, parts)
    # A large array of NumPy has large pages of memory, which are there much sooner.
    numbers = np.empty((7, len(chosen), _count(starts)))
    scene = system._compiled()
    fate, slopes = _raylet.trace(scene, system._arrays, channel, starts, chosen, numbers, list(parameters), threads)
    x, y, z, L, M, N, paths = numbers
    recorded = [names[number] for number in chosen]
    start = RayStart(system._copy(), starts, channel, threads)
    return Rays(recorded, x, y, z, L, M, N, paths, fate, dict(zip(parameters, slopes)), start)


def _count(starts: dict[str, Any]) -> int:
    """How many rays there are."""
    if "x" in starts:
        return len(starts["x"])
    counts = [len(starts["start_mm"]), len(starts["cosines"])]
    return max(counts) if min(counts) > 0 else 0


def _numbers(names: list[str], parts: Part | Sequence[Part] | None) -> list[int]:
    """The numbers of parts by their names or indices; of all of them if these are None."""
    if parts is None:
        return list(range(len(names)))
    numbers = []
    for part in [parts] if isinstance(parts, (str, int)) else parts:
        if isinstance(part, str) and part in names:
            numbers += [number for number, name in enumerate(names) if name == part]
        elif isinstance(part, int) and not isinstance(part, bool) and -len(names) <= part < len(names):
            numbers.append(part % len(names))
        else:
            expected = f"an index below {len(names)}, or one of {', '.join(names)}"
            raise ValueError(f"System.trace: parts holds {shown(part)}, expected {expected}")
    return numbers


def _light(source: dict[str, Any], Hx: Real, Hy: Real, scale: tuple[float | None, float | None]) -> Real:
    """Directions of collimated light, or places of a point source, one for each ray."""
    moved = bool(np.any(Hx) or np.any(Hy))
    if source["kind"] == "gaussian":
        if moved:
            raise ValueError("Hx, Hy are not zero, expected zero for a Gaussian beam, whose direction is fixed")
        return np.zeros((Hx.size, 3))
    if source["kind"] in ("field", "fibre"):
        raise ValueError(
            f'the source is of kind "{source["kind"]}", expected collimated light, a point or a Gaussian beam: '
            "a field on a plane has no single ray at a place"
        )
    size = scale[0] if source["kind"] == "plane" else scale[1]
    if moved and size is None:
        name = "field_deg" if source["kind"] == "plane" else "field_mm"
        raise ValueError(f"System.trace: Hx, Hy need a scale, expected {name}")
    size = size or 0.0
    if source["kind"] == "point":
        px, py, pz = source["position_mm"]
        return np.stack([px + size * Hx, py + size * Hy, np.full(Hx.shape, pz)], axis=1)
    ax, ay = source["angle_deg"]
    cx, cy = np.sin(np.radians(ax + size * Hx)), np.sin(np.radians(ay + size * Hy))
    under = 1.0 - cx * cx - cy * cy
    if np.any(under <= 0.0):
        raise ValueError("field angles whose sines' squares add up to one or more, expected less")
    return np.stack([cx, cy, np.sqrt(under)], axis=1)
