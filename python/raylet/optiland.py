"""raylet in Optiland: an Optiland lens with a raylet element on one of its surfaces and a raylet sensor at its image.

Optiland traces every ray, before and behind the element; raylet splits rays at the element and sums what arrives.
Works with Optiland's NumPy backend and, with gradients, with its torch backend in float64.

>>> import raylet, raylet.optiland
>>> hybrid = raylet.optiland.Hybrid(                                         # doctest: +SKIP
...     optic, 1, raylet.pixels(pitch_um=6.3, phase=phase), aperture=raylet.disc(0.63),
...     pixels=(200, 200), pitch_um=6.3, sigma_mm=0.08,
... )
>>> field = hybrid.field()                                                   # doctest: +SKIP
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import optiland.backend as be
from optiland.rays.real_rays import RealRays

import raylet.rays
from raylet.layers import Aperture, Layer, Pair
from raylet.system import System

__all__ = ["Hybrid", "to_system"]

#: Positions this share of σ apart, and cosines this far apart, tell a Jacobian.
_NEAR_PLACE, _NEAR_COSINE = 1e-3, 1e-5

#: Rays on the element are this many σ apart, and go on so many σ beyond its rim.
_STEP, _MARGIN = 1.2, 3.2


def _number(value: Any) -> float:
    return float(np.asarray(_array(value)).reshape(-1)[0])


def _array(value: Any) -> Any:
    return value.detach().cpu().numpy() if hasattr(value, "detach") else np.asarray(value)


def _place(surface: Any) -> tuple[float, float, float]:
    """The vertex of a surface that is not tilted."""
    system = surface.geometry.cs
    if any(abs(_number(getattr(system, angle))) > 0.0 for angle in ("rx", "ry", "rz")):
        raise NotImplementedError("tilted Optiland surfaces, expected straight ones")
    return _number(system.x), _number(system.y), _number(system.z)


def _shape(surface: Any) -> dict[str, Any]:
    """The shape of a surface in raylet's words."""
    geometry = surface.geometry
    name = type(geometry).__name__
    if name not in ("Plane", "StandardGeometry", "EvenAsphere"):
        raise NotImplementedError(f"Optiland geometry {name}, expected Plane, StandardGeometry or EvenAsphere")
    radius = _number(getattr(geometry, "radius", np.inf))
    shape: dict[str, Any] = {
        "radius_mm": radius if np.isfinite(radius) else None,
        "conic": _number(getattr(geometry, "k", 0.0)),
    }
    powers = [_number(value) for value in getattr(geometry, "coefficients", [])]
    if powers and powers[0] != 0.0:
        raise NotImplementedError("an asphere with a coefficient of r², expected it in the radius")
    return {**shape, "aspheric": powers[1:]} if powers else shape


def to_system(
    optic: Any,
    wavelength_um: float | None = None,
    *,
    semi_aperture_mm: float | Sequence[float],
    pixels: Sequence[int] = (64, 64),
    pitch_um: Pair = 10.0,
) -> System:
    """The refracting surfaces of an Optiland lens as a raylet system of its own, at one wavelength.

    `semi_aperture_mm` is the clear radius of all surfaces, or of each; a stop among them has that radius too.
    """
    wave = wavelength_um if wavelength_um is not None else _number(optic.primary_wavelength)
    surfaces = list(optic.surfaces)[1:]
    radii = np.broadcast_to(np.asarray(semi_aperture_mm, dtype=float), (len(surfaces) - 1,))
    system = System(wavelength_um=wave, title=str(getattr(optic, "name", "") or ""))
    for number, surface in enumerate(surfaces[:-1]):
        thickness = _place(surfaces[number + 1])[2] - _place(surface)[2]
        index = _number(surface.material_post.n(wave))
        system.add_surface(
            glass=index, thickness_mm=thickness, semi_aperture_mm=float(radii[number]), **_shape(surface)
        )
    return system.add_sensor(pixels=pixels, pitch_um=pitch_um)


