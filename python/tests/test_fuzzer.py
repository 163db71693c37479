"""What the fuzzer of the program (fuzz/ at the root) counts as a failure, seen with programs that fail on purpose; and
arguments of Python calls that make no sense, which get one clear exception each."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parents[2]))
from fuzz.case import Case, random_case
from fuzz.trial import attempt

CALLS = 4000

FAILURES = {
    "echo 'power NaN mm²'": "not finite",
    "mkdir out; echo '{\"a\": 1e999}' > out/result.json": "not finite",
    "mkdir out; echo a > keep/new": "made outside",
    "echo a > ../new": "made outside",
    "echo a >> .hidden": "changed",
    "rm decoy.txt": "removed",
    "mkdir out; echo 'error: scene.toml: refused' >&2; exit 2": "made outside",
    "exit 2": "no error message",
    "exit 1": "exit code 1",
    "echo \"thread 'main' panicked at\" >&2; exit 101": "panic",
    "kill -9 $$": "exit code -9",
}


@pytest.mark.parametrize("script", FAILURES)
def test_failures_are_seen(tmp_path: Path, script: str) -> None:
    assert FAILURES[script] in "; ".join(failures(tmp_path, script))


def test_good_ends_are_no_failures(tmp_path: Path) -> None:
    assert failures(tmp_path / "a", "mkdir out; echo '{\"a\": 1.5}' > out/result.json; echo 'power 1 mm²'") == []
    assert failures(tmp_path / "b", "echo 'error: scene.toml: nothing in it' >&2; exit 2") == []


def test_seed_and_number_give_the_case() -> None:
    assert random_case(3, 14) == random_case(3, 14) != random_case(4, 14)


def test_no_case_depends_on_those_before_it() -> None:
    cases = [random_case(1, number) for number in range(1500)]
    assert cases == [random_case(1, number) for number in reversed(range(1500))][::-1]


def test_a_number_that_is_cut_off_is_still_a_limit() -> None:
    assert Case("check-1", {"scene.toml": b"memory_limit_mb = 3.35e"}, []).memory_limit_mb() == 3.35


def failures(room: Path, script: str) -> list[str]:
    """Why a program fails that does what a script says."""
    room.mkdir(exist_ok=True)
    program = room / "program"
    program.write_text(f"#!/bin/sh\n{script}\n")
    program.chmod(0o755)
    # A process that is forked off counts the memory of the test run itself as its own: the limit lies above that.
    scene = b"memory_limit_mb = 16000\n"
    case = Case("simulate-1", {"scene.toml": scene}, [["simulate", "scene.toml", "--out", "out"]])
    return attempt(case, program, room / "case", None).reasons


def test_thousands_of_calls() -> None:
    command = [sys.executable, str(Path(__file__).with_name("fuzz_calls.py")), str(CALLS), "1"]
    environment = {**os.environ, "PYTHONFAULTHANDLER": "1"}
    done = subprocess.run(command, env=environment, capture_output=True, text=True, timeout=900)
    assert done.returncode == 0, f"{done.returncode}: {done.stderr[-3000:]}"
    counts, total = done.stdout.rsplit(" ", 1)
    assert int(total) == CALLS and "RayletError" in counts and "returned" in counts
