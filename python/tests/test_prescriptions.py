"""Lens files of OpticStudio as systems."""

from __future__ import annotations

import warnings
from pathlib import Path

import pytest

import raylet


def test_a_lens_file_is_a_system(scenes: Path) -> None:
    with pytest.warns(UserWarning, match="real image heights"):
        lens = raylet.load(scenes / "prescriptions" / "lens1.zmx", field=2)
    assert "focal length (mm)                   24.990670" in lens.import_report
    landing = lens.trace(Px=[0.0, 0.3], Py=[0.0, 0.2])
    assert landing.x_mm.shape[-1] == 2
    assert raylet.load(scenes / "spider.toml").import_report == ""


def test_glasses_are_refused_or_replaced(scenes: Path) -> None:
    path = scenes / "prescriptions" / "US08427765-1.ZMX"
    with pytest.raises(raylet.RayletError, match="the unknown glass L-TIM28_MOLD") as caught:
        raylet.load(path)
    assert "OHARA:L-TIM28" in caught.value.hint
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        lens = raylet.load(path, glasses={"L-TIM28_MOLD": "L-TIM28"})
    assert "Glass L-TIM28_MOLD: OHARA:L-TIM28 in its place" in lens.import_report


def test_numbers_of_fields_are_checked(scenes: Path) -> None:
    path = scenes / "prescriptions" / "lens1.zmx"
    with pytest.raises(raylet.RayletError, match="field 9 requested"):
        raylet.load(path, field=9)
    with pytest.raises(raylet.RayletError, match="wavelength 9 requested"):
        raylet.load(path, wavelength=9)
