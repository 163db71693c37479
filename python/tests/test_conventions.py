"""What the guide's page on conventions says and other tests do not hold; mirrors against surface integrals."""

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


def over_rectangle(half_x: float, half_y: float, nodes: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    place, weight = np.polynomial.legendre.leggauss(nodes)
    x, y = np.meshgrid(half_x * place, half_y * place)
    return x.ravel(), y.ravel(), np.outer(half_y * weight, half_x * weight).ravel()


def over_disc(radius: float, rings: int, spokes: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    place, weight = np.polynomial.legendre.leggauss(rings)
    r, turn = np.meshgrid(0.5 * radius * (place + 1.0), np.arange(spokes) * 2.0 * np.pi / spokes, indexing="ij")
    share = np.outer(0.5 * radius * weight, np.full(spokes, 2.0 * np.pi / spokes)) * r
    return (r * np.cos(turn)).ravel(), (r * np.sin(turn)).ravel(), share.ravel()


def radiated(k: float, field: np.ndarray, at: np.ndarray, normal: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Rayleigh and Sommerfeld's first integral: `field` on a surface with its weights, normals over unit x, y areas."""
    sums = []
    for point in points:
        way = point - at
        length = np.linalg.norm(way, axis=1)
        kernel = np.sum(normal * way, axis=1) / (2.0 * np.pi * length**2) * (1.0 / length - 1j * k)
        sums.append(np.sum(field * kernel * np.exp(1j * k * length)))
    return np.array(sums)


def mirror(radius: float, vertex: float, x: np.ndarray, y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Places on a spherical mirror, and its normals towards −z."""
    square = x**2 + y**2
    root = np.sqrt(1.0 - square / radius**2)
    z = vertex + square / radius / (1.0 + root)
    return np.stack([x, y, z], axis=1), np.stack([x / radius / root, y / radius / root, -np.ones_like(x)], axis=1)


def close(found: np.ndarray, exact: np.ndarray) -> float:
    """The distance of two fields but for one phase."""
    turned = found * np.exp(1j * np.angle(np.vdot(found, exact)))
    return float(np.linalg.norm(turned - exact) / np.linalg.norm(exact))


def test_a_bare_mirror_in_slanting_light_is_a_surface_integral() -> None:
    """Light at 5° on a mirror of 6 mm that comes first: its rim cuts the light once."""
    k, slant = 2.0 * np.pi / 0.5e-3, np.radians(5.0)
    aside = 30.0 * np.tan(slant)
    system = raylet.System(wavelength_um=0.5)
    system.plane_wave(angle_deg=(5.0, 0.0))
    system.add_mirror(radius_mm=-60.0, semi_aperture_mm=3.0, thickness_mm=-30.0)
    system.add_sensor(pixels=(64, 64), pitch_um=2.0, decenter_mm=(aside, 0.0))
    result = system.simulate()
    x, y, weight = over_disc(3.0, 400, 1200)
    at, normal = mirror(-60.0, 0.0, x, y)
    light = weight * np.exp(1j * k * (np.sin(slant) * at[:, 0] + np.cos(slant) * at[:, 2]))
    points = np.stack([aside + result.x_mm, np.full(64, result.y_mm[34]), np.full(64, -30.0)], axis=1)
    assert close(result.field[34], radiated(k, light, at, normal, points)) < 1e-3


def test_a_rectangular_rim_is_a_surface_integral() -> None:
    """A mirror of 140 λ by 100 λ, curved, in the light of a stop of 200 λ."""
    k = 2.0 * np.pi / 0.5e-3
    system = raylet.System(wavelength_um=0.5)
    system.add_stop(raylet.disc(0.05), thickness_mm=0.4)
    system.add_mirror(radius_mm=-2.0, aperture=raylet.rectangle(0.07, 0.05), thickness_mm=-0.5)
    system.add_sensor(pixels=(64, 64), pitch_um=1.5)
    result = system.simulate()
    u, v, stop = over_disc(0.05, 60, 200)
    from_stop = np.stack([u, v, np.zeros_like(u)], axis=1)
    ahead = np.tile([0.0, 0.0, 1.0], (len(u), 1))
    x, y, weight = over_rectangle(0.035, 0.025, 90)
    at, normal = mirror(-2.0, 0.4, x, y)
    light = weight * radiated(k, stop, from_stop, ahead, at)
    points = np.stack([result.x_mm, np.full(64, result.y_mm[40]), np.full(64, -0.1)], axis=1)
    assert close(result.field[40], radiated(k, light, at, normal, points)) < 1e-3
