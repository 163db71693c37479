"""Kinoforms, tables and functions: smooth phases of one's own. Kinoforms are blazed and stepped profiles with their
diffraction orders."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import raylet

PERIOD, LEVELS = 50, 5


def behind(layer: dict[str, Any], method: str) -> Any:
    """The field 10 mm behind an element at 0.45 µm."""
    system = raylet.System(wavelength_um=0.45).add_doe(layer, aperture=raylet.disc(0.2), thickness_mm=10.0)
    return system.add_sensor(pixels=(41, 31), pitch_um=5.0).simulate(method=method).field


@pytest.mark.parametrize("method", ["auto", "local_bands"])
def test_orders_of_a_stepped_grating_are_its_pixels(method: str) -> None:
    """A grating of 50 µm in five steps, made for 0.5 µm, is the same as pixels of 1 µm that make these steps."""
    number = (np.arange(400) % PERIOD) * LEVELS // PERIOD
    phase = np.broadcast_to(2.0 * np.pi * (0.5 / 0.45) * number / LEVELS, (400, 400))
    exact = behind(raylet.pixels(pitch_um=1.0, phase=phase), "auto")
    own = {"orders": range(-12, 13), "levels": LEVELS, "wavelength_um": 0.5}
    found = behind(raylet.kinoform([raylet.grating(period_um=PERIOD)], **own), method)
    error = np.linalg.norm(found - exact) / np.linalg.norm(exact)
    assert error < 2e-3, error


def hybrid(orders: list[int]) -> Any:
    """A lens of 6 mm with a kinoform on its back, at a wavelength for which it is not made."""
    kinoform = raylet.kinoform(
        [raylet.lens(focal_length_mm=60.0)],
        orders=orders,
        wavelength_um=0.55,
        glass={"nd": 1.49, "vd": 57.0},
        stands_in="behind",
    )
    system = raylet.System(wavelength_um=0.5)
    system.add_stop(raylet.disc(0.7), thickness_mm=0.5)
    system.add_surface(radius_mm=4.0, glass="N-BK7", thickness_mm=1.0, semi_aperture_mm=1.0)
    system.add_doe(kinoform, glass="air", aperture=raylet.disc(0.4), thickness_mm=6.4, name="back")
    return system.add_sensor(pixels=(48, 48), pitch_um=0.5)


def test_orders_on_a_lens_add() -> None:
    """Light is linear: that of three orders is the sum of the three, each carried on its own."""
    together = hybrid([0, 1, 2]).simulate()
    alone = [hybrid([order]).simulate().field for order in (0, 1, 2)]
    assert together.methods[-1] == "local_bands"
    error = np.linalg.norm(together.field - sum(alone)) / np.linalg.norm(together.field)
    assert error < 1e-3, error
    shares = [np.linalg.norm(field) ** 2 for field in alone]
    assert shares[1] > 50.0 * max(shares[0], shares[2])


def test_rays_follow_the_strongest_order() -> None:
    all_orders, first = hybrid([0, 1, 2]).trace(Px=0.3), hybrid([1]).trace(Px=0.3)
    assert all_orders.x[-1] == pytest.approx(first.x[-1], abs=1e-12)
    assert abs(hybrid([2]).trace(Px=0.3).x[-1] - first.x[-1]) > 1e-3


def test_what_no_profile_does_is_refused() -> None:
    axicon = raylet.kinoform([raylet.axicon(angle_deg=1.0)])
    with pytest.raises(
        raylet.RayletError, match=r"layer\[0\].layer\[0\].kind: found a layer that is no analytic phase"
    ):
        behind(axicon, "auto")
    with pytest.raises(raylet.RayletError, match=r"levels: found 1, expected from 2 to 65536 steps"):
        behind(raylet.kinoform([raylet.vortex(charge=1)], levels=1), "auto")


def through(layer: dict[str, Any], method: str) -> Any:
    """The field near the focus of an element at 0.5 µm."""
    system = raylet.System(wavelength_um=0.5).add_doe(layer, aperture=raylet.disc(0.4), thickness_mm=20.0)
    return system.add_sensor(pixels=(41, 41), pitch_um=4.0).simulate(method=method).field


@pytest.mark.parametrize("method", ["auto", "local_bands"])
def test_tables_and_functions_are_what_they_sample(method: str) -> None:
    """A radial phase by a formula, by a table and by a function, off centre: splines err by 2e-6 rad or less here."""
    own = {"centre_mm": (0.05, -0.03), "rotation_deg": 20.0}
    exact = through(raylet.radial(norm_radius_mm=0.4, coefficients=[-50.0, 9.0], **own), method)

    def phase(square: Any) -> Any:
        return -50.0 * square / 0.16 + 9.0 * (square / 0.16) ** 2

    radius = np.linspace(0.0, 0.5, 101)
    calls = []

    def function(x: Any, y: Any) -> Any:
        calls.append((x.shape, y.shape))
        return phase(x**2 + y**2)

    for layer in (
        raylet.radial_table(radius_mm=radius, phase_rad=phase(radius**2), **own),
        raylet.phase_function(function, extent_mm=1.0, **own),
        raylet.phase_function(function, extent_mm=(1.0, 1.2), pitch_um=10.0, **own),
    ):
        error = np.linalg.norm(through(layer, method) - exact) / np.linalg.norm(exact)
        assert error < 1e-5, error
    assert calls == [((1, 257), (257, 1)), ((1, 101), (121, 1))]


def test_surfaces_may_be_functions() -> None:
    """A sphere as a function is the sphere."""

    def focus(**shape: Any) -> Any:
        system = raylet.System(wavelength_um=0.5).add_stop(raylet.disc(0.5), thickness_mm=0.5)
        system.add_surface(glass="N-BK7", semi_aperture_mm=0.8, thickness_mm=1.0, **shape)
        system.add_surface(semi_aperture_mm=0.8, thickness_mm=18.0)
        return system.add_sensor(pixels=(31, 31), pitch_um=2.0).simulate(method="beamlet").field

    sphere = raylet.sag_function(lambda x, y: 10.0 - np.sqrt(100.0 - x**2 - y**2), extent_mm=1.8)
    found, exact = focus(shape=sphere), focus(radius_mm=10.0)
    error = np.linalg.norm(found - exact) / np.linalg.norm(exact)
    assert error < 1e-3, error


def test_functions_that_fail_name_the_call_and_the_argument() -> None:
    def raising(x: Any, y: Any) -> Any:
        raise KeyError("lost")

    for function, words in [
        (raising, r"raylet.phase_function: phase\(x, y\) raised KeyError: 'lost', expected \(11, 11\) numbers"),
        (lambda x, y: np.zeros(3), r"phase\(x, y\) has shape \(3,\), expected \(11, 11\)"),
        (lambda x, y: np.sqrt(x + 0 * y), r"phase\(x, y\) is nan at x = -0.5 mm, y = -0.5 mm, expected finite"),
        (lambda x, y: 1j * x, r"phase\(x, y\) is complex, expected real numbers"),
        (3.0, r"raylet.phase_function: phase is float, expected a function"),
    ]:
        with np.errstate(invalid="ignore"), pytest.raises((raylet.RayletError, TypeError), match=words):
            raylet.phase_function(function, extent_mm=1.0, pitch_um=100.0)
    for keys, words in [
        ({"extent_mm": 0.0}, "raylet.sag_function: extent_mm is 0.0, expected a number above zero"),
        ({"extent_mm": 1.0, "pitch_um": 1e-3}, "raylet.sag_function: pitch_um makes 1000001 samples"),
    ]:
        with pytest.raises(raylet.RayletError, match=words):
            raylet.sag_function(lambda x, y: x, **keys)
    small = raylet.phase_function(lambda x, y: x, extent_mm=0.7)
    with pytest.raises(raylet.RayletError, match=r"layer\[0\].phase: found samples up to 0.35.* expected up to 0.4"):
        through(small, "auto")
    table = raylet.radial_table(radius_mm=[0, 0.1, 0.2, 0.3], phase_rad=[0, 1, 2, 3])
    with pytest.raises(raylet.RayletError, match=r"layer\[0\].radius_mm: found radii up to 0.3 mm, expected up to 0.4"):
        through(table, "auto")
