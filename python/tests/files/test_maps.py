"""Maps of instruments, and fields of other programs: written by this description or by NumPy, and read by raylet."""

from __future__ import annotations

import struct
from pathlib import Path

import numpy as np
import pytest

import raylet

WAVELENGTH_UM, INDEX = 0.6328, 1.5


def zygo(path: Path, heights_m: np.ndarray, pitch_m: float) -> None:
    """Writes heights [y, x] as MetroPro does: the top row first, NaN as missing."""
    stored = np.where(np.isnan(heights_m), 2147483640, np.rint(heights_m / (0.5 * WAVELENGTH_UM * 1e-6 / 131072)))
    header = bytearray(834)
    struct.pack_into(">IHI", header, 0, 0x881B0370, 2, 834)
    struct.pack_into(">HH", header, 68, *heights_m.shape[::-1])
    struct.pack_into(">6f", header, 164, 0.5, WAVELENGTH_UM * 1e-6, 0, 1, 0, pitch_m)
    struct.pack_into(">H", header, 218, 2)
    path.write_bytes(bytes(header) + stored[::-1].astype(">i4").tobytes())


def test_a_map_is_read_and_filled(tmp_path: Path) -> None:
    heights = np.arange(20.0).reshape(4, 5) * 1e-9
    heights[0, 4] = np.nan
    zygo(tmp_path / "a.dat", heights, 1e-4)
    found = raylet.read_map(tmp_path / "a.dat")
    assert (found.unit, found.quantity, found.doubts) == ("m", "height", [])
    assert found.pitch_um is not None and np.allclose(found.pitch_um, 100.0)
    assert np.argwhere(found.missing).tolist() == [[0, 4]] and "1 missing" in repr(found)
    np.testing.assert_allclose(found.values, heights, atol=2e-12)
    assert raylet.read_map(tmp_path / "a.dat", fill=0.0).values[0, 4] == 0.0
    nearest = raylet.read_map(tmp_path / "a.dat", fill="nearest")
    assert nearest.values[0, 4] == nearest.values[1, 4]
    np.testing.assert_allclose(nearest.height_um, 1e6 * nearest.values)
    with pytest.raises(raylet.RayletError, match="expected a number or"):
        raylet.read_map(tmp_path / "a.dat", fill="zero")
    np.save(tmp_path / "a.npy", heights)
    with pytest.raises(raylet.RayletError, match="NaN"):
        raylet.read_map(tmp_path / "a.npy")
    with pytest.raises(raylet.RayletError, match=r"\.npy, \.npz, \.dat"):
        raylet.read_map(tmp_path / "a.bmp")


