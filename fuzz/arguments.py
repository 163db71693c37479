"""Random command lines, legal and illegal."""

from __future__ import annotations

from fuzz import exchange
from fuzz.draft import Draft

#: Where results may go: new places, and places where something is already, which must stay as it is.
OUTS = {
    "out": 30,
    "deep/er/out": 2,
    "out/": 1,
    "./a b": 1,
    "keep/../out": 1,
    "keep": 1,
    "decoy.txt": 1,
    "scene.toml": 1,
}
OUTS |= {".": 0.5, "": 0.5, "decoy.txt/out": 0.5, ".hidden": 0.5, "µ" * 100: 0.3, "x" * 300: 0.3, "/proc/out": 0.3}
OUTS |= {"keep/new": 1, "keep/photograph.jpg": 0.5, "null": 0.5}

METHODS = ["auto", "beamlet", "beamlet", "local_bands", "plane", "paper", "Beamlet"]
REFERENCES = ["auto", "angular-spectrum", "rayleigh-sommerfeld", "collins", "gsl", "none"]
NUMBERS = ["1", "1", "2", "0", "-1", "1e3", "99999999999999999999", "nan", "inf", "0.001", "", "x"]
FIELDS = ["0,0", "1,0", "-2,1", "90,0", "1e-300,0", "0,0,-5", "0,0,5", "0.1,0,-1e3", "nan,0", "1", "1,2,3,4", "", "x,y"]
ANY = [
    "--out",
    "--threads",
    "--method",
    "--iterations",
    "--naive",
    "--resume",
    "--help",
    "--version",
    "-",
    "--",
    "-x",
    "é",
]
ANY += [
    "--overwrite",
    "--allow-outside",
    "--most-hours",
    "--memory-limit-mb",
    "--quick",
    "--parts",
    "--out=",
    "--out=out",
    "--field",
    "--follow",
    "--distance-mm",
]


def command(draft: Draft, verb: str, names: list[str]) -> list[list[str]]:
    """One command of this verb, or two where the second goes on from the first; about one of these files where it is
    not about the scene."""
    if verb in ("import", "export", "convert"):
        line = exchange.command(draft, verb, names)
        return [line, line] if draft.chance(0.1) else [line]
    if verb == "junk":
        return [junk(draft)]
    if verb == "compare":
        return [compare(draft)]
    line = [verb, "scene.toml", *options(draft, verb)]
    if draft.chance(0.04):
        line.insert(draft.whole(0, len(line)), draft.pick(ANY))
    if verb in ("simulate", "reference", "hologram", "design") and draft.chance(0.1):
        again = [*line, "--resume"] if verb == "design" and draft.chance(0.6) else line
        return [line, again]
    return [line]


def options(draft: Draft, verb: str) -> list[str]:
    """Options that this verb takes."""
    line: list[str] = []
    if verb not in ("check", "gradcheck") and draft.chance(0.7):
        out = draft.weighted(OUTS)
        line += ["--out", "phase.npy" if verb == "hologram" and out == "out" else out]
    if verb in ("check", "simulate") and draft.chance(0.15):
        line += ["--method", draft.pick(METHODS)]
    if verb == "reference" and draft.chance(0.3):
        line += ["--method", draft.pick(REFERENCES)]
    if verb == "reference" and draft.chance(0.1):
        line += ["--most-hours", draft.pick(NUMBERS)]
    if verb in ("hologram", "design"):
        line += ["--overwrite"] if draft.chance(0.4) else []
        line += ["--allow-outside"] if draft.chance(0.05) else []
        line += ["--iterations", draft.pick(["1", "2", "3", "0", "-1", "x"])] if draft.chance(0.1) else []
    if verb == "hologram" and draft.chance(0.1):
        line += ["--naive"]
    if verb == "design" and draft.chance(0.05):
        line += ["--resume"]
    if draft.chance(0.07):
        line += ["--threads", draft.pick(NUMBERS)]
    if verb == "simulate" and draft.chance(0.1):
        for _ in range(draft.whole(1, 3)):
            line += draft.pick([["--field", draft.pick(FIELDS)], ["--distance-mm", draft.pick(NUMBERS)], ["--follow"]])
    return line


def compare(draft: Draft) -> list[str]:
    """A comparison of two fields, or of something else."""
    sides = [draft.pick([name, name, name, name, "keep", "decoy.txt", "none"]) for name in ("a.npz", "b.npz")]
    line = ["compare", *sides]
    if draft.chance(0.6):
        line += ["--out", draft.weighted(OUTS)]
    if draft.chance(0.2):
        line += ["--memory-limit-mb", draft.pick(NUMBERS)]
    return line


def junk(draft: Draft) -> list[str]:
    """Words in no order. Nothing here starts a study, which would take seconds."""
    words = ["check", "simulate", "schema", "help", "scene.toml", "decoy.txt", "keep", "nan", "", *NUMBERS, *ANY]
    verb = draft.pick(["schema", "schema", "check", "compare", "simulate", "design", "paper", "papers", ""])
    return [verb, *(draft.pick(words) for _ in range(draft.whole(0, 4)))]
