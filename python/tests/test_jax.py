"""Gradients inside JAX."""

from __future__ import annotations

import numpy as np
import pytest
from conftest import hologram, noise, through_lens

jax = pytest.importorskip("jax")
jax.config.update("jax_enable_x64", True)
import jax.numpy as jnp  # noqa: E402

import raylet.jax  # noqa: E402


def test_wrong_shapes_are_refused_before_anything_runs() -> None:
    linearised = hologram(noise((6, 6))).linearised("hologram")
    with pytest.raises(ValueError, match=r"shape \(5, 6\), expected \(6, 6\)"):
        raylet.jax.field(linearised, noise((5, 6)))


def test_gradient_matches_differences() -> None:
    linearised = hologram(noise((4, 5)), pixels=(5, 4)).linearised("hologram")
    weight = jnp.asarray(noise((4, 5), 3))

    def loss(phase: object) -> object:
        field = raylet.jax.field(linearised, phase)
        return jnp.sum(weight * jnp.abs(field) ** 2) + jnp.sum(weight * field.real) - jnp.sum(field.imag)

    phase, step = noise((4, 5), 1), 1e-6
    gradient = jax.grad(loss)(jnp.asarray(phase))
    for at in [(0, 0), (2, 3), (3, 4)]:
        moved = np.zeros((4, 5))
        moved[at] = step
        slope = (loss(jnp.asarray(phase + moved)) - loss(jnp.asarray(phase - moved))) / (2 * step)
        assert abs(gradient[at] - slope) < 1e-7 * max(1.0, float(jnp.abs(gradient).max()))


def test_complex_transmissions_descend() -> None:
    """JAX's gradient of a complex parameter is the conjugate of the steepest ascent."""
    linearised = hologram(noise((4, 5)), pixels=(5, 4)).linearised("hologram")

    def loss(t: object) -> object:
        return jnp.sum(raylet.jax.intensity(linearised, t)[1:3, 2])

    start = jnp.asarray(np.exp(1j * noise((4, 5), 2)))
    gradient, step = jax.grad(loss)(start), 1e-6
    ascent = jnp.conj(gradient)
    gained = (loss(start + step * ascent) - loss(start - step * ascent)) / (2 * step)
    assert float(gained) == pytest.approx(float(jnp.sum(jnp.abs(ascent) ** 2)), rel=1e-6)


def test_parameters_and_jit() -> None:
    system = through_lens(noise((3, 4)), pixels=(4, 3))
    linearised = system.linearised("hologram", parameters=["element[1].radius_mm"])
    phase = jnp.asarray(noise((3, 4)))

    @jax.jit
    def loss(parameters: object) -> object:
        return jnp.sum(raylet.jax.intensity(linearised, phase, parameters=parameters)[1])

    start, step = jnp.asarray(linearised.start), 1e-6
    slope = (loss(start + step) - loss(start - step)) / (2 * step)
    assert float(jax.grad(loss)(start)[0]) == pytest.approx(float(slope), rel=1e-5)
