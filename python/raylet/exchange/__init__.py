"""Maps of instruments and fields of other programs, in and out."""

from raylet.exchange.fields import SampledField, read_beam, write_beam
from raylet.exchange.maps import Map, read_map

__all__ = ["Map", "SampledField", "read_beam", "read_map", "write_beam"]
