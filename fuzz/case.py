"""A case: files in a folder, and one or two commands that are run there."""

from __future__ import annotations

import json
import os
import re
from dataclasses import dataclass, field
from pathlib import Path

from fuzz import arrays, exchange, toml
from fuzz.arguments import command
from fuzz.draft import Draft
from fuzz.mutations import garble, mutate, spoil
from fuzz.scenes import MEMORY_LIMIT_MB, scene

#: Files that no run may touch.
DECOYS = {
    "decoy.txt": b"nothing to do with raylet\n",
    ".hidden": b"",
    "keep/photograph.jpg": b"the only copy",
    "keep/result.json": b'{"version": 1}',
    "../decoy.npy": b"outside",
}

VERBS = {
    "check": 57,
    "simulate": 2.5,
    "reference": 8,
    "hologram": 14,
    "design": 2.5,
    "gradcheck": 2.5,
    "compare": 10,
    "junk": 3,
    "import": 4,
    "export": 6,
    "convert": 3,
}

#: Verbs about files of other programs.
EXCHANGE = ("import", "export", "convert")

#: What is done to a case: nothing, or the tree, the text, the files or the kinds of files are altered.
HARM = {"none": 52, "tree": 30, "text": 7, "array": 7, "special": 4}


@dataclass
class Case:
    """What is in the folder and what is run there."""

    name: str
    files: dict[str, bytes]
    commands: list[list[str]]
    #: Things that are no plain files, by name: "fifo", "folder", or "link TARGET".
    special: dict[str, str] = field(default_factory=dict)
    #: Why it is known to take long, where it is.
    slow: str = ""

    def lay(self, folder: Path) -> None:
        """Puts everything into a folder that is still to be made; one decoy lies beside it."""
        folder.mkdir(parents=True)
        for name, content in {**DECOYS, **self.files}.items():
            path = folder / name
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_bytes(content)
        for name, kind in {"null": "link /dev/null", **self.special}.items():
            path = folder / name
            path.unlink(missing_ok=True)
            if kind == "fifo":
                os.mkfifo(path)
            elif kind == "folder":
                path.mkdir()
            else:
                path.symlink_to(kind.removeprefix("link "))

    def save(self, folder: Path) -> None:
        """Keeps it as a case of the corpus."""
        folder.mkdir(parents=True, exist_ok=True)
        document = {"commands": self.commands, "special": self.special, "slow": self.slow}
        (folder / "case.json").write_text(json.dumps({k: v for k, v in document.items() if v}, indent=1) + "\n")
        for name, content in self.files.items():
            (folder / name).write_bytes(content)

    @classmethod
    def load(cls, folder: Path, shared: dict[str, bytes]) -> Case:
        """A case of the corpus, with those of the shared files that its scene names."""
        document = json.loads((folder / "case.json").read_text())
        own = [path for path in sorted(folder.iterdir()) if path.name not in ("case.json", "reasons")]
        files = {path.name: path.read_bytes() for path in own}
        text = b"\n".join(files.values())
        files |= {name: content for name, content in shared.items() if name not in files and name.encode() in text}
        return cls(folder.name, files, document["commands"], document.get("special", {}), document.get("slow", ""))

    def memory_limit_mb(self) -> float:
        """The limit of its scene, or the default."""
        number = rb"([0-9]+(?:\.[0-9]+)?(?:e[-+]?[0-9]+)?)"
        found = re.search(rb"memory_limit_mb = " + number, self.files.get("scene.toml", b""))
        return float(found[1]) if found else 4096.0


def random_case(seed: int, number: int, only: str = "") -> Case:
    """The case of this number, of one verb if that is named; nothing else decides it."""
    draft = Draft(seed, number)
    verb = only or draft.weighted(VERBS)
    tree = scene(draft, verb)
    harm = draft.weighted(HARM)
    if harm == "tree":
        mutate(draft, tree)
    text = toml.document(tree).encode(errors="surrogatepass")
    if harm == "text":
        text = garble(draft, text)
    case = Case(f"{verb}-{seed}-{number}", draft.files, [])
    if harm == "array" and case.files:
        name = draft.pick(sorted(case.files))
        case.files[name] = spoil(draft, name, case.files[name])
    case.files["scene.toml"] = text
    if verb == "compare":
        case.files |= fields(draft, harm)
    if verb in EXCHANGE:
        case.files |= exchange.files(draft, verb, harm)
    if harm == "special":
        make_special(draft, case)
    case.commands = command(draft, verb, sources(case, verb))
    return case


def sources(case: Case, verb: str) -> list[str]:
    """The files that a verb about files of other programs is mostly about: an export also of a scene."""
    own = {"import": ("lens",), "export": ("masks.gds", "cells.npy", "scene.toml"), "convert": ("beam", "field.npz")}
    names = sorted({**case.files, **case.special})
    found = [name for name in names if verb in own and name.startswith(own[verb])]
    return found * 4 + names


def make_special(draft: Draft, case: Case) -> None:
    """Turns one of the files, mostly not the scene, into a pipe, a folder, a link or nothing."""
    names = sorted(case.files)
    name = draft.pick([*(name for name in names if name != "scene.toml"), "scene.toml"])
    del case.files[name]
    kind = draft.pick(
        ["fifo", "folder", "link /dev/zero", "link /dev/stdin", f"link {name}", "link /proc/self/mem", ""]
    )
    if kind:
        case.special[name] = kind


def fields(draft: Draft, harm: str) -> dict[str, bytes]:
    """Two results to compare, mostly on one grid."""
    pixels, pitch = (draft.whole(1, 9), draft.whole(1, 9)), draft.scale(1e-3, 1e-2)
    found = {}
    for name in ("a.npz", "b.npz"):
        if draft.chance(0.15):
            pitch *= 2
        numbers = [draft.random.gauss(0, 1) for _ in range(2 * pixels[0] * pixels[1])]
        if draft.chance(0.15):
            numbers[draft.whole(0, len(numbers) - 1)] = draft.pick([float("nan"), float("inf"), 1e200, 0.0])
        if draft.chance(0.1):
            numbers = [0.0] * len(numbers)
        found[name] = arrays.field(pixels, numbers, pitch)
        if harm == "array":
            found[name] = spoil(draft, name, found[name])
    return found


assert MEMORY_LIMIT_MB < arrays.BOMB / 1e6, "a bomb must be larger than what a scene allows"
