"""What counts as a failure."""

from __future__ import annotations

import io
import json
import math
import os
import re
import signal
import struct
import sys
import zipfile
from array import array
from collections.abc import Iterator
from pathlib import Path, PurePosixPath

from fuzz.case import DECOYS, EXCHANGE, Case
from fuzz.process import WALL_LIMIT, Run

#: What a command may end with: done, or refused.
CODES = (0, 2)

#: Longest error message, in characters.
LONGEST = 2000

#: What the program may take above the scene's memory limit, in units of 10⁶ bytes: itself with its catalogue of
#: glasses, the text of the scene, tables and pictures, which are no arrays.
ALLOWANCE_MB = 64

#: Processor time above which a case is reported as slow, in seconds; `check` should take no time.
SLOW = 20
SLOW_CHECK = 2

NOT_FINITE = re.compile(r"(?<![\w.])[-+]?(nan|inf|infinity)(?![\w.])", re.IGNORECASE)

#: What is kept of a file to see whether it changed: kind, time and content.
Look = dict[str, tuple[int, int, bytes]]


def look(root: Path) -> Look:
    """Everything beneath a folder."""
    found: Look = {}
    for folder, folders, files in os.walk(root):
        for name in [*folders, *files]:
            path = Path(folder, name)
            status = path.lstat()
            kind = status.st_mode & 0o170000
            content = path.read_bytes() if kind == 0o100000 and status.st_size < 1e6 else str(status.st_size).encode()
            plain = kind == 0o100000
            found[str(path.relative_to(root))] = (kind, status.st_mtime_ns if plain else 0, content if plain else b"")
    return found


def judge(case: Case, line: list[str], run: Run, folder: Path, before: Look) -> list[str]:
    """Every reason for which a run fails."""
    reasons = []
    if run.code == -signal.SIGXCPU or run.wall >= WALL_LIMIT:
        return [f"hang: {run.cpu:.0f} s of processor time, {run.wall:.0f} s in all"]
    if run.code not in CODES:
        reasons.append(f"exit code {run.code}")
    if re.search(r"panicked|internal error|RUST_BACKTRACE|memory allocation of", run.err + run.out):
        reasons.append("panic: " + run.err[:300])
    limit = case.memory_limit_mb() + ALLOWANCE_MB
    if run.peak_mb > limit:
        reasons.append(f"memory: {run.peak_mb:.0f} MB, more than {limit:.0f}")
    reasons += touched(case, line, run, folder, before)
    if run.code == 2:
        reasons += unclear(run.err)
    if run.code == 0:
        reasons += infinite(case, line, run.out, folder, before)
    return reasons


def unclear(err: str) -> Iterator[str]:
    """An error that does not say in a few words what is wrong."""
    _, mark, message = err.partition("error: ")
    if not mark or len(message.strip()) < 10:
        yield f"no error message: {err[-200:]!r}"
    elif len(message) > LONGEST:
        yield f"an error message of {len(message)} characters"


def target(line: list[str]) -> str:
    """Where a command writes, by its option or by default; nothing where it writes nothing."""
    verb = line[0] if line else ""
    for option, after in zip(line, [*line[1:], ""]):
        if option in ("--out", "-o"):
            return after
        if option.startswith("--out="):
            return option.removeprefix("--out=")
    return {"simulate": "scene-out", "reference": "scene-reference", "design": "out/design"}.get(verb, "")


def touched(case: Case, line: list[str], run: Run, folder: Path, before: Look) -> Iterator[str]:
    """Entries that were made, changed or taken away where nothing may be."""
    after = look(folder.parent)
    for name in sorted(before.keys() | after.keys()):
        if before.get(name) == after.get(name):
            continue
        what = "made" if name not in before else "removed" if name not in after else "changed"
        if not may_touch(case, line, run, os.path.relpath(folder.parent / name, folder), what):
            yield f"{what} outside of --out: {name}"