def strehl(tmp_path: Path, amplitude_m: float) -> tuple[float, float]:
    """The Strehl ratio of a lens of f = 100 mm, lit on 4 mm, whose rear has the error of a map, and exp(−φ²)."""
    n, pitch_m, stop = 97, 0.052e-3, 2.0
    y, x = (np.mgrid[:n, :n] - n // 2) * pitch_m * 1e3 / stop
    square, angle = x**2 + y**2, np.arctan2(y, x)

    # Astigmatism, trefoil and spherical aberration, which neither move nor widen the focus to first order.
    shape = square * np.cos(2 * angle) + 0.7 * square**1.5 * np.sin(3 * angle) + 0.4 * (6 * square**2 - 6 * square + 1)
    heights = np.where(square < 1.4, amplitude_m * shape, np.nan)
    zygo(tmp_path / "a.dat", heights, pitch_m)
    measured = raylet.read_map(tmp_path / "a.dat", fill="nearest")

    def peak(factor: float) -> float:
        lens = raylet.System(wavelength_um=WAVELENGTH_UM)
        lens.add_stop(raylet.disc(stop), thickness_mm=0.5)
        lens.add_surface(glass=INDEX, semi_aperture_mm=2.3, thickness_mm=3.0)
        lens.add_surface(
            radius_mm=-50.0,
            conic=-(INDEX**2),
            shape={"kind": "grid", "pitch_um": measured.pitch_um, "height_um": factor * measured.height_um},
            semi_aperture_mm=2.3,
            thickness_mm=100.0,
        )
        lens.add_sensor(pixels=(9, 9), pitch_um=1.0)
        return float(lens.simulate(method="local_bands").intensity[4, 4])

    used = measured.height_um[square < 1]
    phase = 2 * np.pi * (INDEX - 1) * used.std() / WAVELENGTH_UM
    return peak(1.0) / peak(0.0), float(np.exp(-(phase**2)))


@pytest.mark.slow
@pytest.mark.parametrize("amplitude_m", [4e-8, 12e-8])
def test_the_strehl_ratio_of_a_measured_surface(tmp_path: Path, amplitude_m: float) -> None:
    found, expected = strehl(tmp_path, amplitude_m)
    assert abs(found - expected) < 2e-4, (found, expected)


def test_a_scene_takes_a_map_and_refuses_gaps(tmp_path: Path) -> None:
    heights = np.arange(36.0).reshape(6, 6) * 1e-9
    for missing in (False, True):
        heights[2, 3] = np.nan if missing else 1e-8
        zygo(tmp_path / "a.dat", heights, 2e-5)
        shape = {"kind": "grid", "pitch_um": 20.0, "height_um": str(tmp_path / "a.dat")}
        system = raylet.System(wavelength_um=0.5)
        system.add_surface(shape=shape, glass=1.5, semi_aperture_mm=0.04, thickness_mm=1.0)
        system.add_sensor(pixels=(8, 8), pitch_um=5.0)
        if missing:
            with pytest.raises(raylet.RayletError, match=r"1 missing samples of 36, the first at \[2, 3\]"):
                system.simulate()
        else:
            assert np.isfinite(system.simulate().field).all()


def field() -> raylet.SampledField:
    random = np.random.default_rng(3)
    values = random.normal(size=(2, 5, 4)) + 1j * random.normal(size=(2, 5, 4))
    return raylet.SampledField(values, np.arange(4) / 3, np.arange(5) / 7, np.array([0.5, 0.6]))


@pytest.mark.parametrize("end", ["npz", "fits", "h5"])
def test_fields_come_back_bit_by_bit(tmp_path: Path, end: str) -> None:
    given = field()
    report = raylet.write_beam(given, tmp_path / f"a.{end}")
    assert "2 x 5 x 4" in report
    found = raylet.read_beam(tmp_path / f"a.{end}")
    for name in ("field", "x_mm", "y_mm", "wavelength_um"):
        np.testing.assert_array_equal(getattr(found, name), getattr(given, name))
    raylet.write_beam(given, tmp_path / f"b.{end}", wavelength=2)
    np.testing.assert_array_equal(raylet.read_beam(tmp_path / f"b.{end}").field, given.field[1:])
    (tmp_path / f"c.{end}").write_bytes(b"other")
    with pytest.raises(raylet.RayletError):
        raylet.write_beam(given, tmp_path / f"c.{end}")


@pytest.mark.parametrize("end", ["npz", "fits", "h5", "zbf"])
def test_a_field_of_a_file_goes_on_as_a_source(tmp_path: Path, end: str) -> None:
    """A field at 3 mm, through a file, is at 5 mm what the lens itself brings there, wherever its samples lie."""

    def lens(distance_mm: float, side: int) -> raylet.Result:
        system = raylet.System(wavelength_um=0.6328).plane_wave(taper=raylet.beam_taper(0.08))
        system.add_doe(raylet.lens(focal_length_mm=12.0), aperture=raylet.disc(0.25), thickness_mm=distance_mm)
        return system.add_sensor(pixels=(side, side), pitch_um=5.0).simulate()

    # A beam file has its middle on the axis; the others lie 25 µm aside, with the same light.
    near = lens(3.0, 101)
    columns = slice(0 if end == "zbf" else 10, None)
    part = raylet.SampledField(near.field[:, columns], near.x_mm[columns], near.y_mm, np.array([0.6328]))
    raylet.write_beam(part, tmp_path / f"a.{end}")
    found = raylet.read_beam(tmp_path / f"a.{end}")
    own = raylet.System(wavelength_um=0.6328).field_source(found, distance_mm=2.0)
    again, direct = own.add_sensor(pixels=(41, 41), pitch_um=5.0).simulate().field, lens(5.0, 41).field
    error = np.linalg.norm(again - direct) / np.linalg.norm(direct)
    assert error < 2e-3, error


def test_a_source_says_what_it_does_not_take(tmp_path: Path) -> None:
    given = field()
    system = raylet.System(wavelength_um=0.5)
    one = raylet.SampledField(given.field[0], given.x_mm, given.y_mm, np.array([0.5]))
    with pytest.raises(raylet.RayletError, match=r"a field at 0\.5, 0\.6 µm, expected the one wavelength"):
        system.field_source(given, distance_mm=1.0)
    with pytest.raises(raylet.RayletError, match="pitch_um for a SampledField"):
        system.field_source(one, pitch_um=1.0, distance_mm=1.0)
    with pytest.raises(raylet.RayletError, match="tilt_deg"):
        system.field_source(one, distance_mm=1.0, tilt_deg=(1.0, 0.0, 0.0))
    with pytest.raises(raylet.RayletError, match="needs pitch_um"):
        system.field_source(given.field[0], distance_mm=1.0)
    uneven = raylet.SampledField(given.field[0], np.array([0.0, 1.0, 2.0, 4.0]), given.y_mm, np.array([0.5]))
    with pytest.raises(raylet.RayletError, match="x_mm with unequal steps"):
        system.field_source(uneven, distance_mm=1.0)


def test_fields_that_do_not_fit_are_refused(tmp_path: Path) -> None:
    given = field()
    bad = raylet.SampledField(given.field, given.y_mm, given.y_mm, given.wavelength_um)
    with pytest.raises(ValueError, match=r"x_mm has shape \(5,\), expected \(4,\)"):
        raylet.write_beam(bad, tmp_path / "a.fits")
    with pytest.raises(raylet.RayletError, match=r"\.zbf, \.npz, \.fits or \.h5"):
        raylet.write_beam(given, tmp_path / "a.bmp")
    with pytest.raises(raylet.RayletError, match="2 wavelengths"):
        raylet.write_beam(given, tmp_path / "a.zbf")


def test_other_programs_read_the_fields(tmp_path: Path) -> None:
    h5py, fits = pytest.importorskip("h5py"), pytest.importorskip("astropy.io.fits")
    given = field()
    raylet.write_beam(given, tmp_path / "a.h5")
    with h5py.File(tmp_path / "a.h5") as file:
        np.testing.assert_array_equal(file["field"][()], given.field)
        assert file["x_mm"].attrs["units"] == "mm" and list(file["field"].attrs["axes"])[-1] in ("x_mm", b"x_mm")
    raylet.write_beam(given, tmp_path / "a.fits")
    with fits.open(tmp_path / "a.fits") as file:
        file.verify("exception")
        cube = file[0].data
        np.testing.assert_array_equal(cube[:, 0] + 1j * cube[:, 1], given.field)
        assert file[0].header["WAVELEN"] == pytest.approx(0.5e-6)


def test_maps_of_other_programs_are_read(tmp_path: Path) -> None:
    h5py, fits = pytest.importorskip("h5py"), pytest.importorskip("astropy.io.fits")
    values = np.random.default_rng(4).normal(size=(30, 20)).astype(np.float32)
    with h5py.File(tmp_path / "a.h5", "w") as file:
        made = file.create_dataset("run/height", data=values, chunks=(7, 9), compression="gzip", shuffle=True)
        made.attrs["units"] = "nm"
        file["run/x_um"], file["run/y_um"] = np.arange(20) * 2.0, np.arange(30) * 3.0
        file["other"] = "text"
    found = raylet.read_map(tmp_path / "a.h5", key="run/height")
    np.testing.assert_array_equal(found.values, values)
    assert (found.unit, found.pitch_um) == ("nm", (2.0, 3.0))
    fits.writeto(tmp_path / "a.fits", values, fits.Header({"BUNIT": "nm"}))
    np.testing.assert_array_equal(raylet.read_map(tmp_path / "a.fits").values, values)


def test_pictures_of_tifffile_are_read(tmp_path: Path) -> None:
    tifffile = pytest.importorskip("tifffile")
    for kind in ("uint16", "int16", "float32"):
        values = (100 * np.random.default_rng(5).random((30, 20))).astype(kind)
        tifffile.imwrite(tmp_path / "a.tif", values, compression="zlib")
        np.testing.assert_array_equal(raylet.read_map(tmp_path / "a.tif").values, values[::-1])


def test_results_have_names_for_xarray(tmp_path: Path) -> None:
    xarray = pytest.importorskip("xarray")
    given = field()
    found = given.to_xarray()
    assert isinstance(found, xarray.Dataset) and found.field.dims == ("wavelength_um", "y_mm", "x_mm")
    assert found.x_mm.attrs["units"] == "mm"
    np.testing.assert_array_equal(found.field.sel(wavelength_um=0.6), given.field[1])
