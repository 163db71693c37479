"""Forms of pixels beside Rayleigh-Sommerfeld sums: by whole fields, by beamlets and by local bands, also where an
edge cuts the pixels."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import raylet

WAVE, PITCH, COUNT, DISTANCE = 0.5e-3, 8e-3, 24, 6.0

#: A side along pixels, and one that cuts them.
WHOLE, CUT = COUNT * PITCH, 0.1773


def nodes_of(edges: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Four Gauss nodes and their weights in each cell between some edges."""
    at, weight = np.polynomial.legendre.leggauss(4)
    half = 0.5 * np.diff(edges)[:, None]
    return (edges[:-1, None] + half * (1.0 + at)).ravel(), (half * weight).ravel()


def shares(form: str, x: np.ndarray) -> np.ndarray:
    """What each pixel [node, pixel] gives to the values at places."""
    place = x[:, None] / PITCH + 0.5 * (COUNT - 1) - np.arange(COUNT)
    if form == "box":
        return (abs(place) < 0.5).astype(float)
    if form == "bilinear":
        inside = np.clip(x / PITCH + 0.5 * (COUNT - 1), 0.0, COUNT - 1.0)
        return np.maximum(0.0, 1.0 - abs(inside[:, None] - np.arange(COUNT)))

    # A sinc under a window over the twelve samples around a place.
    below = np.floor(x / PITCH + 0.5 * (COUNT - 1))[:, None]
    seen = (np.arange(COUNT) > below - 6) & (np.arange(COUNT) <= below + 6)
    fall = np.exp(9.0 * (np.sqrt(np.maximum(0.0, 1.0 - (place / 6.0) ** 2)) - 1.0))
    return np.where(seen, np.sinc(place) * fall, 0.0)


def summed(transmission: np.ndarray, x: np.ndarray, weight: np.ndarray, points: np.ndarray) -> np.ndarray:
    """The field of a transmission at nodes x and x under a plane wave, at points [y, x] of a plane."""
    k = 2.0 * np.pi / WAVE
    lit = transmission * weight[:, None] * weight
    found = np.zeros((len(points), len(points)), complex)
    for j, b in enumerate(points):
        for i, a in enumerate(points):
            r = np.sqrt((a - x) ** 2 + (b - x)[:, None] ** 2 + DISTANCE**2)
            found[j, i] = (lit * np.exp(1j * k * r) * DISTANCE / r**2 * (1.0 / r - 1j * k)).sum() / (2.0 * np.pi)
    return found


@pytest.mark.parametrize("side", [WHOLE, CUT])
@pytest.mark.parametrize("form", ["box", "gaps", "bilinear", "band_limited"])
def test_a_form_of_pixels_is_as_summed(form: str, side: float) -> None:
    rng = np.random.default_rng(5)
    phase = rng.uniform(0.0, 2.0 * np.pi, (COUNT, COUNT))
    # Edges of pixels, of their halves and of their active areas, and of the aperture.
    steps = PITCH * (np.arange(2 * COUNT + 1) / 2 - 0.5 * COUNT)
    active = PITCH * (np.arange(COUNT) - 0.5 * (COUNT - 1)) + np.array([[-0.4], [0.4]]) * PITCH
    edges = np.unique(np.clip([*steps, *active.ravel(), -0.5 * side, 0.5 * side], -0.5 * side, 0.5 * side))
    x, weight = nodes_of(edges[np.append(True, np.diff(edges) > 1e-9)])
    share = shares("box" if form == "gaps" else form, x)
    transmission = share @ np.exp(1j * phase) @ share.T
    keys: dict[str, Any] = {"pixel": "box" if form == "gaps" else form}
    if form == "gaps":
        keys |= {"fill": 0.64, "rest": "flat"}
        place = x / PITCH + 0.5 * (COUNT - 1)
        inside = abs(place - np.round(place)) < 0.4
        transmission = np.where(inside[:, None] & inside, transmission, 1.0)

    system = raylet.System(wavelength_um=1e3 * WAVE)
    system.add_doe(
        raylet.pixels(pitch_um=1e3 * PITCH, phase=phase, **keys),
        aperture=raylet.rectangle(side, side),
        thickness_mm=DISTANCE,
    ).add_sensor(pixels=(8, 8), pitch_um=40.0)
    exact = summed(transmission, x, weight, 0.04 * (np.arange(8) - 3.5))
    for method, limit in (("auto", 2e-5), ("beamlet", 8e-4), ("local_bands", 8e-4)):
        found = system.simulate(method=method)
        off = np.linalg.norm(found.field - exact) / np.linalg.norm(exact)
        assert off < limit, (method, off)
        assert off < 2.0 * found.error + 2e-5, (method, off, found.error)