def may_touch(case: Case, line: list[str], run: Run, name: str, what: str) -> bool:
    """Whether a command may do this to what lies under a name in its folder."""
    verb, overwrite = line[0], "--overwrite" in line
    out = os.path.normpath(target(line)) if target(line) else ""
    own = PurePosixPath(name).name.removeprefix(".").removesuffix(".raylet")
    stated = own.encode() in case.files.get("scene.toml", b"") or own == "scene.designed.toml"
    lent = name in {**DECOYS, **case.files, **case.special}
    leads = bool(out) and what == "made" and out.startswith(name + "/")
    # A design that ends with an error leaves its folder with the last checkpoint; its name may stand in the scene too.
    folder = verb == "design" and (name == out or leads)
    if verb in ("hologram", "design") and not folder and (stated or own == PurePosixPath(out).name):
        return run.code == 0 and (overwrite or not lent) and (not name.startswith("../") or "--allow-outside" in line)
    if verb in EXCHANGE:
        # A file, its record, and the scale beside a picture.
        written = own in (PurePosixPath(out).name, PurePosixPath(out).name + ".toml")
        beside = os.path.dirname(name) == os.path.dirname(out)
        return (leads or written and beside and run.code == 0) and (overwrite or not lent)
    beneath = bool(out) and (name + "/").startswith(out + "/") or out == "."
    return (beneath or leads) and not lent and (run.code == 0 or verb == "design" or what == "made" and leads)


def infinite(case: Case, line: list[str], out: str, folder: Path, before: Look) -> Iterator[str]:
    """Numbers that are not finite, in what was said or written. Words of the scene itself are no numbers."""
    texts = [content for name, content in case.files.items() if name == "scene.toml" or name.startswith("lens")]
    words = b" ".join(texts).decode(errors="replace") + " ".join(line)
    own = NOT_FINITE.search(words)
    if found := NOT_FINITE.search(out):
        if not own and "--help" not in line:
            yield f"not finite on standard output: {out[max(0, found.start() - 60) : found.end() + 20]!r}"
    for name, (kind, _, content) in look(folder.parent).items():
        if kind != 0o100000 or before.get(name, (0, 0, b""))[2] == content:
            continue
        if fault := scan(name, content, bool(own)):
            yield f"not finite in {name}: {fault}"


def scan(name: str, content: bytes, own: bool) -> str:
    """What is wrong with the numbers of a file, if anything is."""
    ending = name.rsplit(".", 1)[-1]
    if ending == "npy":
        return scan_array(content)
    if ending == "npz":
        with zipfile.ZipFile(io.BytesIO(content)) as archive:
            return next(filter(None, (scan_array(archive.read(part)) for part in archive.namelist())), "")
    text = content.decode(errors="replace") if ending in ("json", "toml", "csv", "txt", "svg") else ""
    # A checkpoint has a line with its checksum before its JSON, whose strings in base 64 may spell "+NaN".
    body = text if text.startswith("{") else text.partition("\n")[2]
    if ending == "json" and body.startswith(("{", "[")):
        return scan_document(json.loads(body, parse_constant=float))
    return "" if own or not (found := NOT_FINITE.search(text)) else text[max(0, found.start() - 60) : found.end()]


def scan_document(tree: object, path: str = "") -> str:
    """The path of the first number that is not finite."""
    if isinstance(tree, float) and not math.isfinite(tree):
        return f"{path} = {tree}"
    inner = tree.items() if isinstance(tree, dict) else enumerate(tree) if isinstance(tree, list) else ()
    return next(filter(None, (scan_document(one, f"{path}/{key}") for key, one in inner)), "")


def scan_array(content: bytes) -> str:
    """Whether an array of floating-point numbers holds one that is not finite."""
    start = (
        10 + struct.unpack_from("<H", content, 8)[0]
        if content[6] == 1
        else 12 + struct.unpack_from("<I", content, 8)[0]
    )
    kind = re.search(rb"'descr': '([<>=|])([fc])(\d+)'", content[:start])
    if not kind:
        return ""
    single = kind[3] == (b"4" if kind[2] == b"f" else b"8")
    numbers = array("f" if single else "d", content[start:])
    if (kind[1] == b">") != (sys.byteorder == "big"):
        numbers.byteswap()
    return next((f"number {i} is {one}" for i, one in enumerate(numbers) if not math.isfinite(one)), "")
