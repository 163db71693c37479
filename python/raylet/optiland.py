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

import raylet.hybrid
from raylet.hybrid import Frame, Reached
from raylet.layers import Aperture, Layer, Pair
from raylet.system import System

__all__ = ["Hybrid", "to_system"]


def _number(value: Any) -> float:
    return float(np.asarray(_array(value)).reshape(-1)[0])


def _array(value: Any) -> Any:
    return value.detach().cpu().numpy() if hasattr(value, "detach") else np.asarray(value)


def _frame(surface: Any) -> Frame:
    """Where a surface stands, from rays that start at its vertex along its axes."""
    zero, (a, b, c) = np.zeros(3), np.eye(3)
    rays = RealRays(zero, zero, zero, a, b, c, zero, zero)
    surface.geometry.globalize(rays)
    values = [_array(value) for value in (rays.x, rays.y, rays.z, rays.L, rays.M, rays.N)]
    return Frame(np.array(values[:3])[:, 0], np.array(values[3:]).T)


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


class Hybrid(raylet.hybrid.Hybrid):
    """An Optiland lens with a diffractive element on one of its surfaces and a sensor at its image.

    See :class:`raylet.hybrid.Hybrid` for what light it is and for the parameters not named here. The surfaces may be
    tilted; the element's is a plane, a conic or an even asphere. Objects are at infinity or not.

    Parameters
    ----------
    optic : the lens.
    surface : index of the surface that carries the element.
    pixels, pitch_um : the sensor, in the plane of the image surface.
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
        wave = wavelength_um if wavelength_um is not None else _number(optic.primary_wavelength)
        if not 1 <= surface < len(optic.surfaces):
            raise IndexError(f"surface is {surface}, expected 1 to {len(optic.surfaces) - 1}")
        carrier, image = optic.surfaces[surface], optic.surfaces[-1]
        media = (optic.surfaces[0].material_post, carrier.material_pre, image.material_pre)
        self.optic, self.surface = optic, surface
        super().__init__(
            *layers,
            aperture=aperture,
            shape={key: value for key, value in _shape(carrier).items() if value is not None},
            frames=(_frame(carrier), _frame(image)),
            indices=(_number(media[0].n(wave)), _number(media[1].n(wave)), _number(media[2].n(wave))),
            pixels=pixels,
            pitch_um=pitch_um,
            sigma_mm=sigma_mm,
            wavelength_um=wave,
            towards=towards,
            threshold=threshold,
            tolerance=tolerance,
        )

    def field(self, phase: Any = None, *, Hx: float = 0.0, Hy: float = 0.0) -> Any:
        """The complex field [y, x] on the sensor, for one field of the lens.

        `phase` [y, x] replaces that of the element's pixels. With Optiland's torch backend it may be a tensor that has
        gradients, as may the parameters of all of Optiland's surfaces; the places of element and sensor are held.
        """
        return self._field(phase, (Hx, Hy))

    @property
    def xp(self) -> Any:
        if be.get_backend() != "torch":
            return np
        import torch

        if be.zeros((1,)).dtype != torch.float64:
            raise TypeError('Optiland has single precision, expected optiland.backend.set_precision("float64")')
        return torch

    def distance(self, light: Any) -> float | None:
        if self.optic.object_surface.is_infinite:
            return None
        rays = self._launched(light, self.xp.zeros((1, 2), dtype=self.xp.float64))
        return float(np.linalg.norm([_number(rays.x), _number(rays.y), _number(rays.z)]))

    def reach(self, light: Any, across: Any) -> Reached:
        xp = self.xp
        rays = self._launched(light, across)
        launch, start = xp.stack([rays.x, rays.y, rays.z], 1), xp.stack([rays.L, rays.M, rays.N], 1)
        for surface in list(self.optic.surfaces)[1 : self.surface]:
            surface.trace(rays, record=False)

        # To the surface that carries the element, which does not act yet.
        carrier = self.optic.surfaces[self.surface]
        carrier.geometry.localize(rays)
        t = carrier.geometry.distance(rays)
        rays.x, rays.y, rays.z = rays.x + t * rays.L, rays.y + t * rays.M, rays.z + t * rays.N
        carrier.geometry.globalize(rays)
        path = rays.opd + t * self.indices[1]
        far = self.distance(light)
        path = path + self.indices[0] * ((launch * start).sum(1) if far is None else -far)
        position, direction = xp.stack([rays.x, rays.y, rays.z], 1), xp.stack([rays.L, rays.M, rays.N], 1)
        return Reached(position, direction, path, launch, start, rays.i)

    def _launched(self, light: Any, across: Any) -> Any:
        Hx, Hy = (be.array(np.full(len(across), value)) for value in light)
        generator = self.optic.ray_tracer.ray_generator
        return generator.generate_rays(Hx, Hy, across[:, 0], across[:, 1], self.wavelength_um)

    def land(self, position: Any, direction: Any, path: Any) -> tuple[Any, Any, Any, Any]:
        xp, (x, y, z), (a, b, c) = self.xp, position.T, direction.T
        ones = xp.ones_like(path)
        rays = RealRays(x, y, z, a, b, c, ones, ones * self.wavelength_um)
        rays.opd = path
        for surface in list(self.optic.surfaces)[self.surface :]:
            surface.trace(rays, record=False)
        return xp.stack([rays.x, rays.y, rays.z], 1), xp.stack([rays.L, rays.M, rays.N], 1), rays.opd, rays.i
