"""What the adapters to other ray tracers share: a lens of another tracer with a raylet element and a raylet sensor.

The other tracer follows every ray, before and behind the element; raylet splits rays at the element and sums what
arrives. An adapter gives the places of element and sensor and two steps, :meth:`Hybrid.reach` and :meth:`Hybrid.land`;
all else is here, once for NumPy arrays and torch tensors. With tensors autograd goes back to the element's phases and
to whatever the other tracer differentiates by, before and behind the element.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from contextlib import nullcontext
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

import raylet.rays
from raylet._refusal import described
from raylet.layers import Aperture, Layer, Pair, pixel_shape
from raylet.system import System

__all__ = ["Frame", "Hybrid", "Reached"]

#: Steps of position (share of σ) and of direction cosine for the differences that give a Jacobian.
_NEAR_PLACE, _NEAR_COSINE = 1e-3, 1e-5

#: Rays on the element are this many σ apart, and go on so many σ beyond its rim. Fields bear 1.5 σ, gradients to what
#: stands before the element do not.
_STEP, _MARGIN = 1.0, 3.2

#: Steps of Newton's method that aim rays at their places on the element, and the step of its differences.
_AIMS, _NEAR_PUPIL = 3, 1e-4

#: Light that is bent less, in 1/mm, is collimated.
_FLAT = 1e-9


@dataclass(frozen=True, eq=False)
class Frame:
    """Where a part stands: its origin (3,) in mm and the rows x, y, z of its axes (3, 3), global."""

    origin: NDArray[np.float64]
    axes: NDArray[np.float64]

    def place(self, system: System) -> System:
        """Shifts and turns the axis of a system that has nothing yet, so that what is added next stands here."""
        across = self.axes.T
        # Axes turn about x, then the new y, then the new z.
        turns = (
            np.arctan2(-across[1, 2], across[2, 2]),
            np.arcsin(np.clip(across[0, 2], -1.0, 1.0)),
            np.arctan2(-across[0, 1], across[0, 0]),
        )
        system.add_coordinate_break(decenter_mm=self.origin[:2].tolist(), thickness_mm=float(self.origin[2]))
        if np.array_equal(self.axes, np.eye(3)):
            return system
        return system.add_coordinate_break(tilt_deg=np.rad2deg(turns).tolist())


@dataclass(frozen=True, eq=False)
class Reached:
    """Rays on the element: positions and unit directions (rays, 3), optical paths (rays,) with phase zero at the
    global origin; positions and directions (rays, 3) with which they were launched, and shares (rays,) of intensity
    that are left. Lost rays are NaN."""

    position: Any
    direction: Any
    path: Any
    launch: Any
    start: Any
    share: Any

    def chosen(self, which: Any) -> Reached:
        """Some of the rays."""
        columns = (self.position, self.direction, self.path, self.launch, self.start, self.share)
        return Reached(*(each[which] for each in columns))


class Hybrid(ABC):
    """A lens of another tracer with a diffractive element on one of its surfaces and a raylet sensor.

    Light meets the element just before it meets the surface, in the medium before it. Collimated light has unit
    amplitude and phase zero at the global origin; that of a point has both where it meets the global origin.

    Parameters
    ----------
    layers, aperture : the element; see :mod:`raylet.layers`.
    shape : shape of the surface below it, as keys of a surface.
    frames : where element and sensor stand.
    indices : refractive indices of the media where light starts, at the element and at the sensor.
    pixels, pitch_um : the sensor.
    sigma_mm : width of the beamlets; near √(f/k) behind a lens of focal length f.
    towards : optical cosines to follow (x_low, x_high, y_low, y_high) behind the element; all by default.
    threshold : modes below this share of the strongest are left out; 0 for gradients that match differences.
    tolerance : beamlets end where they fall below this share of their peak.
    """

    def __init__(
        self,
        *layers: Layer,
        aperture: Aperture,
        shape: dict[str, Any],
        frames: tuple[Frame, Frame],
        indices: tuple[float, float, float],
        pixels: Sequence[int],
        pitch_um: Pair,
        sigma_mm: float,
        wavelength_um: float,
        towards: tuple[float, float, float, float] | None,
        threshold: float,
        tolerance: float,
    ) -> None:
        if not sigma_mm > 0.0:
            raise ValueError(f"sigma_mm is {sigma_mm}, expected a positive length")
        self.sigma_mm, self.wavelength_um = sigma_mm, wavelength_um
        self.frames, self.indices = frames, indices
        self._choices: dict[str, Any] = {"towards": towards, "threshold": threshold, "sigma_mm": sigma_mm}
        self._tolerance = tolerance

        # The element and the sensor where the other tracer has them, each in its medium.
        here, end = frames
        element = here.place(System(wavelength_um=wavelength_um, ambient=indices[1]))
        element.add_doe(*layers, aperture=aperture, name="element", thickness_mm=1.0, **shape)
        sensor = System(wavelength_um=wavelength_um, ambient=indices[2]).add_stop(aperture, thickness_mm=0.0)
        end.place(sensor)
        self.element, self.sensor = (one.add_sensor(pixels=pixels, pitch_um=pitch_um) for one in (element, sensor))
        self._extent = self.element.transmission("element")[1]
        self._pixels = pixel_shape(layers)

    @described
    def __repr__(self) -> str:
        place = ", ".join(f"{value:.6g}" for value in self.frames[0].origin)
        name = f"{type(self).__module__}.{type(self).__name__}"
        return f"<{name}, λ = {self.wavelength_um:g} µm, element at ({place}) mm, σ = {self.sigma_mm:g} mm>"

    @property
    def k(self) -> float:
        """Vacuum wavenumber in rad/mm."""
        return 2.0 * np.pi / (1e-3 * self.wavelength_um)

    # What an adapter gives.

    @property
    @abstractmethod
    def xp(self) -> Any:
        """The module of the other tracer's arrays: numpy or torch."""

    @abstractmethod
    def reach(self, light: Any, across: Any) -> Reached:
        """Follows rays of one field from the places `across` (rays, 2) in its pupil to the element."""

    @abstractmethod
    def distance(self, light: Any) -> float | None:
        """From the luminous point to the global origin in mm; nothing for collimated light."""

    @abstractmethod
    def land(self, position: Any, direction: Any, path: Any) -> tuple[Any, Any, Any, Any]:
        """Follows rays from the element to the sensor: positions, directions, paths and shares of intensity left."""

    # What follows from it.

    def _field(self, phase: Any, light: Any) -> Any:
        """The complex field [y, x] on the sensor for one field of the lens."""
        xp = self.xp
        made = self._scatter(phase, *self.arriving(light))

        # Rays that are lost on the way must not be in what is differentiated.
        found = self.follow(made, slice(None))
        lit = xp.isfinite(found[0]).all(1) & xp.isfinite(found[4]).all(2).all(1) & (found[3] > 0.0)
        landed, heading, paths, share, jacobian = found if lit.all() else self.follow(made, lit)
        way = {"jacobian": jacobian, "window": made.window[lit], "cosine": made.cosine[lit]}
        beams = self._ways.beams(self.sensor, landed, heading, **way)
        weight = made.weight[lit] * xp.sqrt(share)
        return self._ways.gather(self.sensor, landed, heading, paths, weight, beams=beams, tolerance=self._tolerance)

    @property
    def _ways(self) -> Any:
        """raylet's calls for the other tracer's arrays."""
        if self.xp is np:
            return raylet.rays
        import raylet.torch as ways

        return ways

    def _scatter(self, phase: Any, rays: Sequence[Any], curvature: Any) -> Any:
        choices = {**self._choices, "curvature": curvature}
        if phase is not None and self._pixels not in (None, np.shape(_held(phase))):
            raise ValueError(f"phase has shape {np.shape(_held(phase))}, expected {self._pixels}")
        if self.xp is np:
            system = self.element if phase is None else self.element.with_pixels("element", phase=phase)
            return raylet.rays.scatter(system, "element", *rays, **choices)
        pixels = None if phase is None else self.xp.as_tensor(phase)
        return self._ways.scatter(self.element, "element", pixels, *rays, **choices)

    # Before the element.

    def arriving(self, light: Any) -> tuple[tuple[Any, Any, Any, Any], Any]:
        """Rays of one field on an even lattice of the element: positions, directions, paths and weights, and the
        curvatures (rays, 3) of their wavefront (None for collimated light).

        The lattice is held: with tensors the paths and weights are those of the wave at these places, and go back to
        the other tracer's parameters."""
        xp = self.xp
        with nullcontext() if xp is np else xp.no_grad():
            wanted, across, back = self._aim(light)

        # A last step of the aim, which is differentiated too, keeps rays where they are.
        miss = self._local(self.reach(light, across).position)[:, :2] - wanted
        here, by_across = self._bundle(light, across - _times(back, miss))
        kept = xp.isfinite(here.position).all(1) & xp.isfinite(by_across).all(2).all(1)
        here, by_across = here.chosen(kept), by_across[kept]
        if len(here.path) == 0:
            raise ValueError("no ray of this field reaches the element, expected light on it")
        if bool((here.direction @ xp.asarray(self.frames[0].axes[2]) <= 0.0).any()):
            raise NotImplementedError("light that meets the element against its z axis, expected along it")
        bent = self._bent(here, by_across)

        # Changes of the path are blurred by the square of the windows, whose width is σ/√2; this takes it back.
        trace = bent[:, 0, 0] + bent[:, 1, 1]
        path = here.path - 0.25 * self.sigma_mm**2 * (trace - _held(trace))
        curvature = np.stack([_held_array(bent[:, a, b]) for a, b in ((0, 0), (0, 1), (1, 1))], 1)
        rays = (here.position, here.direction, path, self._amplitude(light, here, by_across))
        return rays, curvature if np.abs(curvature).max() > _FLAT else None

    def _aim(self, light: Any) -> tuple[Any, Any, Any]:
        """The lattice (rays, 2) on the element's axes, where rays for it start, and (rays, 2, 2) by how much more they
        must when they are to land elsewhere."""
        xp = self.xp
        low_x, high_x, low_y, high_y = self._extent
        margin, apart = _MARGIN * self.sigma_mm, _STEP * self.sigma_mm
        xs = np.arange(low_x - margin, high_x + margin + apart, apart)
        ys = np.arange(low_y - margin, high_y + margin + apart, apart)
        wanted = xp.asarray(np.stack([axis.ravel() for axis in np.meshgrid(xs, ys)], 1))

        # Newton's method, all rays first as the one in the middle.
        across = xp.zeros_like(wanted[:1])
        for _ in range(1 + _AIMS):
            here, by_across = self._bundle(light, across)
            back = _inverse(xp, (xp.asarray(self.frames[0].axes[:2]) @ by_across[:, :3]))
            across = across - _times(back, self._local(here.position)[:, :2] - wanted)
        kept = xp.isfinite(across).all(1)
        return wanted[kept], across[kept], back[kept]

    def _bundle(self, light: Any, across: Any) -> tuple[Reached, Any]:
        """Rays, and (rays, 12, 2) derivatives by `across` of their positions, directions, launches and starts."""
        xp, rays = self.xp, len(across)
        moves = _NEAR_PUPIL * np.array([[0.0, 0.0], [1.0, 0.0], [-1.0, 0.0], [0.0, 1.0], [0.0, -1.0]])
        many = self.reach(light, xp.concatenate([across + xp.asarray(move) for move in moves]))
        columns = xp.concatenate([many.position, many.direction, many.launch, many.start], 1)
        sides = [columns[which * rays : (which + 1) * rays] for which in range(5)]
        slopes = [(sides[1] - sides[2]) / (2.0 * _NEAR_PUPIL), (sides[3] - sides[4]) / (2.0 * _NEAR_PUPIL)]
        return many.chosen(slice(0, rays)), xp.stack(slopes, 2)

    def _local(self, position: Any) -> Any:
        frame = self.frames[0]
        return (position - self.xp.asarray(frame.origin)) @ self.xp.asarray(frame.axes.T.copy())

    def _bent(self, here: Reached, by_across: Any) -> Any:
        """Second derivatives (rays, 2, 2) of the optical path along the axes of the plane that touches the element."""
        xp = self.xp
        axes = xp.asarray(self.frames[0].axes)
        moved, turned = axes @ by_across[:, :3], axes @ by_across[:, 3:6]

        # Those axes, from how much the surface rises between rays: x above the element's x axis.
        rise = moved[:, 2:] @ _inverse(xp, moved[:, :2])
        sx, sy = rise[:, 0, 0], rise[:, 0, 1]
        zero, one = xp.zeros_like(sx), xp.ones_like(sx)
        x_axis = xp.stack([one, zero, sx], 1) / xp.sqrt(1.0 + sx**2)[:, None]
        y_axis = xp.stack([-sx * sy, 1.0 + sx**2, sy], 1) / xp.sqrt((1.0 + sx**2) * (1.0 + sx**2 + sy**2))[:, None]
        plane = xp.stack([x_axis, y_axis], 1)
        bent = self.indices[1] * (plane @ turned) @ _inverse(xp, plane @ moved)
        return 0.5 * (bent + xp.swapaxes(bent, 1, 2))

    def _amplitude(self, light: Any, here: Reached, by_across: Any) -> Any:
        """What tubes of rays keep of unit amplitude."""

        def tube(first: int, along: Any) -> Any:
            sides = by_across[:, first : first + 3]
            return self.xp.abs(self.xp.linalg.det(self.xp.concatenate([sides, along[:, :, None]], 2)))

        far = self.distance(light)
        sent = tube(6, here.start) if far is None else far**2 * tube(9, here.start)
        met = tube(0, here.direction)
        return self.xp.sqrt(self.indices[0] * sent / (self.indices[1] * met) * here.share)

    # Behind the element.

    def follow(self, made: Any, chosen: Any) -> tuple[Any, Any, Any, Any, Any]:
        """Secondary rays on the sensor: positions, directions, paths, shares of intensity, and Jacobians from
        neighbours."""
        xp = self.xp
        position, direction, path, axes = (
            each[chosen] for each in (made.position, made.direction, made.path_mm, made.axes)
        )
        near, turn = _NEAR_PLACE * self.sigma_mm, _NEAR_COSINE
        places, ways = [position], [direction]
        for axis in (0, 1):
            for sign in (1.0, -1.0):
                places.append(position + sign * near * axes[:, axis])
                ways.append(direction)
        for axis in (0, 1):
            for sign in (1.0, -1.0):
                places.append(position)
                ways.append(_turned(xp, direction, axes[:, 2], sign * turn / self.indices[1] * axes[:, axis]))
        landed, heading, paths, share = self.land(
            xp.concatenate(places), xp.concatenate(ways), xp.concatenate([path] * len(places))
        )

        # On the sensor's axes, the cosines as optical ones.
        across = xp.asarray(self.frames[1].axes[:2].T.copy())
        rows = xp.concatenate([landed @ across, self.indices[2] * (heading @ across)], 1)
        rays = len(path)
        sides = [rows[which * rays : (which + 1) * rays] for which in range(9)]
        steps = (near, near, turn, turn)
        columns = [(sides[1 + 2 * i] - sides[2 + 2 * i]) / (2.0 * step) for i, step in enumerate(steps)]
        return landed[:rays], heading[:rays], paths[:rays], share[:rays], xp.stack(columns, 2)


def _held(value: Any) -> Any:
    return value.detach() if hasattr(value, "detach") else value


def _held_array(value: Any) -> NDArray[np.float64]:
    return np.asarray(_held(value))


def _times(matrix: Any, vector: Any) -> Any:
    return (matrix @ vector[:, :, None])[:, :, 0]


def _inverse(xp: Any, matrix: Any) -> Any:
    """Inverses (rays, 2, 2), not finite where there is none."""
    a, b, c, d = matrix[:, 0, 0], matrix[:, 0, 1], matrix[:, 1, 0], matrix[:, 1, 1]
    rows = xp.stack([xp.stack([d, -b], 1), xp.stack([-c, a], 1)], 1)
    return rows / (a * d - b * c)[:, None, None]


def _turned(xp: Any, direction: Any, normal: Any, by: Any) -> Any:
    """Directions whose tangential part changes; the normal part keeps them unit vectors."""
    along = (direction * normal).sum(1)
    tangential = direction - along[:, None] * normal + by
    lift = xp.sqrt(1.0 - (tangential * tangential).sum(1)) * xp.sign(along)
    return tangential + lift[:, None] * normal
