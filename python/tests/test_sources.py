"""Light of lasers, laser diodes, fibres and extended sources."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import raylet


def gaussian(x: Any, w: float, z: float, k: float) -> Any:
    """One axis of a Gaussian beam at a distance z from its waist."""
    q = z - 0.5j * k * w * w
    return np.sqrt(-0.5j * k * w * w / q) * np.exp(0.5j * k * x * x / q)


def test_a_tapered_beam_is_a_gaussian_beam_in_its_waist() -> None:
    """Two lines at right angles: the taper's axes turned by 90°."""
    system = (
        raylet.System(wavelength_um=0.5)
        .plane_wave(taper=raylet.beam_taper((0.05, 0.08), rotation_deg=90.0, centre_mm=(0.01, 0.0)))
        .add_stop(raylet.disc(0.5), thickness_mm=20.0)
        .add_sensor(pixels=(41, 41), pitch_um=20.0)
    )
    result, k = system.simulate(), 2e3 * np.pi / 0.5
    x, y = result.x_mm - 0.01, result.y_mm[:, None]
    exact = gaussian(x, 0.08, 20.0, k) * gaussian(y, 0.05, 20.0, k) * np.exp(20j * k)
    assert np.linalg.norm(result.field - exact) < 1e-3 * np.linalg.norm(exact)


def test_a_tapered_cone_has_an_aperture_or_angles() -> None:
    def field(**keys: Any) -> Any:
        system = raylet.System(wavelength_um=0.5).point_source((0.0, 0.0, -2.0), taper=raylet.cone_taper(**keys))
        system.add_stop(raylet.disc(0.2), thickness_mm=5.0)
        return system.add_sensor(pixels=(16, 16), pitch_um=20.0).simulate().field

    by_angle = field(half_angle_deg=(3.0, 5.0))
    by_aperture = field(numerical_aperture=tuple(np.sin(np.radians((3.0, 5.0)))))
    assert np.linalg.norm(by_angle - by_aperture) < 1e-9 * np.linalg.norm(by_angle)
    for wrong, words in [({}, "neither"), ({"half_angle_deg": 3.0, "numerical_aperture": 0.1}, "both")]:
        with pytest.raises(raylet.RayletError, match=f"source.taper: found {words}"):
            field(**wrong)
