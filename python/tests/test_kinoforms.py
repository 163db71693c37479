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
    with pytest.raises(raylet.RayletError, match=r"kinoform: layer\[0\].kind: found a layer that is no analytic phase"):
        raylet.kinoform([raylet.axicon(angle_deg=1.0)])
    with pytest.raises(raylet.RayletError, match=r"levels: found 1, expected from 2 to 65536 steps"):
        behind(raylet.kinoform([raylet.vortex(charge=1)], levels=1), "auto")


def through(layer: dict[str, Any], method: str) -> Any:
    """The field near the focus of an element at 0.5 µm."""
    system = raylet.System(wavelength_um=0.5).add_doe(layer, aperture=raylet.disc(0.4), thickness_mm=20.0)
    return system.add_sensor(pixels=(41, 41), pitch_um=4.0).simulate(method=method).field


@pytest.mark.parametrize("method", ["auto", "local_bands"])
def test_tables_and_functions_are_what_they_sample(method: str) -> None:
    """A radial phase by a formula, by a table and by a function, off centre: off by 3e-7 in whole fields."""
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
        assert error < 2e-6, error
    assert calls == [((1, 257), (257, 1)), ((1, 101), (121, 1))]


def test_samples_are_saved_and_folded(tmp_path: Any) -> None:
    """A grid of samples comes back from its file, and kinoforms take tables and grids as they take formulas."""
    radius = np.linspace(0.0, 0.5, 101)
    table = raylet.radial_table(radius_mm=radius, phase_rad=-300.0 * radius**2)
    grid = raylet.phase_function(lambda x, y: -300.0 * (x**2 + y**2), extent_mm=1.0, pitch_um=20.0)
    powers = raylet.radial(norm_radius_mm=1.0, coefficients=[-300.0])
    fields = []
    for layer in (powers, table, grid):
        folded = raylet.kinoform([layer], orders=[0, 1], wavelength_um=0.55)
        system = raylet.System(wavelength_um=0.5).add_doe(folded, aperture=raylet.disc(0.3), thickness_mm=20.0)
        system.add_sensor(pixels=(21, 21), pitch_um=4.0).save(tmp_path / "scene.toml", overwrite=True)
        fields.append(system.simulate().field)
        assert np.array_equal(raylet.load(tmp_path / "scene.toml").simulate().field, fields[-1])
    for found in fields[1:]:
        assert np.linalg.norm(found - fields[0]) < 1e-6 * np.linalg.norm(fields[0])


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


PITCH, STEPS, FOCAL, WAVE = 8.0, 8, 50.0, 0.532


def share_of_first_order(fly_back_um: float, crosstalk_um: float) -> float:
    """The share of the light in the first order of a blazed grating of pixels, by a Fourier sum over one period."""
    fine = 512
    x = (np.arange(STEPS * fine) + 0.5) / fine
    phase = 2.0 * np.pi * np.floor(x) / STEPS
    edge, width = (x + 0.5 * STEPS) % STEPS - 0.5 * STEPS, max(fly_back_um / PITCH, 1e-12)
    phase = np.where(np.abs(edge) < 0.5 * width, 2.0 * np.pi * (1.0 - 1.0 / STEPS) * (0.5 - edge / width), phase)
    turns = np.fft.fftfreq(len(x), 1.0 / fine)
    gauss = np.exp(-0.5 * (2.0 * np.pi * turns * crosstalk_um / PITCH) ** 2)
    phase = np.fft.ifft(np.fft.fft(phase) * gauss).real
    return float(np.abs(np.mean(np.exp(1j * phase - 2j * np.pi * x / STEPS))) ** 2)


@pytest.mark.parametrize("method", ["auto", "local_bands"])
@pytest.mark.parametrize("keys", [(0.0, 0.0), (6.0, 0.0), (0.0, 1.6), (2.0, 3.0)])
def test_fly_back_and_crosstalk_take_light_from_the_first_order(keys: tuple[float, float], method: str) -> None:
    """A modulator with a lens: the peak of the first order over that of the zero order of an even phase. Eight parts of
    a pixel, 64 of a period, weaken a smooth order by 2/3 (π/64)² = 1.6e-3."""
    between = {"fly_back_um": keys[0], "crosstalk_um": keys[1], "sub_pixels": 8}

    def peak(phase: Any, order: int) -> float:
        row = np.broadcast_to(phase, (72, 72))
        layers = raylet.pixels(pitch_um=PITCH, phase=row, **between), raylet.lens(focal_length_mm=FOCAL)
        aside = FOCAL * np.tan(np.arcsin(order * WAVE / (STEPS * PITCH)))
        system = raylet.System(wavelength_um=WAVE)
        system.add_doe(*layers, aperture=raylet.rectangle(0.512, 0.512), thickness_mm=FOCAL)
        system.add_sensor(pixels=(3, 3), pitch_um=1.0, decenter_mm=(aside, 0.0))
        return float(system.simulate(method=method).intensity[1, 1])

    found = peak(2.0 * np.pi * (np.arange(72) % STEPS) / STEPS, 1) / peak(np.zeros(72), 0)
    exact = share_of_first_order(*keys)
    assert found == pytest.approx(exact, rel=2e-3), (found, exact)


def test_pixels_with_crosstalk_are_not_designed() -> None:
    layer = raylet.pixels(pitch_um=PITCH, size=(8, 8), crosstalk_um=1.0)
    system = raylet.System(wavelength_um=WAVE).add_doe(layer, aperture=raylet.disc(0.03), thickness_mm=5.0, name="slm")
    system.add_sensor(pixels=(8, 8), pitch_um=8.0)
    words = (
        r"add_doe, element\[0\] 'slm': layer\[0\].crosstalk_um: found 1, expected 0 where pixels are found or varied"
    )
    with pytest.raises(raylet.RayletError, match=words):
        system.linearised("slm")
    with pytest.raises(raylet.RayletError, match=words):
        system.hologram(target=np.eye(8), element="slm", size_mm=(0.06, 0.06))
    with pytest.raises(raylet.RayletError, match=words):
        system.design(
            element=[{"name": "slm"}], loss=[{"kind": "likeness", "picture": np.eye(8), "size_mm": [0.06, 0.06]}]
        )
