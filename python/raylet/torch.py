"""raylet inside PyTorch: complex fields and intensities that autograd can go back through.

Tensors on the CPU are not copied where they are float64 or complex128; others are converted, and results come back in
the precision and on the device of what was given. Derivatives are of first order.

>>> import torch, raylet, raylet.torch
>>> linearised = system.linearised("hologram", parameters=["element[1].thickness_mm"])  # doctest: +SKIP
>>> intensity = raylet.torch.intensity(linearised, phase, parameters=parameters)      # doctest: +SKIP
>>> loss(intensity).backward()                                             # doctest: +SKIP
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
import torch
from torch import Tensor
from torch.autograd.function import once_differentiable

import raylet.rays
from raylet.linearised_system import LinearisedSystem

if TYPE_CHECKING:
    from raylet.system import System

__all__ = ["Beams", "Secondary", "beams", "field", "gather", "intensity", "scatter"]


def field(linearised: LinearisedSystem, *pixels: Tensor, parameters: Tensor | None = None) -> Tensor:
    """The complex field of a linearised system with these pixels (phases or complex transmissions) and parameters.

    complex64 where everything given has single precision, else complex128.
    """
    given: list[Tensor] = [*pixels] if parameters is None else [*pixels, parameters]
    for tensor in given:
        if not isinstance(tensor, Tensor):
            raise TypeError(f"{type(tensor).__name__} given, expected torch tensors")
        if tensor.dtype not in _SINGLE:
            raise TypeError(f"a tensor of {tensor.dtype}, expected one of {', '.join(map(str, _SINGLE))}")
    out: Tensor = _Field.apply(linearised, len(pixels), *given)
    return out


def intensity(linearised: LinearisedSystem, *pixels: Tensor, parameters: Tensor | None = None) -> Tensor:
    """|U|² on the sensor of a linearised system."""
    amplitude = field(linearised, *pixels, parameters=parameters)
    return amplitude.real.square() + amplitude.imag.square()


#: Types that are taken, and whether they have single precision.
_SINGLE = {torch.float32: True, torch.complex64: True, torch.float64: False, torch.complex128: False}


def _numpy(tensor: Tensor) -> Any:
    return tensor.detach().resolve_conj().resolve_neg().cpu().numpy()


class _Field(torch.autograd.Function):
    """The library's forward step and its transpose."""

    @staticmethod
    def forward(ctx: Any, linearised: LinearisedSystem, count: int, *given: Tensor) -> Tensor:
        arrays = [_numpy(tensor) for tensor in given]
        passage = linearised(*arrays[:count], parameters=arrays[count] if len(arrays) > count else None)
        ctx.passage, ctx.count = passage, count
        ctx.like = [(tensor.dtype, tensor.device, tensor.shape) for tensor in given]
        single = bool(given) and all(_SINGLE[tensor.dtype] for tensor in given)
        made = torch.from_numpy(passage.field)
        device = given[0].device if given else made.device
        return made.to(device=device, dtype=torch.complex64 if single else torch.complex128)

    @staticmethod
    @once_differentiable
    def backward(ctx: Any, bar: Tensor) -> tuple[Any, ...]:
        pixels, parameters = ctx.passage.adjoint(np.asarray(_numpy(bar), dtype=np.complex128))
        back: list[Any] = [*pixels, parameters][: len(ctx.like)]
        tensors = (
            torch.from_numpy(np.ascontiguousarray(one)).reshape(shape).to(device=device, dtype=dtype)
            for one, (dtype, device, shape) in zip(back, ctx.like)
        )
        return None, None, *tensors


@dataclass(frozen=True, eq=False)
class Secondary:
    """Rays that leave an element, as :class:`raylet.Secondary` has them, in tensors; `weight` and `path_mm` go back to
    the element's pixels and to the rays that arrived."""

    position: Tensor
    direction: Tensor
    path_mm: Tensor
    weight: Tensor
    window: Tensor
    cosine: Tensor
    axes: Tensor
    parent: Tensor


@dataclass(frozen=True, eq=False)
class Beams:
    """Beamlets on a sensor, as :class:`raylet.Beams` has them, in tensors."""

    amplitude: Tensor
    curvature: Tensor


def scatter(
    system: System,
    element: str,
    pixels: Tensor | None,
    position: Tensor,
    direction: Tensor,
    path_mm: Tensor,
    weight: Tensor,
    *,
    sigma_mm: float,
    **choices: Any,
) -> Secondary:
    """:func:`raylet.scatter` with the element's pixels (phases, or complex transmissions) as a tensor, or as they are.

    Gradients go to the pixels, the arriving weights and paths; which modes were kept, and where rays arrive, is held
    constant.
    """
    place, along, path = (_numpy(tensor).astype(np.float64, copy=False) for tensor in (position, direction, path_mm))
    filled = system
    if pixels is not None:
        filled = system.with_pixels(element, **{"transmission" if pixels.is_complex() else "phase": _numpy(pixels)})
    made = raylet.rays.scatter(filled, element, place, along, path, _numpy(weight), sigma_mm=sigma_mm, **choices)
    parent = torch.from_numpy(made.parent)
    return Secondary(
        position=torch.from_numpy(made.position),
        direction=torch.from_numpy(made.direction),
        path_mm=path_mm[parent],
        weight=_Scatter.apply(made, pixels, weight),
        window=torch.from_numpy(made.window),
        cosine=torch.from_numpy(made.cosine),
        axes=torch.from_numpy(made.axes),
        parent=parent,
    )


