"""raylet in DeepLens: a DeepLens lens with a raylet element on one of its planes and a raylet sensor at its image.

DeepLens traces every ray, before and behind the element; raylet splits rays at the element and sums what arrives.
Autograd goes back to the element's phases and to the parameters of DeepLens's surfaces. The lens must be in float64.

>>> import raylet, raylet.deeplens
>>> lens = deeplens.GeoLens("lens.json", dtype=torch.float64, device="cpu")  # doctest: +SKIP
>>> hybrid = raylet.deeplens.Hybrid(                                         # doctest: +SKIP
...     lens, 0, raylet.pixels(pitch_um=6.3, phase=phase), aperture=raylet.disc(0.63),
...     pixels=(200, 200), pitch_um=6.3, sigma_mm=0.08,
... )
>>> field = hybrid.field()                                                   # doctest: +SKIP
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import torch
from deeplens.light import Ray
from torch import Tensor

import raylet.hybrid
from raylet.hybrid import Frame, Reached
from raylet.layers import Aperture, Layer, Pair

__all__ = ["Hybrid"]


class Hybrid(raylet.hybrid.Hybrid):
    """A DeepLens `GeoLens` with a diffractive element on one of its planes and a sensor at its image.

    See :class:`raylet.hybrid.Hybrid` for what light it is and for the parameters not named here.

    Parameters
    ----------
    lens : the lens, in float64 and on the CPU.
    surface : index of the plane (`Plane`, `Aperture`, or a `Spheric` of no curvature) that carries the element.
    pixels, pitch_um : the sensor, at the lens's `d_sensor`.
    """

    def __init__(
        self,
        lens: Any,
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
        wave = float(lens.primary_wvln if wavelength_um is None else wavelength_um)
        if not 0 <= surface < len(lens.surfaces):
            raise IndexError(f"surface is {surface}, expected 0 to {len(lens.surfaces) - 1}")
        _check_tensors(lens)
        _check_plane(lens.surfaces[surface], surface)
        self.lens, self.surface = lens, surface
        media = ["air", *(each.mat2 for each in lens.surfaces)]
        super().__init__(
            *layers,
            aperture=aperture,
            shape={},
            frames=(self._frame(surface), self._frame(len(lens.surfaces))),
            indices=(1.0, _index(media[surface], wave), _index(media[-1], wave)),
            pixels=pixels,
            pitch_um=pitch_um,
            sigma_mm=sigma_mm,
            wavelength_um=wave,
            towards=towards,
            threshold=threshold,
            tolerance=tolerance,
        )

    def field(
        self, phase: Any = None, *, fov_x: float = 0.0, fov_y: float = 0.0, depth: float = float("inf")
    ) -> Tensor:
        """The complex field [y, x] on the sensor, for one field of the lens: angles in degrees and the depth of the
        object in mm (negative), as in DeepLens's `sample_from_fov`.

        `phase` [y, x] replaces that of the element's pixels; as a tensor it may have gradients, as may the
        parameters of all of DeepLens's surfaces; the places of element and sensor are held.
        """
        out: Tensor = self._field(phase, (fov_x, fov_y, depth))
        return out

    @property
    def xp(self) -> Any:
        return torch

    def distance(self, light: Any) -> float | None:
        slope, depth = np.tan(np.deg2rad(light[:2])), light[2]
        return float(np.sqrt(1.0 + slope @ slope) * abs(depth)) if np.isfinite(depth) else None

    def reach(self, light: Any, across: Any) -> Reached:
        # Rays through places on the plane z = 0, where DeepLens has its first vertex.
        slopes = torch.tensor(np.tan(np.deg2rad(light[:2])))
        zero = torch.zeros_like(across[:, :1])
        middle = torch.cat([across, zero], 1)
        far = self.distance(light)
        if far is None:
            launch, heading = middle, torch.cat([slopes.expand_as(across), zero + 1.0], 1)
        else:
            launch = torch.cat([slopes.expand_as(across), zero + 1.0], 1) * light[2]
            heading = middle - launch
        start = heading / heading.norm(dim=1, keepdim=True)
        ray = self._ray(launch, start, torch.zeros_like(across[:, 0]))
        ray = self.lens.trace(ray, surf_range=range(self.surface))[0] if self.surface else ray
        ray = ray.prop_to(float(self.frames[0].origin[2]), n=self.indices[1])
        path = ray.opl[:, 0] + ((launch * start).sum(1) if far is None else -far)
        position, direction, share = _arrays_of(ray)
        return Reached(position, direction, path, launch, start, share)

    def land(self, position: Any, direction: Any, path: Any) -> tuple[Any, Any, Any, Any]:
        ray = self._ray(position, direction, path)
        ray, _ = self.lens.trace(ray, surf_range=range(self.surface, len(self.lens.surfaces)))
        ray = ray.prop_to(float(self.frames[1].origin[2]), n=self.indices[2])
        landed, heading, share = _arrays_of(ray)
        return landed, heading, ray.opl[:, 0], share

    def _ray(self, position: Tensor, direction: Tensor, path: Tensor) -> Any:
        # DeepLens moves rays in place.
        ray = Ray(position.clone(), direction.clone(), wvln=self.wavelength_um, is_coherent=True, device="cpu")
        ray.opl = path[:, None].clone()
        return ray

    def _frame(self, surface: int) -> Frame:
        z = float(self.lens.surf_d(surface).detach())
        return Frame(np.array([0.0, 0.0, z]), np.eye(3))


def _arrays_of(ray: Any) -> tuple[Tensor, Tensor, Tensor]:
    """Positions, directions and shares of intensity; what is lost is nowhere."""
    lost = (ray.is_valid <= 0.0)[:, None]
    nowhere = torch.full_like(ray.o, torch.nan)
    return torch.where(lost, nowhere, ray.o), torch.where(lost, nowhere, ray.d), ray.is_valid


def _index(medium: Any, wave: float) -> float:
    return 1.0 if medium == "air" else float(medium.ior(torch.tensor(wave, dtype=torch.float64)).detach())


def _check_tensors(lens: Any) -> None:
    for number, surface in enumerate(lens.surfaces):
        for name, value in vars(surface).items():
            if not torch.is_tensor(value) or not value.is_floating_point():
                continue
            if value.dtype != torch.float64 or value.device.type != "cpu":
                raise TypeError(
                    f"surfaces[{number}].{name} of the DeepLens lens is {value.dtype} on {value.device}, expected "
                    'torch.float64 on cpu: GeoLens(…, dtype=torch.float64, device="cpu")'
                )


def _check_plane(surface: Any, number: int) -> None:
    name = type(surface).__name__
    plane = name in ("Plane", "Aperture") or (name == "Spheric" and float(surface.c.detach()) == 0.0)
    straight = float(surface.vec_local.detach()[2]) == 1.0
    if not plane or not straight:
        found = name if straight else f"tilted {name}"
        raise NotImplementedError(f"surfaces[{number}] of the DeepLens lens is a {found}, expected a straight plane")
