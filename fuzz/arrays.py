"""Array and picture files from the standard library alone: correct ones, and ones with wrong headers."""

from __future__ import annotations

import io
import struct
import sys
import zipfile
import zlib
from array import array
from collections.abc import Sequence
from functools import lru_cache

#: Bytes that a bomb unpacks to: more than the memory limit of any case and what is allowed above it.
BOMB = 400_000_000


def header(descriptor: str, shape: str, order: str = "False", version: int = 1) -> bytes:
    """What stands before the data of a NumPy array."""
    text = f"{{'descr': {descriptor}, 'fortran_order': {order}, 'shape': {shape}, }}".encode()
    text += b" " * (-(len(text) + 11) % 64) + b"\n"
    length = struct.pack("<H" if version == 1 else "<I", len(text))
    return b"\x93NUMPY" + bytes([version, 0]) + length + text


def npy(numbers: Sequence[float], shape: tuple[int, ...], descriptor: str = "<f8") -> bytes:
    """A NumPy array; complex numbers are pairs of real ones."""
    single = descriptor[1:] in ("f4", "c8")
    data = array("f" if single else "d", numbers)
    if (descriptor[0] == "<") != (sys.byteorder == "little"):
        data.byteswap()
    return header(repr(descriptor), repr(shape)) + data.tobytes()


def npz(parts: dict[str, bytes], packed: bool = False) -> bytes:
    """Several NumPy arrays in an archive, always with the same bytes."""
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w", zipfile.ZIP_DEFLATED if packed else zipfile.ZIP_STORED) as archive:
        for name, content in parts.items():
            archive.writestr(zipfile.ZipInfo(f"{name}.npy"), content, archive.compression)
    return stream.getvalue()


def field(pixels: tuple[int, int], numbers: Sequence[float], pitch: float) -> bytes:
    """The `field.npz` of a result with one channel."""
    nx, ny = pixels
    axis = {"x_mm": [i * pitch for i in range(nx)], "y_mm": [i * pitch for i in range(ny)]}
    parts = {"field": npy(numbers, (1, ny, nx), "<c16"), "wavelength_um": npy([0.5], (1,))}
    return npz({**parts, **{name: npy(places, (len(places),)) for name, places in axis.items()}})


def chunk(kind: bytes, content: bytes) -> bytes:
    """A piece of a PNG file with its length and checksum."""
    return struct.pack(">I", len(content)) + kind + content + struct.pack(">I", zlib.crc32(kind + content))


def png(
    width: int, height: int, depth: int, rows: bytes, colour: int = 0, claimed: tuple[int, int] | None = None
) -> bytes:
    """A picture of these rows; `claimed` is the size that its head claims."""
    size = claimed or (width, height)
    step = len(rows) // height
    lines = b"".join(b"\0" + rows[i * step : (i + 1) * step] for i in range(height))
    head = struct.pack(">IIBBBBB", *size, depth, colour, 0, 0, 0)
    return picture(head, zlib.compress(lines))


def picture(head: bytes, data: bytes) -> bytes:
    """A PNG file of a head and packed data."""
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + chunk(b"IDAT", data) + chunk(b"IEND", b"")


@lru_cache
def packed_zeros(raw: bool) -> bytes:
    """So many zeros, packed."""
    packer = zlib.compressobj(1, zlib.DEFLATED, -15 if raw else 15)
    step = bytes(1_000_000)
    return b"".join(packer.compress(step) for _ in range(BOMB // len(step))) + packer.flush()


def zip_bomb(shape: str, claimed: int) -> bytes:
    """An archive of one array of zeros without end, which says that it takes `claimed` bytes."""
    name, start = b"phase.npy", header("'<f8'", shape)
    body = b"\0" + struct.pack("<HH", len(start), 0xFFFF ^ len(start)) + start + packed_zeros(raw=True)
    both = struct.pack("<HHHHHIII", 20, 0, 8, 0, 33, 0, len(body), claimed)
    local = b"PK\3\4" + both + struct.pack("<HH", len(name), 0) + name
    central = b"PK\1\2" + struct.pack("<H", 20) + both
    central += struct.pack("<HHHHHII", len(name), 0, 0, 0, 0, 0, 0) + name
    end = b"PK\5\6" + struct.pack("<HHHHIIH", 0, 0, 1, 1, len(central), len(local) + len(body), 0)
    return local + body + central + end


def png_bomb(width: int, height: int) -> bytes:
    """A picture of zeros without end, whose head claims this size."""
    return picture(struct.pack(">IIBBBBB", width, height, 8, 0, 0, 0, 0), packed_zeros(raw=False))
