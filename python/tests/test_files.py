"""Files that are saved: whole or not at all, and never in the place of what raylet did not write; documents as TOML;
and lens files of OpticStudio as systems."""

from __future__ import annotations

import os
import struct
import sys
from pathlib import Path

import numpy as np
import pytest
from conftest import hologram, noise

import raylet
from raylet._plain import dumps


def test_files_of_others_are_not_replaced(tmp_path: Path) -> None:
    result = hologram(noise((4, 5))).simulate()
    path = tmp_path / "field.npz"
    path.write_text("mine")
    with pytest.raises(raylet.RayletError, match="did not write") as caught:
        result.save(path)
    assert "overwrite=True" in caught.value.hint
    assert path.read_text() == "mine" and os.listdir(tmp_path) == ["field.npz"]
    result.save(path, overwrite=True)

    # Twice in a row, until somebody else changes it.
    result.save(path)
    np.savez(path, field=result.field)
    with pytest.raises(raylet.RayletError, match="changed since"):
        result.save(path)
    with pytest.raises(TypeError, match="overwrite is int"):
        result.save(path, overwrite=1)  # type: ignore[arg-type]


def test_links_are_not_followed(tmp_path: Path) -> None:
    (tmp_path / "real.npz").write_text("mine")
    (tmp_path / "field.npz").symlink_to("real.npz")
    result = hologram(noise((4, 5))).simulate()
    with pytest.raises(raylet.RayletError, match="a symbolic link"):
        result.save(tmp_path / "field.npz")
    result.save(tmp_path / "field.npz", overwrite=True)
    assert (tmp_path / "real.npz").read_text() == "mine"


def test_systems_are_saved_as_a_whole_or_not(tmp_path: Path) -> None:
    """All files are checked before the first is written."""
    system = hologram(noise((4, 5)))
    scene, array = tmp_path / "scene.toml", tmp_path / "scene.element0.layer0.phase.npy"
    for path in (scene, array):
        path.write_text("mine")
        with pytest.raises(raylet.RayletError, match=path.name):
            system.save(scene)
        assert os.listdir(tmp_path) == [path.name] and path.read_text() == "mine"
        path.unlink()
    for _ in range(2):
        system.save(scene)
    assert np.array_equal(raylet.load(scene).simulate().field, system.simulate().field)


def test_one_design_at_a_time_keeps_checkpoints(tmp_path: Path) -> None:
    system = raylet.System(wavelength_um=0.6)
    pixels = raylet.pixels(pitch_um=2.0, size=(6, 6))
    system.add_doe(pixels, aperture=raylet.disc(0.006), thickness_mm=0.1, name="slm")
    system.add_sensor(pixels=(6, 6), pitch_um=2.0)
    spot = {"kind": "encircled_energy", "at_mm": [(0.002, 0.0)], "radius_mm": 0.003}
    task = {"element": [{"name": "slm", "start": "random"}], "loss": [spot], "iterations": 4}
    kept, errors = tmp_path / "kept", []

    def meanwhile(done: float, what: str) -> None:
        if not errors:
            with pytest.raises(raylet.RayletError, match=f"process {os.getpid()} on ") as caught:
                system.design(**task, checkpoints=kept)
            errors.append(caught.value)

    system.design(**task, checkpoints=kept, progress=meanwhile)
    assert errors
    assert sorted(os.listdir(kept)) == ["checkpoint.before.json", "checkpoint.json"]
    system.design(**task, checkpoints=kept, resume=True)

    # What is no checkpoint of raylet stays.
    (kept / "checkpoint.json").write_text("mine")
    with pytest.raises(raylet.RayletError, match="not a whole checkpoint"):
        system.design(**task, checkpoints=kept)
    assert (kept / "checkpoint.json").read_text() == "mine"


