"""Rays of another tracer: scatter and gather against the library's own runs, and their transposes."""

from __future__ import annotations

import numpy as np
import pytest
from conftest import hologram, noise

import raylet

WAVE, FOCUS = 0.7, 50.0
K = 2.0 * np.pi / (1e-3 * WAVE)


def focusing(element: dict) -> raylet.System:
    system = raylet.System(wavelength_um=WAVE)
    system.add_doe(
        element, raylet.lens(focal_length_mm=FOCUS), aperture=raylet.disc(0.5), thickness_mm=FOCUS, name="doe"
    )
    return system.add_sensor(pixels=(31, 25), pitch_um=5.0)


def lattice(sigma: float) -> np.ndarray:
    places = 1.4 * sigma * np.arange(-8, 9)
    x, y = np.meshgrid(places, places)
    return np.stack([x.ravel(), y.ravel(), np.zeros(x.size)], 1)


def fly(made: raylet.Secondary) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Empty space, by hand: places, paths and Jacobians on the sensor."""
    a, b, c = made.direction.T
    length = (FOCUS - made.position[:, 2]) / c
    landed = made.position + length[:, None] * made.direction
    cross, zero, one = length * a * b / c**2, np.zeros_like(a), np.ones_like(a)
    rows = [
        [one, zero, length * (1 + a**2 / c**2), cross],
        [zero, one, cross, length * (1 + b**2 / c**2)],
        [zero, zero, one, zero],
        [zero, zero, zero, one],
    ]
    return landed, made.path_mm + length, np.moveaxis(np.array(rows), -1, 0)


@pytest.fixture(scope="module")
def stage() -> tuple[raylet.System, raylet.Secondary]:
    system = focusing(raylet.pixels(pitch_um=50.0, phase=noise((20, 20))))
    position = lattice(0.08)
    along = np.tile([0.0, 0.0, 1.0], (len(position), 1))
    made = raylet.scatter(
        system, "doe", position, along, sigma_mm=0.08, towards=(-0.04, 0.04, -0.04, 0.04), threshold=0.0
    )
    return system, made


def gathered(stage: tuple[raylet.System, raylet.Secondary], weight: np.ndarray) -> np.ndarray:
    system, made = stage
    landed, path, jacobian = fly(made)
    way = {"jacobian": jacobian, "window": made.window, "cosine": made.cosine}
    beams = raylet.beams(system, landed, made.direction, **way)
    return raylet.gather(system, landed, made.direction, path, weight, beams=beams, tolerance=1e-4)


def test_rays_that_memory_has_no_room_for_are_refused() -> None:
    system = hologram(noise((20, 20))).settings(memory_limit_mb=21.0)
    position = np.zeros((200, 3))
    direction = np.tile([0.0, 0.0, 1.0], (200, 1))
    with pytest.raises(raylet.RayletError, match="more than 52500 secondary rays"):
        raylet.scatter(system, "hologram", position, direction, sigma_mm=0.02, threshold=0.0)


def test_rays_give_what_the_library_gives(stage: tuple[raylet.System, raylet.Secondary]) -> None:
    system, made = stage
    assert made.unevenness < 1.5 and "rays from" in repr(made)
    own = system.simulate().field
    foreign = gathered(stage, made.weight)
    assert np.linalg.norm(foreign - own) < 2e-3 * np.linalg.norm(own)


def test_an_interface_scatters_into_the_medium_behind_it() -> None:
    """On the flat back of a block of glass cosines along it add up: those in the glass and of the grating."""
    index, period, slant = 1.5, 20.0, 0.1
    system = raylet.System(wavelength_um=WAVE)
    system.add_surface(radius_mm=np.inf, glass=index, semi_aperture_mm=2.0, thickness_mm=1.0)
    system.add_doe(
        raylet.grating(period_um=period),
        glass="air",
        aperture=raylet.disc(0.5),
        thickness_mm=FOCUS,
        name="back",
    )
    system.add_sensor(pixels=(31, 25), pitch_um=5.0)
    position = lattice(0.08) + [0.0, 0.0, 1.0]
    along = np.tile([slant, 0.0, np.sqrt(1.0 - slant**2)], (len(position), 1))
    path = index * slant * position[:, 0]
    made = raylet.scatter(system, "back", position, along, path, sigma_mm=0.08, towards=(0.0, 0.4, -0.1, 0.1))
    share = abs(made.weight) ** 2
    found = np.array([np.average(made.direction[:, axis], weights=share) for axis in (0, 1)])
    np.testing.assert_allclose(found, [index * slant + WAVE / period, 0.0], atol=2e-4)
    np.testing.assert_allclose(np.linalg.norm(made.direction, axis=1), 1.0, atol=1e-12)


def test_gather_is_transposed(stage: tuple[raylet.System, raylet.Secondary]) -> None:
    """⟨bar, G w⟩ = ⟨Gᴴ bar, w⟩ for the weights."""
    system, made = stage
    landed, path, jacobian = fly(made)
    way = {"jacobian": jacobian, "window": made.window, "cosine": made.cosine}
    beams = raylet.beams(system, landed, made.direction, **way)
    bar = np.exp(1j * noise((25, 31), 1))
    back = raylet.gather_adjoint(system, landed, made.direction, path, made.weight, bar, beams=beams, tolerance=1e-4)
    other = made.weight * np.exp(1j * noise(made.weight.shape, 2))
    left, right = np.vdot(bar, gathered(stage, other)), np.vdot(back.weight, other)
    assert abs(left - right) < 1e-12 * abs(left)
    assert back.at.shape == back.cosines.shape == (len(made), 2) and back.curvature.shape == (len(made), 3)


def test_scatter_is_transposed(stage: tuple[raylet.System, raylet.Secondary]) -> None:
    """Weights change with the element's phases as the transpose says."""
    system, made = stage
    bar = np.exp(1j * noise(made.weight.shape, 3))
    by_pixels, by_weight = made.adjoint(bar)
    assert by_pixels is not None and by_weight.shape == (17 * 17,)
    phase, moved, step = noise((20, 20)), noise((20, 20), 4) - np.pi, 1e-6
    position = lattice(0.08)
    along = np.tile([0.0, 0.0, 1.0], (len(position), 1))

    def weights(by: float) -> np.ndarray:
        other = system.with_pixels("doe", phase=phase + by * moved)
        choices = {"sigma_mm": 0.08, "towards": (-0.04, 0.04, -0.04, 0.04), "threshold": 0.0}
        return raylet.scatter(other, "doe", position, along, **choices).weight

    slope = np.vdot(bar, (weights(step) - weights(-step)) / (2 * step)).real
    exact = np.sum((by_pixels * np.exp(-1j * phase)).imag * moved)
    assert exact == pytest.approx(slope, rel=1e-7)


def test_wrong_rays_are_refused() -> None:
    system = focusing(raylet.vortex(charge=1))
    with pytest.raises(raylet.RayletError, match=r"direction\[0\] has length"):
        raylet.scatter(system, "doe", [[0.0, 0.0, 0.0]], [[0.0, 0.0, 2.0]], sigma_mm=0.1)
    with pytest.raises(ValueError, match=r"direction has shape \(2, 3\), expected \(1, 3\)"):
        raylet.scatter(system, "doe", [[0.0, 0.0, 0.0]], [[0.0, 0.0, 1.0]] * 2, sigma_mm=0.1)
    with pytest.raises(raylet.RayletError, match="no element is called 'lens'"):
        raylet.scatter(system, "lens", [[0.0, 0.0, 0.0]], [[0.0, 0.0, 1.0]], sigma_mm=0.1)
    with pytest.raises(ValueError, match="expected 'beamlet', 'prefactor' or 'plain'"):
        raylet.gather(system, [[0.0, 0.0, FOCUS]], [[0.0, 0.0, 1.0]], 0.0, 1.0, wavelet="ray")
