"""Files of other programs, and the commands that read and write them: lens files, masks, beam files, arrays."""

from __future__ import annotations

import re
import struct
from functools import lru_cache
from pathlib import Path

from fuzz import arrays
from fuzz.draft import Draft

LENSES = Path(__file__).parents[1] / "scenes" / "prescriptions"

#: Where a file may go: new places, and places where something is already, which must stay as it is.
OUTS = {"out.{}": 30, "deep/er/out.{}": 1, "a b.{}": 1, "keep/new.{}": 1, "lens.zmx": 0.5, "keep": 0.5, "out": 0.5}
OUTS |= {"decoy.npy": 0.5, "keep/photograph.jpg": 0.5, "decoy.txt/out.{}": 0.5, "": 0.3, "/proc/out.{}": 0.3}
OUTS |= {"µ" * 120 + ".{}": 0.3, "x" * 300 + ".{}": 0.3, "null": 0.3, "../decoy.npy": 0.3}

#: Formats of an element, of which some hold heights alone.
FORMATS = {"gds": 6, "oas": 3, "dxf": 3, "stl": 2, "png": 2, "csv": 2, "dat": 2, "txt": 2, "npy": 3, "pdf": 0.3}

NUMBERS = ["0", "-1", "nan", "inf", "1e-9", "1e308", "1e400", "", "x", "1,2,3", "99999999999999999999"]
WORDS = ["0", "-0", "1e-320", "1e155", "1e308", "nan", "inf", "-1", "2147483648", "1,5", '"', "NO-GLASS", "✗", "1e5"]

#: A table of surfaces, as `raylet import` takes it.
TABLE = b"""# wavelengths_um: 0.5, 0.6
# fields_deg: 0 5
name, radius_mm, thickness_mm, glass, semi_diameter, conic, a4
stop, , 5, , 4,
front, 50, 3, N-BK7, 6, -0.5, 1e-6
back, -50, 40, , 6
"""


@lru_cache
def lenses() -> tuple[tuple[str, bytes], ...]:
    """The public lens files of the repository."""
    found = [path for path in sorted(LENSES.iterdir()) if path.suffix.lower() in (".zmx", ".seq")]
    return (*((path.suffix.lower(), path.read_bytes()) for path in found), (".csv", TABLE))


def files(draft: Draft, verb: str, harm: str) -> dict[str, bytes]:
    """What a command of this verb reads, whole or altered, beside a scene."""
    made = {"import": lens, "export": masks, "convert": beams}[verb](draft)
    if harm in ("none", "special"):
        return made
    name = draft.pick(sorted(made))
    text = name.endswith((".zmx", ".seq", ".csv")) and draft.chance(0.8)
    made[name] = altered_lines(draft, made[name]) if text else altered_bytes(draft, made[name])
    return made


def lens(draft: Draft) -> dict[str, bytes]:
    """One lens file, sometimes under the name of another format."""
    ending, content = draft.pick(lenses())
    if draft.chance(0.03):
        ending = draft.pick([".zmx", ".seq", ".csv", ".zar", ".len", ""])
    return {f"lens{ending}": content}


def altered_lines(draft: Draft, content: bytes) -> bytes:
    """One to four lines lost, doubled, exchanged, or with another word."""
    lines = content.split(b"\n")
    for _ in range(draft.whole(1, 4)):
        at = draft.whole(0, len(lines) - 1)
        kind = draft.weighted({"word": 6, "lose": 2, "double": 1, "exchange": 1, "cut": 0.3})
        if kind == "word":
            words = re.split(rb"([ \t,;]+)", lines[at])
            words[draft.whole(0, len(words) - 1)] = draft.pick(WORDS).encode()
            lines[at] = b"".join(words)
        elif kind == "lose" and len(lines) > 1:
            del lines[at]
        elif kind == "double":
            lines[at:at] = [lines[at]] * draft.pick([1, 1, 30])
        elif kind == "exchange":
            other = draft.whole(0, len(lines) - 1)
            lines[at], lines[other] = lines[other], lines[at]
        else:
            del lines[at + 1 :]
    return b"\n".join(lines)