class Hybrid:
    """An Optiland lens with a diffractive element on one of its surfaces and a sensor at its image.

    Light meets the element just before it meets the surface, in the medium before it. The object is at infinity and the
    light of unit amplitude, its phase zero at the global origin.

    Parameters
    ----------
    optic : the lens.
    surface : index of the surface that carries the element.
    layers, aperture : the element; see :mod:`raylet.layers`.
    pixels, pitch_um : the sensor, in the plane of the image surface.
    sigma_mm : width of the beamlets; near √(f/k) behind a lens of focal length f.
    towards : wanted optical cosines (x_low, x_high, y_low, y_high) behind the element; all by default.
    threshold : modes below this share of the strongest are left out; 0 for gradients that match differences.
    """

    def __init__(
        self,
        optic: Any,
        surface: int,
        *layers: Layer,
        aperture: Aperture,
        pixels: Sequence[int],
        pitch_um: Pair,
        sigma_mm: float,
        wavelength_um: float | None = None,
        towards: tuple[float, float, float, float] | None = None,
        threshold: float = 1e-3,
        tolerance: float = 1e-3,
    ) -> None:
        self.optic, self.surface, self.sigma_mm = optic, surface, sigma_mm
        self.wavelength_um = wavelength_um if wavelength_um is not None else _number(optic.primary_wavelength)
        self._choices: dict[str, Any] = {"towards": towards, "threshold": threshold, "sigma_mm": sigma_mm}
        self._tolerance = tolerance
        carrier, image = optic.surfaces[surface], optic.surfaces[-1]
        (x, y, z), (_, _, end) = _place(carrier), _place(image)
        self._index = _number(carrier.material_pre.n(self.wavelength_um))
        behind = _number(image.material_pre.n(self.wavelength_um))
        shape = {key: value for key, value in _shape(carrier).items() if value is not None}

        # The element and the sensor where Optiland has them, each in its medium.
        element = System(wavelength_um=self.wavelength_um, ambient=self._index).add_coordinate_break(thickness_mm=z)
        element.add_doe(*layers, aperture=aperture, name="element", thickness_mm=end - z, decenter_mm=(x, y), **shape)
        sensor = System(wavelength_um=self.wavelength_um, ambient=behind).add_coordinate_break(thickness_mm=z)
        sensor.add_stop(aperture, thickness_mm=end - z)
        self.element, self.sensor = (one.add_sensor(pixels=pixels, pitch_um=pitch_um) for one in (element, sensor))
        self._extent = self.element.transmission("element")[1]

    @property
    def k(self) -> float:
        """Vacuum wavenumber in rad/mm."""
        return 2.0 * np.pi / (1e-3 * self.wavelength_um)

    def field(self, phase: Any = None, *, Hx: float = 0.0, Hy: float = 0.0) -> Any:
        """The complex field [y, x] on the sensor, for one field of the lens.

        `phase` [y, x] replaces that of the element's pixels; as a torch tensor it has gradients, as have the numbers of
        Optiland's surfaces from the element on.
        """
        torch = be.get_backend() == "torch"
        position, direction, path, weight, curvature = self.arriving(Hx, Hy)
        if torch:
            return self._torch(phase, (position, direction, path, weight), curvature)
        system = self.element if phase is None else self.element.with_pixels("element", phase=phase)
        made = raylet.rays.scatter(
            system, "element", position, direction, path, weight, curvature=curvature, **self._choices
        )
        landed, heading, paths, jacobian = self.follow(np, made)
        lit = np.isfinite(landed).all(1) & np.isfinite(jacobian).all((1, 2))
        way = {"jacobian": jacobian[lit], "window": made.window[lit], "cosine": made.cosine[lit]}
        beams = raylet.rays.beams(self.sensor, landed[lit], heading[lit], **way)
        rays = (landed[lit], heading[lit], paths[lit], made.weight[lit])
        return raylet.rays.gather(self.sensor, *rays, beams=beams, tolerance=self._tolerance)

    def _torch(self, phase: Any, rays: Sequence[Any], curvature: Any) -> Any:
        import torch

        import raylet.torch as here

        place, along, path, weight = (torch.as_tensor(array) for array in rays)
        if phase is None:
            raise TypeError("with Optiland's torch backend the phase [y, x] of the element is given as a tensor")
        made = here.scatter(
            self.element, "element", phase, place, along, path, weight, curvature=curvature, **self._choices
        )
        landed, heading, paths, jacobian = self.follow(torch, made)
        lit = torch.isfinite(landed).all(1) & torch.isfinite(jacobian).all(2).all(1)
        way = {"jacobian": jacobian[lit], "window": made.window[lit], "cosine": made.cosine[lit]}
        beams = here.beams(self.sensor, landed[lit], heading[lit], **way)
        arrived = (landed[lit], heading[lit], paths[lit], made.weight[lit])
        return here.gather(self.sensor, *arrived, beams=beams, tolerance=self._tolerance)

    # Before the element.

    def arriving(self, Hx: float, Hy: float) -> tuple[Any, Any, Any, Any, Any]:
        """Rays of the lens where they meet the element: positions, directions, paths, weights, and curvatures of the
        wavefront (None for light that no surface has bent), as NumPy arrays on an even lattice."""
        step = 1e-4
        middle, u, v = (
            self._hit(Hx, Hy, np.array([a]), np.array([b])) for a, b in ((0.0, 0.0), (step, 0.0), (0.0, step))
        )
        scale = np.array([(u[0] - middle[0])[0, :2] / step, (v[0] - middle[0])[0, :2] / step]).T
        low_x, high_x, low_y, high_y = self._extent
        margin, apart = _MARGIN * self.sigma_mm, _STEP * self.sigma_mm
        xs = np.arange(low_x - margin, high_x + margin + apart, apart)
        ys = np.arange(low_y - margin, high_y + margin + apart, apart)
        wanted = np.stack([axis.ravel() for axis in np.meshgrid(xs, ys)], 1)
        vertex = np.array(_place(self.optic.surfaces[self.surface])[:2])
        Px, Py = np.linalg.solve(scale, (wanted + vertex - middle[0][0, :2]).T)
        here = self._hit(Hx, Hy, Px, Py)
        sides = [self._hit(Hx, Hy, Px + a, Py + b) for a, b in ((step, 0.0), (-step, 0.0), (0.0, step), (0.0, -step))]

        def slope(which: int) -> Any:
            pairs = ((sides[0], sides[1]), (sides[2], sides[3]))
            return np.stack([(above[which][:, :2] - below[which][:, :2]) / (2 * step) for above, below in pairs], -1)

        # Energy of a tube of rays is kept; the source has unit amplitude.
        position, direction, path, _, start, intensity = here
        spread = np.linalg.det(slope(0)) * direction[:, 2] * self._index
        tube = np.linalg.det(slope(3)) * start[:, 2]
        weight = np.sqrt(np.abs(tube / spread) * intensity).astype(complex)
        bend = self._index * np.linalg.solve(np.swapaxes(slope(0), 1, 2), np.swapaxes(slope(1), 1, 2))
        curvature = np.stack([bend[:, 0, 0], 0.5 * (bend[:, 0, 1] + bend[:, 1, 0]), bend[:, 1, 1]], 1)
        kept = np.isfinite(position).all(1) & np.isfinite(weight) & np.isfinite(curvature).all(1)
        bent = None if self.surface == 1 else np.ascontiguousarray(curvature[kept])
        if bent is not None and _shape(self.optic.surfaces[self.surface])["radius_mm"] is not None:
            raise NotImplementedError("an element on a curved surface behind other surfaces, expected a plane one")
        return position[kept], direction[kept], path[kept], weight[kept], bent

    def _hit(self, Hx: float, Hy: float, Px: Any, Py: Any) -> tuple[Any, ...]:
        """Rays on the element, and where and how they were launched."""
        generator = self.optic.ray_tracer.ray_generator
        given = [
            be.array(np.asarray(value, dtype=float)) for value in (np.full(Px.shape, Hx), np.full(Px.shape, Hy), Px, Py)
        ]
        rays = generator.generate_rays(*given, self.wavelength_um)
        launch = np.stack([_array(rays.x), _array(rays.y), _array(rays.z)], 1)
        start = np.stack([_array(rays.L), _array(rays.M), _array(rays.N)], 1)
        for surface in list(self.optic.surfaces)[1 : self.surface]:
            surface.trace(rays, record=False)
        carrier = self.optic.surfaces[self.surface]
        carrier.geometry.localize(rays)
        t = carrier.geometry.distance(rays)
        rays.x, rays.y, rays.z = rays.x + t * rays.L, rays.y + t * rays.M, rays.z + t * rays.N
        rays.opd = rays.opd + t * self._index
        carrier.geometry.globalize(rays)
        position = np.stack([_array(rays.x), _array(rays.y), _array(rays.z)], 1)
        direction = np.stack([_array(rays.L), _array(rays.M), _array(rays.N)], 1)
        before = _number(self.optic.surfaces[0].material_post.n(self.wavelength_um))
        path = _array(rays.opd) + before * np.sum(launch * start, 1)
        return position, direction, path, launch, start, _array(rays.i)

    # Behind the element.

    def follow(self, xp: Any, made: Any) -> tuple[Any, Any, Any, Any]:
        """Secondary rays on the sensor: positions, directions, paths, and their Jacobians from neighbours."""
        near, turn = _NEAR_PLACE * self.sigma_mm, _NEAR_COSINE
        landed, heading, paths = self._land(xp, made.position, made.direction, made.path_mm)
        index = _number(self.optic.surfaces[-1].material_pre.n(self.wavelength_um))
        columns = []
        for axis in (0, 1):
            across = made.axes[:, axis]
            columns.append(self._slope(xp, made, (near, across * near, 0.0), index))
        for axis in (0, 1):
            across = made.axes[:, axis]
            columns.append(self._slope(xp, made, (turn, 0.0, across * (turn / self._index)), index))
        return landed, heading, paths, xp.stack(columns, 2)

    def _slope(self, xp: Any, made: Any, step: tuple[float, Any, Any], index: float) -> Any:
        size, moved, turned = step
        sides = []
        for sign in (1.0, -1.0):
            position = made.position + sign * moved
            direction = made.direction
            if not isinstance(turned, float):
                # The tangential part changes, the normal part keeps it a unit vector.
                normal = made.axes[:, 2]
                tangential = direction - _dot(direction, normal)[:, None] * normal + sign * turned
                lift = xp.sqrt(1.0 - _dot(tangential, tangential)) * xp.sign(_dot(direction, normal))
                direction = tangential + lift[:, None] * normal
            landed, heading, _ = self._land(xp, position, direction, made.path_mm)
            sides.append(xp.concatenate([landed[:, :2], index * heading[:, :2]], 1))
        return (sides[0] - sides[1]) / (2.0 * size)

    def _land(self, xp: Any, position: Any, direction: Any, path: Any) -> tuple[Any, Any, Any]:
        wave = self.wavelength_um
        (x, y, z), (a, b, c), ones = position.T, direction.T, be.ones_like(be.array(path))
        rays = RealRays(x, y, z, a, b, c, ones, ones * wave)
        rays.opd = be.array(path)
        for surface in list(self.optic.surfaces)[self.surface :]:
            surface.trace(rays, record=False)
        landed, heading = xp.stack([rays.x, rays.y, rays.z], 1), xp.stack([rays.L, rays.M, rays.N], 1)
        return landed, heading, rays.opd


def _dot(a: Any, b: Any) -> Any:
    return (a * b).sum(1)