@pytest.mark.skipif(sys.version_info < (3, 11), reason="needs tomllib")
def test_what_is_written_is_read() -> None:
    import tomllib

    document = {
        "text": 'µ "quoted"\n\\ \x7f',
        "numbers": [1, -2.5, 1e-300, np.float64(0.1), np.int32(7)],
        "yes": True,
        "no": np.False_,
        "absent": None,
        "table": {"odd key": np.array([1.0, 2.0]), "inf": float("inf"), "zero": np.array(3.0)},
        "rows": [{"a": {"b": [{"c": 1}]}}, {"d": ()}],
    }
    read = tomllib.loads(dumps(document))
    assert read["text"] == document["text"] and read["numbers"] == [1, -2.5, 1e-300, 0.1, 7]
    assert read["yes"] is True and read["no"] is False and "absent" not in read
    assert read["table"] == {"odd key": [1.0, 2.0], "inf": float("inf"), "zero": 3.0}
    assert read["rows"] == [{"a": {"b": [{"c": 1}]}}, {"d": []}]


@pytest.mark.parametrize("value", [object(), {1: 2}, "\ud800", 1j, b"x"])
def test_what_has_no_words_is_refused(value: object) -> None:
    with pytest.raises((TypeError, ValueError)):
        dumps({"a": {"b": value}})


def test_a_lens_file_is_a_system(scenes: Path) -> None:
    lens = raylet.load(scenes / "prescriptions" / "lens1.zmx", field=2)
    assert "focal length (mm)                   24.990670" in lens.import_report
    assert lens.trace(Px=[0.0, 0.2], Py=[0.0, 0.1]).arrived.all()
    assert raylet.load(scenes / "spider.toml").import_report == ""


def test_a_file_of_code_v_is_a_system(scenes: Path, tmp_path: Path) -> None:
    lens = raylet.load(scenes / "prescriptions" / "CODV_65988.seq")
    assert "focal length (mm)                   15.018427" in lens.import_report
    assert lens.trace(Px=[0.0, 0.2], Py=[0.0, 0.1]).arrived.all()
    zoom = tmp_path / "ZOOM.SEQ"
    zoom.write_text("RDM\nEPD 2\nWL 500\nYAN 0\nS 30 4 NBK7_SCHOTT\nS -60 20\nZOO 2\nZOO RDY S1 30 45\n")
    first, second = (raylet.load(zoom, configuration=number).import_report for number in (1, 2))
    assert "focal length (mm)                   38.9" in first and "focal length (mm)                   49.9" in second
    with pytest.raises(raylet.RayletError, match="configuration 3 requested"):
        raylet.load(zoom, configuration=3)