def altered_bytes(draft: Draft, content: bytes) -> bytes:
    """One to four places of a binary file altered."""
    for _ in range(draft.whole(1, 4)):
        at = draft.whole(0, len(content))
        kind = draft.pick(["flip", "set", "fill", "insert", "lose", "cut"])
        altered = {
            "flip": bytes(byte ^ 1 << draft.whole(0, 7) for byte in content[at : at + 1]) + content[at + 1 :],
            "set": draft.pick([b"\0", b"\1", b"\x7f", b"\x80", b"\xff"]) + content[at + 1 :],
            "fill": draft.pick([b"\x7f", b"\x80", b"\xff"]) * 4 + content[at + 4 :],
            "insert": draft.random.randbytes(draft.whole(1, 64)) + content[at:],
            "lose": content[at + draft.whole(1, 16) :],
            "cut": b"",
        }
        content = content[:at] + altered[kind]
    return content


def record(kind: int, data: bytes = b"") -> bytes:
    """A record of a GDSII file."""
    return struct.pack(">HH", len(data) + 4, kind) + data


def gdsii(draft: Draft) -> bytes:
    """A mask file of rectangles on the grid of 1 µm, at times with an array of a structure of them."""
    head = [record(0x0002, b"\2\x58"), record(0x0102, bytes(24)), record(0x0206, b"AB")]
    head.append(record(0x0305, b"\x3e\x41\x89\x37\x4b\xc6\xa7\xf0" + b"\x39\x44\xb8\x2f\xa0\x9b\x5a\x54"))
    shapes = []
    for _ in range(draft.whole(1, 12)):
        x, y = 1000 * draft.whole(-8, 7), 1000 * draft.whole(-8, 7)
        u, v = x + 1000 * draft.whole(1, 8), y + 1000 * draft.whole(1, 8)
        corners = struct.pack(">10i", x, y, u, y, u, v, x, v, x, y)
        layer, kind = struct.pack(">H", draft.whole(0, 4)), struct.pack(">H", draft.whole(0, 2))
        parts = [(0x0800, b""), (0x0D02, layer), (0x0E02, kind), (0x1003, corners), (0x1100, b"")]
        shapes.append(b"".join(record(*part) for part in parts))
    structure = [record(0x0502, bytes(24)), record(0x0606, b"TI"), *shapes, record(0x0700)]
    if draft.chance(0.3):
        columns, rows = draft.whole(1, 5), draft.whole(1, 5)
        places = struct.pack(">6i", 0, 0, columns * 16_000, 0, 0, rows * 16_000)
        parts = [(0x0502, bytes(24)), (0x0606, b"EL"), (0x0B00, b""), (0x1206, b"TI")]
        parts += [(0x1302, struct.pack(">HH", columns, rows)), (0x1003, places), (0x1100, b""), (0x0700, b"")]
        structure += [record(*part) for part in parts]
    return b"".join([*head, *structure, record(0x0400)])


def masks(draft: Draft) -> dict[str, bytes]:
    """A mask file and an array of levels, phases or complex numbers."""
    nx, ny = draft.whole(1, 20), draft.whole(1, 20)
    numbers: list[float] = [draft.whole(0, 3) * draft.pick([1.0, 1.0, 1.5707963267948966]) for _ in range(2 * nx * ny)]
    descriptor = draft.pick(["<f8", "<f8", "<f4", ">f8", "<c16"])
    count = nx * ny * (2 if descriptor == "<c16" else 1)
    return {"masks.gds": gdsii(draft), "cells.npy": arrays.npy(numbers[:count], (ny, nx), descriptor)}


def beam(draft: Draft) -> bytes:
    """A beam file of OpticStudio, version 1 or the short one of version 0."""
    nx, ny, polarised = draft.whole(1, 9), draft.whole(1, 9), draft.whole(0, 1)
    version = draft.weighted({1: 5, 0: 1})
    head = struct.pack("<5i16x", version, nx, ny, polarised, draft.whole(0, 3))
    steps = [draft.scale(1e-3, 1e-1), draft.scale(1e-3, 1e-1)]
    pilot = [draft.signed(0.01, 100), draft.scale(0.1, 100), draft.scale(0.01, 1)]
    if version == 1:
        numbers = [*steps, *pilot, *pilot, 5e-4, draft.pick([1.0, 1.33]), 1.0, 1.0, *[0.0] * 8]
    else:
        numbers = [*steps, *pilot[:2], 5e-4, *pilot, pilot[2], 1.0]
    samples = [draft.random.gauss(0, 1) for _ in range(2 * nx * ny * (1 + polarised))]
    return head + struct.pack(f"<{len(numbers) + len(samples)}d", *numbers, *samples)


