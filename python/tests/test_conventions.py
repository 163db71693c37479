"""The statements of the guide's page on conventions that other tests do not hold."""

from __future__ import annotations

import numpy as np
import pytest

import raylet


def test_plane_waves_grow_as_exp_ikz() -> None:
    """Light at an angle has the phase exp(ikx sin a) across the sensor, and exp(ikz cos a) along the axis."""
    system = raylet.System(wavelength_um=0.5).plane_wave(angle_deg=(1.0, 0.0))
    result = system.add_stop(raylet.disc(0.1), thickness_mm=0.2).add_sensor(pixels=(41, 1), pitch_um=2.0).simulate()
    k, x, z = 2 * np.pi / 0.5e-3, result.x_mm, 0.2
    wave = np.exp(1j * k * (x * np.sin(np.radians(1.0)) + z * np.cos(np.radians(1.0))))
    assert np.vdot(wave, result.field[0]) / 41 == pytest.approx(1.0, abs=0.1)


def test_radii_are_positive_towards_larger_z() -> None:
    """A convex first face has a positive radius and focuses."""

    def heading(radius_mm: float) -> float:
        system = raylet.System(wavelength_um=0.5)
        system.add_surface(radius_mm=radius_mm, thickness_mm=10.0, glass=1.5, semi_aperture_mm=5.0)
        system.add_surface(semi_aperture_mm=8.0, thickness_mm=1.0).add_sensor(pixels=(2, 2), pitch_um=1.0)
        return float(system.trace(Px=0.5).L[1, 0])

    assert heading(20.0) < 0.0 < heading(-20.0)


def test_thicknesses_turn_round_behind_a_mirror() -> None:
    system = raylet.System(wavelength_um=0.5)
    system.add_mirror(radius_mm=-40.0, thickness_mm=-20.0, semi_aperture_mm=2.0)
    system.add_sensor(pixels=(2, 2), pitch_um=1.0)
    rays = system.trace(Px=[0.1, 0.2])
    assert rays.z[-1] == pytest.approx([-20.0, -20.0]) and np.abs(rays.x[-1]).max() < 1e-3
    assert (rays.N[1] < 0.0).all()


def test_tilts_are_right_handed() -> None:
    """Turned about +x the z axis goes towards −y: a mirror so turned sends light there, twice as far."""
    system = raylet.System(wavelength_um=0.5)
    system.add_mirror(semi_aperture_mm=2.0, tilt_deg=(1.0, 0.0, 0.0), thickness_mm=-10.0)
    system.add_sensor(pixels=(2, 2), pitch_um=1.0)
    rays = system.trace()
    assert rays.M[1, 0] == pytest.approx(np.sin(np.radians(2.0)))


def test_power_is_absolute() -> None:
    """∫|U|² behind an aperture is its area, for a source of amplitude one."""
    system = raylet.System(wavelength_um=0.5).add_stop(raylet.rectangle(0.2, 0.1), thickness_mm=0.5)
    result = system.add_sensor(pixels=(100, 60), pitch_um=4.0).simulate()
    assert result.intensity.sum() * 16e-6 == pytest.approx(0.02, rel=2e-2)
