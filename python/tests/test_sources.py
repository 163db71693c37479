"""Light of lasers, laser diodes, fibres and extended sources."""

from __future__ import annotations

import re
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
        with pytest.raises(raylet.RayletError, match=f"raylet.cone_taper: found {words}"):
            field(**wrong)


def test_a_field_of_a_function_an_array_and_a_file_are_one(tmp_path: Any) -> None:
    """A Gaussian on a tilted plane lands where its normal points, as wide as its closed form."""
    k, w, z, tilt = 2e3 * np.pi / 0.5, 0.02, 4.0, 3.0

    def system(samples: Any, **keys: Any) -> raylet.System:
        own = raylet.System(wavelength_um=0.5)
        own.field_source(samples, pitch_um=4.0, distance_mm=z, tilt_deg=(0.0, tilt, 0.0), **keys)
        offset = z * np.tan(np.radians(tilt))
        return own.add_sensor(pixels=(24, 24), pitch_um=6.0, decenter_mm=(offset, 0.0), tilt_deg=(0.0, tilt, 0.0))

    result = system(lambda x, y: np.exp(-(x**2 + y**2) / w**2), size=(32, 30)).simulate()
    way = z / np.cos(np.radians(tilt))
    exact = gaussian(result.x_mm, w, way, k) * gaussian(result.y_mm[:, None], w, way, k) * np.exp(1j * k * way)
    error = np.linalg.norm(result.field - exact) / np.linalg.norm(exact)
    assert error < 6e-5, error
    assert result.power_share[0] == pytest.approx(1.0, abs=1e-3)
    x, y = (4e-3 * (np.arange(n) - 0.5 * (n - 1)) for n in (32, 30))
    array = np.exp(-(x**2 + y[:, None] ** 2) / w**2)
    np.save(tmp_path / "own.npy", array)
    for given in (array, tmp_path / "own.npy"):
        assert np.array_equal(system(given).simulate().field, result.field)
    system(array).save(tmp_path / "scene.toml")
    loaded = raylet.load(tmp_path / "scene.toml")
    assert np.array_equal(loaded.simulate().field, result.field)
    assert [part["name"] for part in loaded.parts][0] == "source"
    with pytest.raises(TypeError, match="size is not given"):
        system(lambda x, y: x)
    with pytest.raises(ValueError, match="no single ray"):
        loaded.trace()


def test_a_lens_collimates_a_fibre() -> None:
    """A single-mode fibre of Marcuse's width w in the front focus of a lens makes a beam of radius λf/πw behind it."""
    a, aperture, wave = 4.1, 0.12, 1.55
    v = 2 * np.pi / wave * a * aperture
    width = wave * 2.0 / (np.pi * a * (0.65 + 1.619 / v**1.5 + 2.879 / v**6))
    system = (
        raylet.System(wavelength_um=wave)
        .fibre_source(core_radius_um=a, numerical_aperture=aperture, distance_mm=2.0)
        .add_paraxial_lens(2.0, aperture=raylet.disc(0.55), thickness_mm=2.0)
        .add_sensor(pixels=(40, 40), pitch_um=30.0)
    )
    result = system.simulate()
    image = result.intensity
    share = np.abs(np.sum(np.sqrt(image) * np.exp(-(result.x_mm**2 + result.y_mm[:, None] ** 2) / width**2))) ** 2
    share /= np.sum(image) * np.sum(np.exp(-2 * (result.x_mm**2 + result.y_mm[:, None] ** 2) / width**2))
    assert share > 0.99, share
    with pytest.raises(raylet.RayletError, match="guides the mode from V = 2.4048"):
        system.fibre_source(core_radius_um=2.0, numerical_aperture=0.12, distance_mm=4.0, mode=(1, 1)).simulate()


def test_a_fibre_by_its_mode_field_diameter_is_a_gaussian_beam() -> None:
    """The light of a fibre at its end in the waist of a Gaussian beam is that of the beam, as far as it is paraxial."""
    system = raylet.System(wavelength_um=1.55).add_stop(raylet.disc(0.45), thickness_mm=2.0)
    system.add_sensor(pixels=(32, 32), pitch_um=10.0)
    beam = system.gaussian_beam(10.4 / 2, waist_mm=(0.0, 0.0, -2.0)).simulate()
    fibre = system.fibre_source(mode_field_diameter_um=10.4, distance_mm=2.0).simulate()
    assert np.linalg.norm(fibre.intensity - beam.intensity) < 0.03 * np.linalg.norm(beam.intensity)


def test_a_list_of_points_is_the_weighted_sum_of_their_images() -> None:
    system = raylet.System(wavelength_um=0.5).point_source((0.0, 0.0, -40.0))
    system.add_paraxial_lens(20.0, aperture=raylet.disc(0.4), thickness_mm=40.0).add_sensor(
        pixels=(24, 24), pitch_um=8.0
    )
    points = raylet.point_list(places_mm=[(0.0, 0.0, -40.0), (0.05, 0.0, -40.0), (0.0, 0.04, -41.0)], weights=[1, 2, 5])
    image, error = points.image(system.simulate(fields=points.fields))
    singly = [system.point_source(place).simulate().intensity for place in points.fields]
    assert error == 0.0 and np.allclose(points.weights, [0.125, 0.25, 0.625])
    assert np.allclose(image, 0.125 * singly[0] + 0.25 * singly[1] + 0.625 * singly[2], rtol=1e-12)
    assert np.allclose(raylet.point_list(angles_deg=[(0.0, 0.0), (1.0, 0.0)]).weights, 0.5)
    for given, words in (
        ({"places_mm": [(0.0, 0.0)]}, "expected (points, 3)"),
        ({"angles_deg": np.zeros((0, 2))}, "expected (points, 2)"),
        ({"angles_deg": [(0.0, 0.0)], "weights": [1.0, 2.0]}, "weights has shape (2,), expected (1,)"),
        ({"angles_deg": [(0.0, 0.0)], "weights": [-1.0]}, "expected numbers from zero"),
    ):
        with pytest.raises(ValueError, match=re.escape(words)):
            raylet.point_list(**given)


