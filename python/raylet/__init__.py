"""raylet: optics made of lenses, mirrors and diffractive elements, simulated and designed.

>>> import numpy as np, raylet
>>> system = (
...     raylet.System(wavelength_um=0.633)
...     .add_doe(raylet.lens(focal_length_mm=20.0), aperture=raylet.disc(0.5), thickness_mm=20.0, name="lens")
...     .add_sensor(pixels=(64, 64), pitch_um=2.0)
... )
>>> result = system.simulate()
>>> result.field.shape
(64, 64)
"""

from raylet import layers
from raylet._raylet import __version__
from raylet._refusal import RayletError
from raylet.design import Design
from raylet.exchange import Map, SampledField, read_beam, read_map, write_beam
from raylet.fabrication import ExportReport, export_element, read_masks
from raylet.functions import phase_function, sag_function
from raylet.layers import (
    annulus,
    axicon,
    disc,
    grating,
    height,
    kinoform,
    lens,
    obstructed,
    phase_grid,
    pixels,
    polygon,
    radial,
    radial_table,
    rectangle,
    regular_polygon,
    superposition,
    two_point,
    vortex,
    xy,
    zernike,
)
from raylet.lenses import Lens, LensFolder, catalog, export_lens
from raylet.rays import Beams, Secondary, beams, gather, gather_adjoint, scatter
from raylet.result import Result
from raylet.sources import ExtendedSource, beam_taper, cone_taper, disc_source, line_source, point_list
from raylet.sweep import Sweep
from raylet.system import System, glasses, load, schema
from raylet.trace import Rays

__all__ = [
    "Beams",
    "Design",
    "ExportReport",
    "ExtendedSource",
    "Lens",
    "LensFolder",
    "Map",
    "RayletError",
    "Rays",
    "Result",
    "SampledField",
    "Secondary",
    "Sweep",
    "System",
    "__version__",
    "annulus",
    "axicon",
    "beam_taper",
    "beams",
    "catalog",
    "cone_taper",
    "disc",
    "disc_source",
    "export_element",
    "export_lens",
    "gather",
    "gather_adjoint",
    "glasses",
    "grating",
    "height",
    "kinoform",
    "layers",
    "lens",
    "line_source",
    "load",
    "obstructed",
    "phase_function",
    "phase_grid",
    "pixels",
    "point_list",
    "polygon",
    "radial",
    "radial_table",
    "read_beam",
    "read_map",
    "read_masks",
    "rectangle",
    "regular_polygon",
    "sag_function",
    "scatter",
    "schema",
    "superposition",
    "two_point",
    "vortex",
    "write_beam",
    "xy",
    "zernike",
]
