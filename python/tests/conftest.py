"""What several tests look at."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import raylet

ROOT = Path(__file__).resolve().parents[2]


@pytest.fixture
def scenes() -> Path:
    return ROOT / "scenes"


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Tests that need PyTorch can be chosen by `-m torch`."""
    for item in items:
        if "torch" in getattr(item, "fixturenames", ()):
            item.add_marker("torch")


def noise(shape: tuple[int, ...], seed: int = 0) -> np.ndarray:
    """Phases in rad, the same every time."""
    return np.random.default_rng(seed).uniform(0.0, 2.0 * np.pi, shape)


def hologram(phase: np.ndarray, pixels: tuple[int, int] = (24, 20)) -> raylet.System:
    """A small hologram in free space."""
    ny, nx = phase.shape
    return (
        raylet.System(wavelength_um=0.7)
        .add_doe(
            raylet.pixels(pitch_um=4.0, phase=phase),
            aperture=raylet.rectangle(4e-3 * nx, 4e-3 * ny),
            thickness_mm=2.0,
            name="hologram",
        )
        .add_sensor(pixels=pixels, pitch_um=5.0)
    )


def through_lens(phase: np.ndarray, pixels: tuple[int, int] = (16, 12)) -> raylet.System:
    """A small hologram before a plano-convex lens."""
    ny, nx = phase.shape
    return (
        raylet.System(wavelength_um=0.7)
        .add_doe(
            raylet.pixels(pitch_um=8.0, phase=phase),
            aperture=raylet.rectangle(8e-3 * nx, 8e-3 * ny),
            thickness_mm=1.0,
            name="hologram",
        )
        .add_surface(radius_mm=5.0, thickness_mm=1.0, glass=1.5, semi_aperture_mm=1.0)
        .add_surface(semi_aperture_mm=1.0, thickness_mm=9.0)
        .add_sensor(pixels=pixels, pitch_um=8.0)
    )