def _packed(text: bytes) -> bytes:
    """LZW with codes that grow from 9 bits: the compression of OpticStudio's archives."""
    words = {bytes([value]): value for value in range(256)}
    bits, word, sent = "", b"", 0
    for value in [*text, None]:
        longer = word + bytes([value]) if value is not None else None
        if longer in words:
            word = longer
            continue
        bits += format(words[word], f"0{(255 + max(sent, 1)).bit_length()}b")
        sent += 1
        if longer is not None:
            words[longer] = len(words)
            word = longer[-1:]
    bits += "0" * (-len(bits) % 8)
    return int(bits, 2).to_bytes(len(bits) // 8, "big")


def test_an_archive_is_a_system(scenes: Path, tmp_path: Path) -> None:
    content = (scenes / "prescriptions" / "lens1.zmx").read_bytes()
    packed, name = _packed(content), "lens1.ZMX.LZW".encode("utf-16-le")
    header = struct.pack("<IIIIQQ16x", 1004, 0, 1, 0, len(packed), len(content)) + name
    archive = tmp_path / "lens.zar"
    archive.write_bytes(header.ljust(648, b"\0") + packed)
    lens, same = raylet.load(archive, field=2), raylet.load(scenes / "prescriptions" / "lens1.zmx", field=2)
    assert "The lens is lens1.ZMX of the archive lens.zar." in lens.import_report
    assert lens.to_toml() == same.to_toml()
    archive.write_bytes(b"<!DOCTYPE html>")
    with pytest.raises(raylet.RayletError, match="a web page"):
        raylet.load(archive)


def test_grids_of_lens_files_are_arrays(tmp_path: Path) -> None:
    points = "".join(f"  GARR {i} {0.1 * i} 0 0 0 0\n" for i in range(49))
    surfaces = f"SURF 0\n  DISZ INFINITY\nSURF 1\n  STOP\n  TYPE GRID_PHA\n  PARM 0 1\n  GDAT 7 7 0.5 0.5 0 0\n{points}"
    rest = "  DISZ 10\n  DIAM 1.2\nSURF 2\n  TYPE PARAXIAL\n  PARM 1 50\n  DISZ 50\n  DIAM 2\nSURF 3\n  DISZ 0\n"
    head = "MODE SEQ\nUNIT MM X W X CM MR CPMM\nENPD 2\nFTYP 0 0 1 1\nXFLN 0\nYFLN 0\nWAVM 1 0.5 1\nPWAV 1\n"
    (tmp_path / "grid.zmx").write_text(head + surfaces + rest)
    lens = raylet.load(tmp_path / "grid.zmx")
    assert lens.trace(Px=[0.0, 0.5], Py=[0.0, 0.5]).arrived.all()
    lens.save(tmp_path / "lens.toml")
    assert raylet.load(tmp_path / "lens.toml").trace(Px=[0.0], Py=[0.5]).arrived.all()


def test_a_table_is_a_system(tmp_path: Path) -> None:
    table = tmp_path / "lens.csv"
    rows = ["name,radius,thickness,glass,semi_diameter", "stop,,5,,4", "front,50,3,N-BK7,6", "back,-50,40,,6"]
    table.write_text("\n".join(rows))
    lens = raylet.load(table)
    assert "focal length (mm)                   48." in lens.import_report
    assert lens.trace(Px=[0.0, 0.5], Py=[0.0, 0.5]).arrived.all()


def test_glasses_come_from_catalogues_of_the_user(scenes: Path, tmp_path: Path) -> None:
    catalogue = tmp_path / "own.agf"
    catalogue.write_text("NM N-SK16 2 0 1.6 60 0 1\nCD 1.5 0.01 0 0 0 0\nLD 0.3 2.5\n")
    lens = raylet.load(scenes / "prescriptions" / "lens1.zmx", glass_files=[catalogue])
    assert "Glass N-SK16: line 1 of own.agf" in lens.import_report
    with pytest.raises(raylet.RayletError, match="expected a list of paths"):
        raylet.load(scenes / "prescriptions" / "lens1.zmx", glass_files=str(catalogue))


def test_glasses_are_refused_or_replaced(scenes: Path) -> None:
    path = scenes / "prescriptions" / "US08427765-1.ZMX"
    with pytest.raises(raylet.RayletError, match="the unknown glass L-TIM28_MOLD") as caught:
        raylet.load(path)
    assert "OHARA:L-TIM28" in caught.value.hint
    with pytest.warns(UserWarning, match="real image heights"):
        lens = raylet.load(path, glasses={"L-TIM28_MOLD": "L-TIM28"})
    assert "Glass L-TIM28_MOLD: OHARA:L-TIM28 in its place" in lens.import_report


def test_numbers_of_fields_are_checked(scenes: Path) -> None:
    path = scenes / "prescriptions" / "lens1.zmx"
    with pytest.raises(raylet.RayletError, match="field 9 requested"):
        raylet.load(path, field=9)
    with pytest.raises(raylet.RayletError, match="wavelength 9 requested"):
        raylet.load(path, wavelength=9)
    with pytest.raises(raylet.RayletError, match="field is -1, expected a number from 1"):
        raylet.load(path, field=-1)
    with pytest.raises(raylet.RayletError, match="are for lens files"):
        raylet.load(scenes / "spider.toml", field=2)
