"""raylet inside PyTorch: complex fields and intensities that autograd can go back through.

Tensors on the CPU are not copied where they are float64 or complex128; others are converted, and results come back in
the precision and on the device of what was given. Derivatives are of first order.

>>> import torch, raylet, raylet.torch
>>> bench = system.bench("hologram", numbers=["element[1].thickness_mm"])  # doctest: +SKIP
>>> intensity = raylet.torch.intensity(bench, phase, numbers=numbers)      # doctest: +SKIP
>>> loss(intensity).backward()                                             # doctest: +SKIP
"""

from __future__ import annotations

from typing import Any

import numpy as np
import torch
from torch import Tensor
from torch.autograd.function import once_differentiable

from raylet.bench import Bench

__all__ = ["field", "intensity"]


def field(bench: Bench, *pixels: Tensor, numbers: Tensor | None = None) -> Tensor:
    """The complex field on the sensor of a bench with these pixels (phases, or complex transmissions) and numbers.

    complex64 where everything given has single precision, else complex128.
    """
    given: list[Tensor] = [*pixels] if numbers is None else [*pixels, numbers]
    for tensor in given:
        if not isinstance(tensor, Tensor):
            raise TypeError(f"{type(tensor).__name__} given, expected torch tensors")
        if tensor.dtype not in _SINGLE:
            raise TypeError(f"a tensor of {tensor.dtype}, expected one of {', '.join(map(str, _SINGLE))}")
    out: Tensor = _Field.apply(bench, len(pixels), *given)
    return out


def intensity(bench: Bench, *pixels: Tensor, numbers: Tensor | None = None) -> Tensor:
    """|U|² on the sensor of a bench."""
    amplitude = field(bench, *pixels, numbers=numbers)
    return amplitude.real.square() + amplitude.imag.square()


#: Types that are taken, and whether they have single precision.
_SINGLE = {torch.float32: True, torch.complex64: True, torch.float64: False, torch.complex128: False}


def _numpy(tensor: Tensor) -> Any:
    return tensor.detach().resolve_conj().resolve_neg().cpu().numpy()


class _Field(torch.autograd.Function):
    """The library's forward step and its transpose."""

    @staticmethod
    def forward(ctx: Any, bench: Bench, count: int, *given: Tensor) -> Tensor:
        arrays = [_numpy(tensor) for tensor in given]
        passage = bench(*arrays[:count], numbers=arrays[count] if len(arrays) > count else None)
        ctx.passage, ctx.count = passage, count
        ctx.like = [(tensor.dtype, tensor.device, tensor.shape) for tensor in given]
        single = bool(given) and all(_SINGLE[tensor.dtype] for tensor in given)
        made = torch.from_numpy(passage.field)
        device = given[0].device if given else made.device
        return made.to(device=device, dtype=torch.complex64 if single else torch.complex128)

    @staticmethod
    @once_differentiable
    def backward(ctx: Any, bar: Tensor) -> tuple[Any, ...]:
        pixels, numbers = ctx.passage.adjoint(np.asarray(_numpy(bar), dtype=np.complex128))
        back: list[Any] = [*pixels, numbers][: len(ctx.like)]
        tensors = (
            torch.from_numpy(np.ascontiguousarray(one)).reshape(shape).to(device=device, dtype=dtype)
            for one, (dtype, device, shape) in zip(back, ctx.like)
        )
        return None, None, *tensors
