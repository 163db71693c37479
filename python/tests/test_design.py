"""Holograms and designs: what is found is what the system then does, and files and arrays are the same."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from conftest import ROOT

import raylet

PICTURE = np.zeros((12, 12))
PICTURE[2:4], PICTURE[:, 7:9], PICTURE[8:, :4] = 1.0, 1.0, 1.0

SCENE = """version = 1
wavelength_um = 0.6
source = { kind = "plane" }
settings.target_error = 1e-2
[[element]]
kind = "doe"
name = "slm"
thickness_mm = 0.1
aperture = { disc = { radius_mm = 0.01 } }
layer = [{ kind = "pixels", pitch_um = 2, size = [10, 10], phase = "found.npy" }]
[[element]]
kind = "sensor"
pixels = [12, 12]
pitch_um = 2
[hologram]
target = "picture.png"
element = "slm"
size_mm = [0.024, 0.024]
[design]
iterations = 5
"""


def blank(**layer: object) -> raylet.System:
    """Free space behind pixels that are to be found."""
    pixels = raylet.pixels(pitch_um=2.0, size=(10, 10), **layer)
    system = raylet.System(wavelength_um=0.6).settings(target_error=1e-2)
    system.add_doe(pixels, aperture=raylet.disc(0.01), thickness_mm=0.1, name="slm")
    return system.add_sensor(pixels=(12, 12), pitch_um=2.0)


def ncc(intensity: np.ndarray) -> float:
    return float(np.vdot(intensity, PICTURE) / np.linalg.norm(intensity) / np.linalg.norm(PICTURE))


LOSS = {"kind": "likeness", "picture": PICTURE, "size_mm": (0.024, 0.024)}


def test_a_hologram_shows_its_picture() -> None:
    """Its own score is of the softened picture on the paraxial train; the sensor sees the picture better for it."""
    reported: list[str] = []
    made = blank().hologram(
        PICTURE, element="slm", size_mm=(0.024, 0.024), iterations=30, progress=lambda _, what: reported.append(what)
    )
    assert made.arrays["element[0].layer[0].phase"].shape == (10, 10)
    assert ncc(made.system.simulate().intensity) > ncc(blank().simulate().intensity) + 0.1
    assert 0.0 < made.scores["efficiency"] <= 1.0 and "ncc: 0." in repr(made)
    assert all(what.startswith("NCC 0.") for what in reported)


def test_what_is_found_is_what_the_system_does() -> None:
    """The loss by 1 - NCC² of the intensity that a simulation of the found system gives."""
    made = blank().design(element=[{"name": "slm", "start": "random"}], loss=[LOSS], iterations=6)
    assert len(made.course) == 7 and made.course[-1] < 0.8 * made.course[0]
    seen = 1.0 - ncc(made.system.simulate().intensity) ** 2
    assert made.scores["loss"] == pytest.approx(seen, rel=2e-3)
    figure, ax = made.plot()
    assert ax.get_xlabel() == "iteration"


def test_amplitudes_and_phases_begin_with_the_systems_own() -> None:
    rng = np.random.default_rng(4)
    phase = rng.uniform(0.0, 6.0, (10, 10))
    system = blank(phase=phase, amplitude=np.ones((10, 10)))
    both = system.design(element=[{"name": "slm", "free": "both", "start": "file"}], loss=[LOSS], iterations=3)
    assert sorted(both.arrays) == ["element[0].layer[0].amplitude", "element[0].layer[0].phase"]
    assert both.course[0] == pytest.approx(1.0 - ncc(system.simulate().intensity) ** 2, rel=2e-3)
    assert both.arrays["element[0].layer[0].amplitude"].max() <= 1.0
    assert both.course[-1] < both.course[0]


def test_sums_and_heights_are_found() -> None:
    """Two phases a pixel, and the relief of a glass in two levels: what is exported is what was scored."""
    rng = np.random.default_rng(2)
    two = [raylet.pixels(pitch_um=2.0, phase=rng.uniform(0.0, 6.0, (10, 10))) for _ in range(2)]
    relief = raylet.height(pitch_um=2.0, height_um=np.zeros((10, 10)), glass="fused silica")
    for layer, element in [
        (raylet.superposition([[two[0]], [two[1]]], weights=[0.5, 0.5j]), {"free": "two_phase", "start": "file"}),
        (relief, {"free": "height", "levels": 2, "start": "random"}),
    ]:
        system = raylet.System(wavelength_um=0.6).settings(target_error=1e-2)
        system.add_doe(layer, aperture=raylet.disc(0.01), thickness_mm=0.1, name="slm")
        system.add_sensor(pixels=(12, 12), pitch_um=2.0)
        made = system.design(element=[{"name": "slm", **element}], loss=[LOSS], iterations=4)
        seen = 1.0 - ncc(made.system.simulate().intensity) ** 2
        assert made.scores["loss"] == pytest.approx(seen, rel=2e-3)
        assert all(array.shape == (10, 10) for array in made.arrays.values())
        if "levels" in element:
            (heights,) = made.arrays.values()
            assert len(np.unique(heights)) == 2


def test_heights_in_another_medium_than_air_are_found() -> None:
    """Glass and water with dispersion: the loss is that of a simulation with the heights that were found."""
    relief = raylet.height(pitch_um=2.0, height_um=np.zeros((10, 10)), glass="N-SF11")
    system = raylet.System(wavelength_um=[0.45, 0.7], ambient="water").settings(target_error=1e-2)
    system.add_doe(relief, aperture=raylet.disc(0.01), thickness_mm=0.1, name="slm")
    system.add_sensor(pixels=(12, 12), pitch_um=2.0)
    losses = [LOSS | {"wavelength_um": [colour]} for colour in (0.45, 0.7)]
    made = system.design(element=[{"name": "slm", "free": "height", "start": "random"}], loss=losses, iterations=4)
    seen = [1.0 - ncc(np.abs(field) ** 2) ** 2 for field in made.system.simulate().field]
    assert made.scores["loss"] == pytest.approx(sum(seen), rel=2e-3)


def test_parameters_are_found_beside_arrays_in_memory() -> None:
    """The radius of a lens whose light comes to a spot: what is left brightens it, and keeps the pixels before it."""
    phase = np.zeros((8, 8))
    system = (
        raylet.System(wavelength_um=0.6)
        .add_doe(raylet.pixels(pitch_um=12.0, phase=phase), aperture=raylet.disc(0.045), thickness_mm=1.0, name="slm")
        .add_surface(radius_mm=1.1, thickness_mm=0.2, glass="N-BK7", semi_aperture_mm=0.4)
        .add_surface(thickness_mm=1.8, semi_aperture_mm=0.4)
        .add_sensor(pixels=(9, 9), pitch_um=2.0)
        .settings(target_error=1e-2)
    )
    spot = {"kind": "spot", "at_mm": [(0.0, 0.0)], "focal_length_mm": 1.93}
    variable = {"path": "element[1].radius_mm", "scale": 0.02}
    made = system.design(loss=[spot], variable=[variable], iterations=2)
    before, after = (one.simulate().intensity[4, 4] for one in (system, made.system))
    assert after > 1.05 * before
    assert made.arrays == {}
    (name,) = made.parameters
    assert name == "1/element[1].radius_mm"
    radii = [part["radii_mm"][0] for part in made.system.parts]
    assert 1.0 / made.parameters[name] == pytest.approx(radii[1])
    assert np.shares_memory(made.system._document["element"][0]["layer"][0]["phase"], phase)


def test_a_scene_with_its_files_is_the_same(tmp_path: Path) -> None:
    """A scene whose phase is still to be found, and the same system in code with the picture in memory."""
    (tmp_path / "scene.toml").write_text(SCENE)
    write_gray(tmp_path / "picture.png", PICTURE)
    there = raylet.load(tmp_path / "scene.toml")
    here = blank()
    given = {"target": PICTURE, "element": "slm", "size_mm": (0.024, 0.024)}
    by_file, by_array = there.hologram(iterations=5), here.hologram(iterations=5, **given)
    (a,), (b,) = by_file.arrays.values(), by_array.arrays.values()
    assert np.array_equal(a, b)
    by_gradients = there.design()
    assert by_gradients.course[-1] < by_gradients.course[0]
    with pytest.raises(raylet.RayletError, match="found.npy"):
        there.simulate()
    by_gradients.system.simulate()


def write_gray(path: Path, values: np.ndarray) -> None:
    """A PNG file, its first row at the top."""
    from matplotlib.image import imsave

    imsave(path, values[::-1], cmap="gray", vmin=0.0, vmax=1.0)


def test_impossible_designs_are_reported() -> None:
    system = blank()
    for call, message in [
        (lambda: system.hologram(), "no hologram"),
        (lambda: system.design(), "no design"),
        (lambda: system.design(iterations=3), "nothing to design"),
        (lambda: system.hologram(PICTURE, element="none", size_mm=(1, 1)), 'System.hologram: element: found "none"'),
        (lambda: system.hologram(-PICTURE, element="slm", size_mm=(0.024, 0.024)), "values from 0"),
        (lambda: system.design(element=[{"name": "slm"}]), "found no loss"),
        (lambda: system.design(element=[{"name": "slm"}], loss=[LOSS], rate=0.1), "optimizer lbfgs"),
        (lambda: system.hologram("none.png", element="slm", size_mm=(0.024, 0.024)), "none.png"),
        (lambda: system.design(element=[{"name": "slm"}], loss=[{"kind": "beauty"}]), "beauty"),
        (lambda: system.design(element=[{"name": "slm"}], loss=[LOSS], iterations=0), "iterations"),
        (lambda: system.design(variable=[{"path": "element[0].radius"}], loss=[LOSS]), "radius"),
    ]:
        with pytest.raises(raylet.RayletError, match=message):
            call()


def test_a_step_too_far_is_taken_back() -> None:
    """A plane whose first trial radius is smaller than its own aperture: no reason to end."""
    system = (
        raylet.System(wavelength_um=0.6)
        .add_doe(raylet.pixels(pitch_um=12.0, size=(8, 8)), aperture=raylet.disc(0.045), thickness_mm=1.0, name="slm")
        .add_surface(radius_mm=np.inf, thickness_mm=0.2, glass="N-BK7", semi_aperture_mm=0.5)
        .add_surface(thickness_mm=1.8, semi_aperture_mm=0.5)
        .add_sensor(pixels=(9, 9), pitch_um=2.0)
        .settings(target_error=1e-2)
    )
    spot = {"kind": "spot", "at_mm": [(0.0, 0.0)]}
    variable = {"path": "element[1].radius_mm", "scale": 30.0}
    made = system.design(loss=[spot], variable=[variable], iterations=2)
    assert made.course[-1] < made.course[0]


def test_starts_of_a_hologram() -> None:
    """A spread start needs the table of a hologram, which can be given beside; "file" needs phases."""
    table = {"target": PICTURE, "element": "slm", "size_mm": (0.024, 0.024)}
    made = blank().design(hologram=table, iterations=2)
    assert made.course[-1] < made.course[0]
    with pytest.raises(raylet.RayletError, match="no file for the phase"):
        blank().design(element=[{"name": "slm", "start": "file"}], loss=[LOSS], iterations=2)


def test_refusals_of_python_have_attributes_too() -> None:
    with pytest.raises(raylet.RayletError) as caught:
        blank().with_pixels("none", phase=PICTURE)
    assert caught.value.path == "" and caught.value.hint == ""


def test_a_search_can_be_ended() -> None:
    class Enough(Exception):
        pass

    def progress(done: float, what: str) -> None:
        raise Enough

    with pytest.raises(Enough):
        blank().design(element=[{"name": "slm"}], loss=[LOSS], iterations=100000, progress=progress)


def test_a_search_goes_on_from_its_checkpoints(tmp_path: Path) -> None:
    """Ended on the way, with a torn file, and with other arrays."""

    class Enough(Exception):
        pass

    def progress(done: float, what: str) -> None:
        if done >= 0.5:
            raise Enough

    start = np.random.default_rng(1).uniform(0.0, 6.0, (10, 10))
    task = {"element": [{"name": "slm", "start": "file"}], "loss": [LOSS], "iterations": 12, "checkpoint": 2}
    system, kept = blank(phase=start), tmp_path / "kept"
    whole = system.design(**task)
    with pytest.raises(Enough):
        system.design(**task, checkpoints=kept, progress=progress)
    with pytest.raises(raylet.RayletError, match="another scene or of other settings"):
        blank(phase=start + 1e-9).design(**task, checkpoints=kept, resume=True)
    (kept / "checkpoint.json").write_text("torn")
    with pytest.warns(UserWarning, match="the newest checkpoint is torn"):
        resumed = system.design(**task, checkpoints=kept, resume=True)
    (a,), (b,) = whole.arrays.values(), resumed.arrays.values()
    assert np.array_equal(a, b) and np.array_equal(whole.course, resumed.course)
    with pytest.raises(TypeError, match="expected their folder"):
        system.design(**task, resume=True)


def test_elements_without_a_name_are_called_by_their_place() -> None:
    system = raylet.System(wavelength_um=0.6)
    system.add_doe(raylet.pixels(pitch_um=2.0, size=(10, 10)), aperture=raylet.disc(0.01), thickness_mm=0.1)
    system.add_sensor(pixels=(12, 12), pitch_um=2.0)
    made = system.hologram(PICTURE, element="element[0]", size_mm=(0.024, 0.024), iterations=5)
    (same,) = system.hologram(PICTURE, size_mm=(0.024, 0.024), iterations=5).arrays.values()
    (phase,) = made.arrays.values()
    assert np.array_equal(phase, same)
    put = system.with_pixels("element[0]", phase=phase)
    assert np.array_equal(put.simulate().field, made.system.simulate().field)
    assert np.array_equal(put.linearised("element[0]")(phase).field, put.linearised("element[0]")(phase + 0.0).field)
    assert system.design(element=[{"name": "element[0]"}], loss=[LOSS], iterations=2).course[-1] < 1.0


def test_pixels_of_another_number_are_refused() -> None:
    with pytest.raises(ValueError, match=r"phase has shape \(7, 9\), expected \(10, 10\)"):
        blank().with_pixels("slm", phase=np.zeros((7, 9)))


def test_the_scene_of_the_demo() -> None:
    made = raylet.load(ROOT / "scenes/hologram_through_lens.toml").hologram(iterations=3)
    assert made.scores["ncc"] > 0.9