def beams(draft: Draft) -> dict[str, bytes]:
    """A beam file and the field of a result."""
    pixels = (draft.whole(2, 9), draft.whole(2, 9))
    numbers = [draft.random.gauss(0, 1) for _ in range(2 * pixels[0] * pixels[1])]
    return {"beam.zbf": beam(draft), "field.npz": arrays.field(pixels, numbers, draft.scale(1e-3, 1e-2))}


def out(draft: Draft, endings: dict[str, float]) -> list[str]:
    """The option of the file that is written."""
    return ["-o", draft.weighted(OUTS).format(draft.weighted(endings))]


def command(draft: Draft, verb: str, names: list[str]) -> list[str]:
    """A command of this verb about one of these files."""
    source = draft.pick(names) if draft.chance(0.95) else draft.pick(["keep", "decoy.txt", "none", "", "."])
    line = [verb, source]
    if verb == "import":
        line += out(draft, {"toml": 1}) if draft.chance(0.7) else []
        line += ["--skip-unknown"] if draft.chance(0.5) else []
        for option in ("--field", "--wavelength", "--configuration"):
            line += [option, draft.pick(["1", "2", "3", *NUMBERS])] if draft.chance(0.15) else []
        line += ["--glass", draft.pick(["BK7=N-BK7", "NOT=N-BK7", "=", "a"])] if draft.chance(0.1) else []
    elif verb == "convert":
        line += out(draft, {"zbf": 1, "npz": 1, "npy": 0.1})
        line += ["--component", draft.pick(["x", "y", "z"])] if draft.chance(0.2) else []
        line += ["--wavelength", draft.pick(["1", "2", *NUMBERS])] if draft.chance(0.1) else []
        line += ["--sphere"] if draft.chance(0.3) else []
    else:
        line += export_options(draft)
    return line + (["--overwrite"] if draft.chance(0.2) else [])


def export_options(draft: Draft) -> list[str]:
    """Options of an export. Nothing here asks for more cells than are quickly made."""
    line = out(draft, FORMATS)
    usual = {
        "--pitch-um": (0.9, ["1", "1", "1", "0.5,1", "2"]),
        "--quantity": (0.5, ["phase", "height", "amplitude", "level", "level"]),
        "--levels": (0.5, ["2", "4", "4", "8", "3", "32767"]),
        "--masks": (0.3, ["each", "binary", "dose"]),
        "--gds-layer": (0.1, ["0", "1", "200", "32767", "70000"]),
        "--aperture-layer": (0.15, ["99", "1", "65535"]),
        "--etch-bias-um": (0.15, ["0.1", "-0.1", "0.5", "0.0001"]),
        "--fill": (0.1, ["0.81", "1", "1e-5"]),
        "--database-unit-nm": (0.1, ["0.5", "10", "3"]),
        "--size": (0.3, ["16,16", "20,20", "1,1", "0,5"]),
        "--depth-um": (0.3, ["0.5", "3"]),
        "--index": (0.3, ["1.5", "1"]),
        "--wavelength-um": (0.2, ["0.5"]),
        "--top": (0.1, ["stairs", "smooth"]),
        "--base-um": (0.1, ["1", "1e5"]),
        "--bits": (0.1, ["8", "16", "7"]),
        "--terms": (0.2, ["2", "20", "21"]),
        "--residual-rad": (0.2, ["3", "1e-3"]),
        "--element": (0.1, ["first", "none"]),
        "--layer": (0.3, ["0", "1", "7"]),
    }
    for option, (share, values) in usual.items():
        if draft.chance(share):
            line += [option, draft.pick(NUMBERS) if draft.chance(0.04) else draft.pick(values)]
    flags = ("--mirror", "--whole-grid", "--as-height", "--micrometres")
    return line + [flag for flag in flags if draft.chance(0.15)]
