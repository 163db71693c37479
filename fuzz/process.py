"""Runs the program within limits and measures what it took."""

from __future__ import annotations

import os
import resource
import signal
import subprocess
import sys
import time
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

#: Longest processor time, longest wall time, in seconds, and largest file, in bytes. What takes longer hangs.
#: Some verbs send the light through the system a dozen times or more.
CPU_LIMIT = 100
CPU_LIMITS = {"design": 300, "gradcheck": 300}
WALL_LIMIT = 1200
FILE_LIMIT = 200_000_000

#: Characters of its output that are looked at.
SHOWN = 2_000_000


@dataclass
class Run:
    """How a process ended. A signal is a code below zero."""

    code: int
    out: str
    err: str
    cpu: float
    wall: float
    peak_mb: float


def limits(cpu: int) -> None:
    """In the new process, before the program begins."""
    resource.setrlimit(resource.RLIMIT_CPU, (cpu, cpu + 2))
    resource.setrlimit(resource.RLIMIT_FSIZE, (FILE_LIMIT, FILE_LIMIT))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))


def run(line: list[str], folder: Path, spool: Path, cpu: int = CPU_LIMIT) -> Run:
    """Runs a command in a folder with one thread; what it says goes through files `spool`.out and `spool`.err."""
    names = [spool.with_suffix(".out"), spool.with_suffix(".err")]
    environment = {**os.environ, "RAYON_NUM_THREADS": "1", "RUST_BACKTRACE": "1", "NO_COLOR": "1"}
    start = time.monotonic()
    with open(names[0], "wb") as out, open(names[1], "wb") as err:
        process = subprocess.Popen(
            line,
            cwd=folder,
            stdin=subprocess.DEVNULL,
            stdout=out,
            stderr=err,
            env=environment,
            preexec_fn=lambda: limits(cpu),
            start_new_session=True,
        )
        code, usage = wait(process)
    said = [name.read_bytes()[:SHOWN].decode(errors="replace") for name in names]
    unit = 1 if sys.platform == "darwin" else 1024
    seconds = usage.ru_utime + usage.ru_stime
    return Run(code, *said, seconds, time.monotonic() - start, usage.ru_maxrss * unit * 1e-6)


def wait(process: subprocess.Popen[bytes]) -> tuple[int, resource.struct_rusage]:
    """The exit code and what was used; a process that hangs is killed, unless it ends at that moment."""

    def kill(*_: object) -> None:
        with suppress(ProcessLookupError):
            os.kill(process.pid, signal.SIGKILL)

    signal.signal(signal.SIGALRM, kill)
    signal.alarm(WALL_LIMIT)
    _, status, usage = os.wait4(process.pid, 0)
    signal.alarm(0)
    process.returncode = os.waitstatus_to_exitcode(status)
    return process.returncode, usage
