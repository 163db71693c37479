"""Arguments that make no sense get one clear exception each, and never more than that."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

CALLS = 4000


def test_thousands_of_calls() -> None:
    command = [sys.executable, str(Path(__file__).with_name("fuzz_calls.py")), str(CALLS), "1"]
    environment = {**os.environ, "PYTHONFAULTHANDLER": "1"}
    done = subprocess.run(command, env=environment, capture_output=True, text=True, timeout=900)
    assert done.returncode == 0, f"{done.returncode}: {done.stderr[-3000:]}"
    counts, total = done.stdout.rsplit(" ", 1)
    assert int(total) == CALLS and "RayletError" in counts and "returned" in counts
