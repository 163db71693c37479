"""raylet inside JAX: complex fields and intensities with a custom derivative of first order.

Works under `jax.grad`, `jax.vjp`, `jax.jit` (through a host callback) and optimisers built on them. Double precision
needs `jax.config.update("jax_enable_x64", True)`; else results are single.
"""

from __future__ import annotations

from functools import partial
from typing import Any
from weakref import WeakKeyDictionary

import jax
import jax.numpy as jnp
import numpy as np

from raylet.bench import Bench, Passage

__all__ = ["field", "intensity"]


def field(bench: Bench, *pixels: Any, parameters: Any = None) -> Any:
    """The complex field on the sensor of a bench with these parameters and pixels (phases or transmissions)."""
    values = jnp.asarray(bench.start if parameters is None else parameters)
    arrays = tuple(jnp.asarray(array) for array in pixels)
    bench._check([array.shape for array in arrays], values.shape)
    return _field(_Hashed(bench), arrays, values)


def intensity(bench: Bench, *pixels: Any, parameters: Any = None) -> Any:
    """|U|² on the sensor of a bench."""
    amplitude = field(bench, *pixels, parameters=parameters)
    return jnp.square(amplitude.real) + jnp.square(amplitude.imag)


class _Hashed:
    """A bench that JAX can distinguish from others, with its latest passage, of which gradients are taken."""

    def __init__(self, bench: Bench) -> None:
        self.bench = bench

    def __hash__(self) -> int:
        return id(self.bench)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, _Hashed) and other.bench is self.bench

    def passage(self, pixels: Any, parameters: Any) -> Passage:
        given = [*(np.asarray(array) for array in pixels), np.asarray(parameters, dtype=np.float64)]
        held, latest = _LATEST.get(self.bench, (None, None))
        if held is None or latest is None or not all(map(np.array_equal, held, given)):
            latest = self.bench(*given[:-1], parameters=given[-1])
            _LATEST[self.bench] = [array.copy() for array in given], latest
        return latest


#: What went through each bench last.
_LATEST: WeakKeyDictionary[Bench, tuple[list[Any], Passage]] = WeakKeyDictionary()


def _like(shape: tuple[int, ...], dtype: Any) -> Any:
    return jax.ShapeDtypeStruct(shape, dtype)  # type: ignore[no-untyped-call]


def _complex() -> Any:
    return jnp.asarray(1j).dtype


@partial(jax.custom_vjp, nondiff_argnums=(0,))
def _field(held: _Hashed, pixels: Any, parameters: Any) -> Any:
    shape = _like(held.bench.shape, _complex())

    def carry(pixels: Any, parameters: Any) -> Any:
        return held.passage(pixels, parameters).field.astype(shape.dtype)

    return jax.pure_callback(carry, shape, pixels, parameters)


def _forward(held: _Hashed, pixels: Any, parameters: Any) -> Any:
    return _field(held, pixels, parameters), (pixels, parameters)


def _backward(held: _Hashed, kept: Any, bar: Any) -> Any:
    pixels, parameters = kept
    like = [_like(array.shape, array.dtype) for array in (*pixels, parameters)]

    # JAX's cotangents are the conjugates of the library's: ∂L/∂Re U − i ∂L/∂Im U.
    def go_back(pixels: Any, parameters: Any, bar: Any) -> Any:
        bars, slopes = held.passage(pixels, parameters).adjoint(np.conj(np.asarray(bar)))
        return [np.conj(one).astype(kind.dtype) for one, kind in zip([*bars, slopes], like)]

    back = jax.pure_callback(go_back, like, pixels, parameters, bar)
    return tuple(back[:-1]), back[-1]


_field.defvjp(_forward, _backward)
