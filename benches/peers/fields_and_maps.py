"""Maps and fields of raylet and of other programs, each read by the other.

    python -m venv /tmp/peers && /tmp/peers/bin/pip install numpy astropy h5py tifffile prysm poppy xarray .
    /tmp/peers/bin/python benches/peers/fields_and_maps.py

Prints for each format the largest difference between what one program wrote and the other one read.
"""

from __future__ import annotations

import struct
import tempfile
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import poppy
import tifffile
from astropy.io import fits
from prysm.io import read_zygo_dat

import raylet

RANDOM = np.random.default_rng(1)


def say(what: str, ours: Any, theirs: Any) -> None:
    """Prints the largest difference of two arrays, of which both may have gaps."""
    ours, theirs = np.asarray(ours), np.asarray(theirs)
    assert ours.shape == theirs.shape and np.array_equal(np.isnan(ours), np.isnan(theirs)), what
    print(f"{what:60} {np.nanmax(np.abs(ours - theirs)):.2e}")


def zygo(path: Path, mark: int, resolution: int, pictures: int) -> None:
    """A file of MetroPro with random heights, of which a tenth is missing."""
    length = 4096 if mark == 0x881B0371 else 834
    header = bytearray(length)
    struct.pack_into(">IHI", header, 0, mark, 1, length)
    struct.pack_into(">HHH", header, 52, 12, 9, pictures)
    struct.pack_into(">HH", header, 68, 31, 23)
    struct.pack_into(">6f", header, 164, 0.5, 632.8e-9, 0.0, 1.02, 0.0, 1e-4)
    struct.pack_into(">H", header, 218, resolution)
    heights = RANDOM.integers(-100000, 100000, (23, 31))
    heights[RANDOM.random(heights.shape) < 0.1] = 2147483640
    content = bytes(header) + bytes(2 * 12 * 9 * pictures) + heights.astype(">i4").tobytes()
    path.write_bytes(content)


def maps(room: Path) -> None:
    """Maps of other programs, read by raylet."""
    for mark, resolution in ((0x881B036F, 0), (0x881B0370, 1), (0x881B0371, 2)):
        zygo(room / "a.dat", mark, resolution, 2)
        theirs = read_zygo_dat(room / "a.dat")["phase"] * 1e-9
        say(f"MetroPro {mark:#x}, heights in m, prysm", raylet.read_map(room / "a.dat").values, theirs[::-1])
    values = RANDOM.normal(size=(40, 30))
    for kind in ("uint8", "uint16", "int16", "uint32", "float32", "float64"):
        given = (100 * np.abs(values)).astype(kind)
        for packed in (None, "zlib"):
            tifffile.imwrite(room / "a.tif", given, compression=packed)
            say(f"TIFF {kind} {packed}, tifffile", raylet.read_map(room / "a.tif").values, given[::-1])
        fits.writeto(room / "a.fits", given, overwrite=True)
        say(f"FITS {kind}, astropy", raylet.read_map(room / "a.fits").values, given)
        with h5py.File(room / "a.h5", "w") as file:
            file.create_dataset("map", data=given, chunks=(7, 9), compression="gzip", shuffle=True)
        say(f"HDF5 {kind} in packed chunks, h5py", raylet.read_map(room / "a.h5").values, given)


def fields(room: Path) -> None:
    """Fields of raylet, read by other programs, and the other way round."""
    field = RANDOM.normal(size=(2, 20, 16)) + 1j * RANDOM.normal(size=(2, 20, 16))
    axes = (np.arange(16) * 0.01 - 0.075, np.arange(20) * 0.01 - 0.095)
    given = raylet.SampledField(field, *axes, np.array([0.5, 0.6]))
    raylet.write_beam(given, room / "b.fits")
    with fits.open(room / "b.fits") as file:
        file.verify("exception")
        say("FITS field, astropy", file[0].data[:, 0] + 1j * file[0].data[:, 1], field)
        say("FITS positions, astropy", file["X_MM"].data, axes[0])
    raylet.write_beam(given, room / "b.h5")
    with h5py.File(room / "b.h5") as file:
        say(f"HDF5 field in {file['x_mm'].attrs['units']}, h5py", file["field"][()], field)
    wave = poppy.FresnelWavefront(beam_radius=1e-3 * poppy.fresnel.u.m, wavelength=0.5e-6, npix=64, oversample=1)
    wave *= poppy.ScalarTransmission()
    wave.wavefront = wave.wavefront * np.exp(1j * RANDOM.normal(size=wave.wavefront.shape))
    wave.as_fits("complex").writeto(room / "c.fits", overwrite=True)
    found = raylet.read_beam(room / "c.fits")
    say("FITS complex wavefront, POPPY", found.field[0], wave.wavefront)
    print(f"  POPPY's pitch {wave.pixelscale}, raylet's {1e-3 * np.diff(found.x_mm)[0]:.6g} m")


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as folder:
        maps(Path(folder))
        fields(Path(folder))
