"""Elements as files for foundries: arrays, systems and files give the same, and what is written is read back."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import raylet

#: Levels of which no two rows or columns are alike.
LEVELS = np.array([[0, 1, 2, 3, 3], [1, 0, 0, 2, 1], [3, 3, 1, 0, 2]])


def system(phase: np.ndarray, radius_mm: float = 0.0) -> raylet.System:
    return (
        raylet.System(wavelength_um=0.5)
        .add_doe(
            raylet.pixels(pitch_um=2.0, phase=phase),
            aperture=raylet.disc(radius_mm) if radius_mm else raylet.rectangle(0.01, 0.006),
            thickness_mm=5.0,
            name="plate",
        )
        .add_sensor(pixels=(4, 4), pitch_um=5.0)
    )


@pytest.mark.parametrize("masks", ["each", "binary", "dose"])
def test_levels_are_read_back(tmp_path: Path, masks: str) -> None:
    path = tmp_path / "a.gds"
    report = raylet.export_element(LEVELS, path, pitch_um=(0.5, 0.75), quantity="level", levels=4, masks=masks)
    assert report.numbers["cells"] == 15 and "5 x 3 of 0.5 x 0.75 µm" in str(report)
    found = raylet.read_masks(path, pitch_um=(0.5, 0.75), size=(5, 3), levels=4, masks=masks)
    np.testing.assert_array_equal(found, LEVELS)


def test_a_system_an_array_and_a_file_give_one_file(tmp_path: Path) -> None:
    phase = LEVELS * (np.pi / 2)
    raylet.export_element(phase, tmp_path / "plate.gds", pitch_um=2.0)
    np.save(tmp_path / "plate.npy", phase)
    raylet.export_element(tmp_path / "plate.npy", tmp_path / "file.gds", pitch_um=2.0)
    report = raylet.export_element(system(phase), tmp_path / "system.gds", element="plate")
    assert report.numbers["closed_cells"] == 0
    names = ("plate", "file", "system")
    read = [raylet.read_masks(tmp_path / f"{name}.gds", pitch_um=2.0, size=(5, 3), levels=4) for name in names]
    for levels in read:
        np.testing.assert_array_equal(levels, LEVELS)
    system(phase).save(tmp_path / "scene.toml")
    raylet.export_element(tmp_path / "scene.toml", tmp_path / "made.npy")
    np.testing.assert_array_equal(np.load(tmp_path / "made.npy"), phase)


def test_heights_and_coefficients(tmp_path: Path) -> None:
    y, x = (np.mgrid[:60, :60] - 29.5) * 2e-3
    phase = np.mod(-30.0 * (x**2 + y**2) / 0.06**2, 2 * np.pi)
    fit = raylet.export_element(phase, tmp_path / "a.txt", pitch_um=2.0, terms=2)
    assert abs(fit.numbers["A1"] + 30.0) < 1e-9 and fit.numbers["residual_rad"] < 1e-9
    # λ / (n − 1) = 1 µm for a whole wave.
    given = {"pitch_um": 2.0, "index": 1.5, "wavelength_um": 0.5, "as_height": True}
    raylet.export_element(phase, tmp_path / "a.npy", **given)
    np.testing.assert_allclose(np.load(tmp_path / "a.npy"), phase / (2 * np.pi), atol=1e-12)


def test_refusals_say_what_would_do(tmp_path: Path) -> None:
    with pytest.raises(raylet.RayletError, match="pitch_um"):
        raylet.export_element(LEVELS, tmp_path / "a.gds", quantity="level")
    with pytest.raises(raylet.RayletError, match="database-unit-nm"):
        raylet.export_element(LEVELS, tmp_path / "a.gds", quantity="level", pitch_um=0.3335)
    with pytest.raises(raylet.RayletError, match="unknown variant"):
        raylet.export_element(LEVELS, tmp_path / "a.gds", quantity="colour", pitch_um=1.0)
    with pytest.raises(raylet.RayletError, match="levels"):
        raylet.export_element(np.random.default_rng(1).random((20, 20)), tmp_path / "a.gds", pitch_um=1.0)
    (tmp_path / "a.csv").write_text("mine")
    with pytest.raises(raylet.RayletError, match="overwrite"):
        raylet.export_element(LEVELS, tmp_path / "a.csv", quantity="level", pitch_um=1.0)


def test_the_aperture_closes_cells_and_an_etch_is_undone(tmp_path: Path) -> None:
    # Centres of cells of 2 µm within 4.2 µm of the middle: all but the four corners.
    plate = system(LEVELS * (np.pi / 2), 0.0042)
    inside = np.ones_like(LEVELS)
    inside[::2, ::4] = 0
    path = tmp_path / "a.gds"
    drawn = {"etch_bias_um": 0.25, "aperture_layer": 50}
    report = raylet.export_element(plate, path, **drawn)
    assert report.numbers["closed_cells"] == 4 and report.numbers["outlines"] == 1
    found = raylet.read_masks(path, pitch_um=2.0, size=(5, 3), levels=4, **drawn)
    np.testing.assert_array_equal(found, LEVELS * inside)
    raylet.export_element(plate, tmp_path / "a.npy", whole_grid=True)
    np.testing.assert_array_equal(np.load(tmp_path / "a.npy"), LEVELS * (np.pi / 2))
    for ending, start in {"oas": b"%SEMI-OASIS", "dxf": b"999\nraylet"}.items():
        raylet.export_element(plate, tmp_path / f"a.{ending}", fill=0.81)
        assert (tmp_path / f"a.{ending}").read_bytes().startswith(start)