def bessel(order: int, x: Any) -> Any:
    """The Bessel function, by the mean of its plane waves."""
    turn = np.pi * (np.arange(400) + 0.5) / 400
    return np.mean(np.cos(order * turn - np.asarray(x)[..., None] * np.sin(turn)), axis=-1)


def test_the_image_of_a_disc_is_airys_pattern_over_it() -> None:
    """A lens that images all directions alike: in the middle the disc of Airy's encircled energy, elsewhere the mean of
    Airy's pattern over the disc."""
    f, radius, half, wave = 50.0, 1.0, 0.02, 0.5
    system = (
        raylet.System(wavelength_um=wave)
        .add_paraxial_lens(f, aperture=raylet.disc(radius), thickness_mm=f)
        .add_sensor(pixels=(21, 21), pitch_um=4.0)
    )
    disc = raylet.disc_source(centre_deg=(0.0, 0.0), radius_deg=half, rings=6, angles=12)
    assert disc.fields.shape == (73, 2) and disc.weights.sum() == pytest.approx(1.0)
    fields = system.simulate(fields=disc.fields, method="local_bands", progress=False)
    image, error = disc.image(fields)
    k, edge = 2e3 * np.pi / wave, f * np.sin(np.radians(half))
    v = k * radius * edge / f
    peak = (np.pi * radius**2 / (1e-3 * wave * f)) ** 2
    middle = peak * 4.0 / v**2 * (1.0 - bessel(0, v) ** 2 - bessel(1, v) ** 2)
    assert abs(image[10, 10] / middle - 1.0) < 4e-4, image[10, 10] / middle

    # Airy's pattern about many places of the disc.
    n = 60
    radii, turns = np.sqrt((np.arange(n) + 0.5) / n) * edge, 2.0 * np.pi * np.arange(40) / 40
    x = 4e-3 * (np.arange(21) - 10.0)
    total = np.zeros((21, 21))
    for r in radii:
        for turn in turns:
            arm = k * radius / f * np.hypot(x - r * np.cos(turn), x[:, None] - r * np.sin(turn)) + 1e-9
            total += peak * (2.0 * bessel(1, arm) / arm) ** 2
    exact = total / (n * 40)
    off = float(np.linalg.norm(image - exact) / np.linalg.norm(exact))
    assert off < 4e-4, (off, error)
    assert off < error < 0.1, (off, error)


def test_two_slits_lose_their_fringes_as_van_cittert_and_zernike_have_it() -> None:
    """The visibility behind two slits d apart, lit by a line of the angle θ, is |sinc(dθ/λ)|."""
    d, wave = 0.2, 0.5
    slits = np.zeros((1, 21))
    slits[0, [0, 20]] = 1.0
    system = raylet.System(wavelength_um=wave)
    layer = raylet.pixels(pitch_um=(10.0, 400.0), transmission=slits)
    system.add_doe(layer, aperture=raylet.rectangle(0.21, 0.4), thickness_mm=100.0)
    system.add_sensor(pixels=(201, 1), pitch_um=(5.0, 5.0))
    for share in (0.3, 0.6):
        theta = share * 1e-3 * wave / d
        angle = np.degrees(np.arcsin(0.5 * theta))
        line = raylet.line_source(ends_deg=[(-angle, 0.0), (angle, 0.0)], intervals=8)
        image, error = line.image(system.simulate(fields=line.fields, progress=False))
        fringes = image[0, 75:126]
        # The amplitude of the fringes of period λz/d = 0.25 mm, which 50 pixels hold once.
        turn = np.exp(-2j * np.pi * np.arange(50) / 50)
        visibility = 2.0 * np.abs(np.sum(fringes[:50] * turn)) / np.sum(fringes[:50])
        alone = system.simulate().intensity[0, 75:125]
        coherent = 2.0 * np.abs(np.sum(alone * turn)) / np.sum(alone)
        assert abs(visibility / coherent - np.sinc(share)) < 3e-4, (share, visibility / coherent, np.sinc(share))
        assert error < 4e-4, error


def test_extended_sources_refuse_what_they_cannot_take() -> None:
    with pytest.raises(TypeError, match="found neither"):
        raylet.line_source()
    with pytest.raises(ValueError, match=r"ends_mm has shape \(2, 2\)"):
        raylet.line_source(ends_mm=[(0.0, 0.0), (1.0, 0.0)])
    with pytest.raises(raylet.RayletError, match="rings is 3, expected an even number"):
        raylet.disc_source(centre_deg=(0.0, 0.0), radius_deg=0.1, rings=3)
    with pytest.raises(TypeError, match="radius_mm is not given"):
        raylet.disc_source(centre_mm=(0.0, 0.0, -1.0))
    places = raylet.disc_source(centre_mm=(1.0, 2.0, -5.0), radius_mm=0.5)
    x, y = places.fields[:, 0] - 1.0, places.fields[:, 1] - 2.0
    for weights in (places.weights, places.coarse_weights):
        assert weights @ (x**2 + y**2) == pytest.approx(0.125) and weights @ x**2 == pytest.approx(0.0625)
