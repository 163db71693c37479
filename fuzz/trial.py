"""Runs a case in a folder of its own, judges it and keeps it if it fails."""

from __future__ import annotations

import shutil
import signal
from dataclasses import dataclass, field
from pathlib import Path

from fuzz.case import Case
from fuzz.process import CPU_LIMIT, CPU_LIMITS, run
from fuzz.verdict import SLOW, SLOW_CHECK, judge, look


@dataclass
class Outcome:
    """How a case ended."""

    name: str
    end: str = "done"
    reasons: list[str] = field(default_factory=list)
    cpu: float = 0.0
    peak_mb: float = 0.0
    #: Why it is reported as slow though it has not failed.
    slow: str = ""


def attempt(case: Case, binary: Path, folder: Path, keep: Path | None) -> Outcome:
    """Runs every command of a case. `keep` takes failed cases; without it the folder stays."""
    if keep:
        shutil.rmtree(folder, ignore_errors=True)
    case.lay(folder / "files" / "here")
    outcome = Outcome(case.name)
    for line in case.commands:
        step(case, line, binary, folder, outcome)
    if outcome.reasons and keep:
        case.save(keep / case.name)
        (keep / case.name / "reasons").write_text("\n".join(outcome.reasons) + "\n")
    return outcome


def step(case: Case, line: list[str], binary: Path, folder: Path, outcome: Outcome) -> None:
    """Runs and judges one command. Of a case that is known to be slow only the first seconds are looked at."""
    here = folder / "files" / "here"
    before = look(here.parent)
    limit = SLOW_CHECK if case.slow else CPU_LIMITS.get(line[0], CPU_LIMIT)
    done = run([str(binary), *line], here, folder / "said", limit)
    outcome.cpu += done.cpu
    outcome.peak_mb = max(outcome.peak_mb, done.peak_mb)
    if case.slow and done.code == -signal.SIGXCPU:
        outcome.end, outcome.slow = "slow", case.slow
        return
    outcome.reasons += judge(case, line, done, here, before)
    outcome.end = "failed" if outcome.reasons else {0: "done"}.get(done.code, "refused")
    if done.cpu > (SLOW_CHECK if line[0] == "check" else SLOW):
        outcome.slow = f"{line[0]} takes long"
