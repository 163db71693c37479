"""Elements as files that foundries and other programs take: masks, reliefs, pictures, tables, coefficients."""

from __future__ import annotations

import json
import os
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any, Union

import numpy as np
from numpy.typing import NDArray

from raylet import _raylet
from raylet._arrays import grid, real
from raylet._calls import public_call
from raylet._plain import plain
from raylet._refusal import RayletError, shown
from raylet.layers import Pair
from raylet.system import System

#: A system, an array, or the name of a scene (.toml), an array (.npy, .npz) or a mask file (.gds).
ElementSource = Union[System, str, "os.PathLike[str]", NDArray[Any]]


@dataclass(frozen=True)
class ExportReport:
    """What an export did: its text is what the command line prints, `numbers` has its numbers by their names."""

    text: str
    numbers: dict[str, float] = field(repr=False)

    def __str__(self) -> str:
        return self.text


@public_call
def export_element(
    source: ElementSource,
    path: str | os.PathLike[str],
    *,
    element: str | None = None,
    layer: int | None = None,
    pitch_um: Pair | None = None,
    quantity: str = "phase",
    mirror: bool = False,
    whole_grid: bool = False,
    levels: int | None = None,
    masks: str = "each",
    gds_layer: int = 1,
    aperture_layer: int | None = None,
    etch_bias_um: float = 0.0,
    fill: float | None = None,
    database_unit_nm: float = 1.0,
    size: Sequence[int] | None = None,
    index: float | None = None,
    ambient_index: float | None = None,
    wavelength_um: float | None = None,
    depth_um: float | None = None,
    as_height: bool = False,
    top: str = "stairs",
    base_um: float = 10.0,
    wall_um: float | None = None,
    micrometres: bool = False,
    bits: int = 16,
    terms: int = 8,
    residual_rad: float = 0.5,
    overwrite: bool = False,
) -> ExportReport:
    """Writes a diffractive element for a foundry or another program; the end of `path` decides on the format: .gds,
    .oas, .dxf, .stl, .png, .csv, .dat, .txt (coefficients of a rotational phase) or .npy.

    `source` is a system, whose `element` and `layer` are taken (the only ones by default), an array [y, x] of a
    `quantity` ("phase" in rad, "height" in µm, "amplitude" or "level") with its `pitch_um`, or the name of a file of
    these. The page "Sending an element to a foundry" of the guide says what each format keeps. Files that raylet did
    not write are refused unless `overwrite` is true.
    """
    choices = {
        **{"element": element, "layer": layer, "pitch_um": _pitch("export_element", pitch_um)},
        **{"quantity": quantity, "mirror": mirror, "whole_grid": whole_grid, "levels": levels, "masks": masks},
        **{"gds_layer": gds_layer, "aperture_layer": aperture_layer, "etch_bias_um": etch_bias_um, "fill": fill},
        **{"database_unit_nm": database_unit_nm, "size": size, "index": index, "ambient_index": ambient_index},
        **{"wavelength_um": wavelength_um, "depth_um": depth_um, "as_height": as_height, "top": top},
        **{"base_um": base_um, "wall_um": wall_um, "micrometres": micrometres, "bits": bits, "terms": terms},
        **{"residual_rad": residual_rad, "overwrite": overwrite},
    }
    text, target = json.dumps(plain(choices)), os.fspath(path)
    if isinstance(source, System):
        scene = source._compiled()
        report = _raylet.export_scene(scene, source._arrays, target, text)
    elif isinstance(source, (str, os.PathLike)):
        report = _raylet.export_file(os.fspath(source), target, text)
    else:
        report = _raylet.export_array(grid("raylet.export_element: source", source), target, text)
    return ExportReport(report[0], dict(report[1]))


@public_call
def read_masks(
    path: str | os.PathLike[str],
    *,
    pitch_um: Pair,
    size: Sequence[int] | None = None,
    levels: int | None = None,
    masks: str = "each",
    gds_layer: int = 1,
    aperture_layer: int | None = None,
    etch_bias_um: float = 0.0,
    fill: float | None = None,
) -> NDArray[np.int64]:
    """The levels [y, x] of the cells of a mask file (.gds) whose shapes follow the grid of the cells.

    `size` [nx, ny] is needed where cells at the edge are empty; without it the cells go from the first shape to the
    last. `levels` is needed for binary masks of which the last are empty. `aperture_layer`, `etch_bias_um` and `fill`
    are those with which the masks were written."""
    choices = {
        **{"pitch_um": _pitch("read_masks", pitch_um), "size": size, "levels": levels},
        **{"masks": masks, "gds_layer": gds_layer, "aperture_layer": aperture_layer},
        **{"etch_bias_um": etch_bias_um, "fill": fill},
    }
    found, _ = _raylet.read_masks(os.fspath(path), json.dumps(plain(choices)))
    return found


def _pitch(call: str, value: Pair | None) -> list[float] | None:
    """One number for both axes, or two."""
    if value is None:
        return None
    given = real(f"raylet.{call}: pitch_um", value)
    if given.shape not in ((), (2,)):
        raise RayletError(f"raylet.{call}: pitch_um is {shown(value)}, expected a number, or two for x and y")
    pair: list[float] = np.broadcast_to(given, 2).tolist()
    return pair