def beams(
    system: System,
    position: Tensor,
    direction: Tensor,
    *,
    jacobian: Tensor,
    window: Tensor,
    cosine: Tensor,
    images: Any = None,
    channel: int = 0,
) -> Beams:
    """:func:`raylet.beams` with gradients to the Jacobians and the directions."""
    ways = {"jacobian": _numpy(jacobian), "window": _numpy(window), "cosine": _numpy(cosine), "images": images}
    plain = raylet.rays.beams(system, _numpy(position), _numpy(direction), **ways, channel=channel)
    k = 2.0 * np.pi / (1e-3 * system.wavelength_um[channel])
    normal = torch.tensor(system.parts[-1]["axes"][2], dtype=direction.dtype)
    like = torch.from_numpy(plain.amplitude)
    return Beams(*_beamlets(k, jacobian, window, cosine, direction @ normal, like))


def _beamlets(k: float, jacobian: Any, window: Any, cosine: Any, along: Any, root_like: Any) -> tuple[Any, Any]:
    """Amplitudes (rays,) and curvatures (rays, 3) of beamlets: G = (C + Dq₀)(A + Bq₀)⁻¹ with q₀ = iW/k, and
    det(A + Bq₀)^{−1/2} √(cos/cos′), of the two roots the one near `root_like`."""
    W = torch.stack([window[:, [0, 1]], window[:, [1, 2]]], 1)
    A, B = jacobian[:, :2, :2], jacobian[:, :2, 2:]
    C, D = jacobian[:, 2:, :2], jacobian[:, 2:, 2:]
    M, N = A + (1j / k) * (B @ W), C + (1j / k) * (D @ W)
    a, b, c, d = M[:, 0, 0], M[:, 0, 1], M[:, 1, 0], M[:, 1, 1]
    det = a * d - b * c
    xx = (N[:, 0, 0] * d - N[:, 0, 1] * c) / det
    xy = (N[:, 0, 1] * a - N[:, 0, 0] * b) / det
    yx = (N[:, 1, 0] * d - N[:, 1, 1] * c) / det
    yy = (N[:, 1, 1] * a - N[:, 1, 0] * b) / det
    root = 1.0 / torch.sqrt(det) * torch.sqrt(cosine / torch.abs(along))
    flipped = (root * root_like.conj()).real < 0.0
    root = torch.where(flipped, -root, root)
    return root, torch.stack([xx, 0.5 * (xy + yx), yy], 1)


def gather(
    system: System,
    position: Tensor,
    direction: Tensor,
    path_mm: Tensor,
    weight: Tensor,
    *,
    beams: Beams | None = None,
    tolerance: float = 1e-3,
    channel: int = 0,
) -> Tensor:
    """:func:`raylet.gather` with gradients to places, directions, paths, weights and beamlets."""
    sensor = system.parts[-1]
    sum_of = (system, {"tolerance": tolerance, "channel": channel}, sensor)
    held = () if beams is None else (beams.amplitude, beams.curvature)
    out: Tensor = _Gather.apply(sum_of, position, direction, path_mm, weight, *held)
    return out


class _Scatter(torch.autograd.Function):
    """The weights of secondary rays."""

    @staticmethod
    def forward(ctx: Any, made: Any, pixels: Tensor | None, weight: Tensor) -> Tensor:
        ctx.made = made
        ctx.save_for_backward(pixels)
        ctx.like = (weight.dtype, weight.shape)
        return torch.from_numpy(made.weight)

    @staticmethod
    @once_differentiable
    def backward(ctx: Any, bar: Tensor) -> tuple[Any, ...]:
        by_pixels, by_weight = ctx.made.adjoint(_numpy(bar))
        (pixels,) = ctx.saved_tensors
        back = None
        if by_pixels is not None and pixels is not None:
            t_bar = torch.from_numpy(by_pixels)
            # t = e^{iφ}: φ̄ = Im(t̄ t*).
            back = t_bar if pixels.is_complex() else (t_bar * torch.polar(torch.ones_like(pixels), -pixels)).imag
            back = back.to(pixels.dtype)
        dtype, shape = ctx.like
        weight = torch.from_numpy(by_weight)
        return None, back, (weight if dtype.is_complex else weight.real).to(dtype).reshape(shape)


class _Gather(torch.autograd.Function):
    """The sum of rays on a sensor."""

    @staticmethod
    def forward(ctx: Any, sum_of: Any, *rays: Tensor) -> Tensor:
        ctx.sum_of = sum_of
        ctx.save_for_backward(*rays)
        system, choices, _ = sum_of
        plain = [_numpy(tensor) for tensor in rays]
        beams = raylet.rays.Beams(*plain[4:]) if len(plain) > 4 else None
        return torch.from_numpy(raylet.rays.gather(system, *plain[:4], beams=beams, **choices))

    @staticmethod
    @once_differentiable
    def backward(ctx: Any, bar: Tensor) -> tuple[Any, ...]:
        system, choices, sensor = ctx.sum_of
        rays = ctx.saved_tensors
        plain = [_numpy(tensor) for tensor in rays]
        beams = raylet.rays.Beams(*plain[4:]) if len(plain) > 4 else None
        place, along, path, weight = plain[:4]
        back = raylet.rays.gather_adjoint(system, place, along, path, weight, _numpy(bar), beams=beams, **choices)
        across = np.array(sensor["axes"][:2])
        parts = [back.at @ across, sensor["index"] * (back.cosines @ across), back.path_mm, back.weight]
        parts += [back.amplitude, back.curvature] if beams is not None else []
        like = zip(parts, rays)
        return None, *(
            torch.from_numpy(part if kind.is_complex() else part.real.copy()).to(kind.dtype) for part, kind in like
        )
