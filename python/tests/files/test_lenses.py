"""Lens files that are written, the catalogue, and folders of lens files."""

from __future__ import annotations

import math
import os
import shutil
from pathlib import Path

import numpy as np
import pytest

import raylet
from raylet import RayletError

LENSES = Path(__file__).parents[3] / "scenes" / "prescriptions"


def singlet() -> raylet.System:
    return (
        raylet.System(0.5876, title="Größe")
        .plane_wave(angle_deg=(1.0, -2.0))
        .add_stop(raylet.disc(2.0), thickness_mm=1.0)
        .add_lens(
            {"radius_mm": 50.0, "thickness_mm": 3.0, "glass": "N-BK7", "semi_aperture_mm": 4.0},
            {"radius_mm": -50.0, "semi_aperture_mm": 4.0},
            thickness_mm=47.0,
        )
        .add_sensor(pixels=(8, 8), pitch_um=2.0)
    )


@pytest.mark.parametrize("end", [".zmx", ".seq"])
def test_a_system_is_the_same_when_it_is_written_and_read_again(tmp_path: Path, end: str) -> None:
    system, path = singlet(), tmp_path / f"lens{end}"
    report = raylet.export_lens(system, path)
    # The lens maker's formula.
    n = 1.516799
    power = (n - 1) * (2 / 50 - (n - 1) * 3 / (n * 50 * 50))
    assert report.numbers["focal length, axis unfolded (mm)"] == pytest.approx(1 / power, rel=1e-5)
    assert report.numbers["entrance pupil diameter (mm)"] == pytest.approx(4.0, rel=1e-12)
    again = raylet.load(path)
    first, second = (one.trace(0.0, 0.0, 0.3, -0.7) for one in (system, again))
    assert np.allclose([first.x, first.y], [second.x, second.y], rtol=0, atol=1e-9)
    raylet.export_lens(system, path)
    path.write_text("mine")
    with pytest.raises(RayletError, match="did not write"):
        raylet.export_lens(system, path)
    raylet.export_lens(system, path, overwrite=True)


def test_what_a_file_cannot_hold_is_refused_or_left_out(tmp_path: Path) -> None:
    system = (
        raylet.System(0.6)
        .add_doe(raylet.vortex(charge=2), aperture=raylet.disc(1.0), thickness_mm=5.0, name="spiral")
        .add_sensor(pixels=(8, 8), pitch_um=2.0)
    )
    with pytest.raises(RayletError, match="vortex") as caught:
        raylet.export_lens(system, tmp_path / "a.zmx")
    assert caught.value.path == "element[0].layer[0]"
    with pytest.warns(UserWarning, match="left out"):
        raylet.export_lens(system, tmp_path / "a.zmx", skip_unknown=True)
    with pytest.raises(RayletError, match=r"\.zmx or \.seq"):
        raylet.export_lens(system, tmp_path / "a.len")
    with pytest.raises(RayletError, match="source is 3"):
        raylet.export_lens(3, tmp_path / "a.zmx")  # type: ignore[arg-type]


def test_the_catalogue_has_systems_by_part_number() -> None:
    parts = {lens.path: lens for lens in raylet.catalog()}
    assert len(parts) == 8 and parts["65-564"].maker == "Edmund Optics"
    assert parts["32-327"].focal_length_mm == pytest.approx(100.0, abs=0.1)
    assert isinstance(raylet.catalog("Thorlabs LA1131-A"), raylet.System)
    assert "CODV_65988" in raylet.catalog("65988").import_report
    with pytest.raises(ValueError, match="nearest are 65-564"):
        raylet.catalog("65-565")
    with pytest.raises(RayletError, match="name is 3"):
        raylet.catalog(3)  # type: ignore[call-overload]


def test_a_folder_is_searched_and_keeps_its_faults(tmp_path: Path) -> None:
    folder = raylet.LensFolder(LENSES)
    found = folder.search(focal_length_mm=(90, 110), diameter_mm=(20, 30), text="achromat")
    assert [Path(lens.path).name for lens in found] == ["CODV_32327.seq"]
    assert len(folder) == 52 and len(folder.faults) == 1
    for path, fault in folder.faults.items():
        assert os.path.basename(path) in fault
    with pytest.raises(RayletError, match="the smaller one first"):
        folder.search(f_number=(3, 2))
    # Nothing is written but the index that is given.
    copies = tmp_path / "lenses"
    shutil.copytree(LENSES, copies)
    before = sorted(os.listdir(copies))
    index = tmp_path / "index.json"
    assert raylet.LensFolder(copies, index=index).read == 52
    again = raylet.LensFolder(copies, index=index)
    assert again.read == 0 and sorted(os.listdir(copies)) == before
    assert all(math.isfinite(lens.diameter_mm) for lens in again.search())
