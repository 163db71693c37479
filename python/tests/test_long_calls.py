"""Long calls: progress, Ctrl-C, threads, forks, and memory that stays where it is."""

from __future__ import annotations

import gc
import os
import resource
import subprocess
import sys
import textwrap
import threading
import time

import numpy as np
import pytest
from conftest import ROOT, hologram, noise, through_lens

import raylet


def test_progress_is_told_and_may_end_the_call() -> None:
    system = raylet.load(ROOT / "scenes" / "paper" / "system1.toml")
    told: list[tuple[float, str]] = []

    class Enough(Exception):
        pass

    def progress(done: float, what: str) -> None:
        told.append((done, what))
        if done > 0.0:
            raise Enough

    with pytest.raises(Enough):
        system.simulate(progress=progress)
    assert all(0.0 <= done <= 1.0 for done, _ in told) and "sensor" in told[-1][1]
    with pytest.raises(TypeError, match="progress is str"):
        system.simulate(progress="yes")


def test_other_python_threads_go_on() -> None:
    """The lock is released: a thread counts while a run is computed."""
    system = through_lens(noise((40, 40)), pixels=(64, 64))
    count, done = 0, threading.Event()

    def work() -> None:
        system.simulate()
        done.set()

    thread = threading.Thread(target=work)
    thread.start()
    while not done.is_set():
        count += 1
        time.sleep(0.001)
    thread.join()
    assert count > 20


def test_threads_do_not_change_a_bit() -> None:
    system = through_lens(noise((20, 20)))
    assert np.array_equal(system.simulate(threads=1).field, system.simulate(threads=3).field)


INTERRUPTED = """
    import os, signal, threading, time
    import raylet
    system = raylet.load("scenes/paper/system1.toml")
    sent = []
    def interrupt():
        time.sleep(1.5)
        sent.append(time.monotonic())
        os.kill(os.getpid(), signal.SIGINT)
    threading.Thread(target=interrupt, daemon=True).start()
    try:
        system.simulate(method="paper", target_error=1e-6)
        print("finished")
    except KeyboardInterrupt:
        print("after", time.monotonic() - sent[0])
    small = raylet.System(wavelength_um=0.5)
    small.add_doe(raylet.vortex(charge=1), aperture=raylet.disc(0.1), thickness_mm=5.0)
    small.add_sensor(pixels=(8, 8), pitch_um=4.0)
    print("then", abs(small.simulate().field).max() > 0.0)
"""


def run(code: str) -> str:
    """What a fresh interpreter says."""
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(filter(None, sys.path))}
    command = [sys.executable, "-c", textwrap.dedent(code)]
    return subprocess.run(command, cwd=ROOT, env=environment, capture_output=True, text=True, timeout=300, check=True).stdout


def test_ctrl_c_ends_a_call_within_half_a_second() -> None:
    after, then = run(INTERRUPTED).splitlines()
    assert float(after.split()[1]) < 0.5
    assert then == "then True"


@pytest.mark.skipif(not hasattr(os, "fork"), reason="needs fork")
def test_a_forked_process_can_compute() -> None:
    code = """
        import os, numpy as np, raylet
        system = raylet.System(wavelength_um=0.5)
        system.add_doe(raylet.vortex(charge=1), aperture=raylet.disc(0.1), thickness_mm=5.0)
        system.add_sensor(pixels=(8, 8), pitch_um=4.0)
        here = system.simulate().field
        child = os.fork()
        if child == 0:
            os._exit(0 if np.array_equal(system.simulate().field, here) else 1)
        print(os.waitpid(child, 0)[1])
    """
    assert run(code).strip() == "0"


def resident() -> float:
    """Memory of this process now, in MB."""
    with open("/proc/self/statm") as file:
        return int(file.read().split()[1]) * resource.getpagesize() / 1e6


@pytest.mark.skipif(not os.path.exists("/proc/self/statm"), reason="needs Linux")
def test_memory_does_not_grow() -> None:
    """A thousand runs and a thousand gradients: fields of 0.6 MB each, far more together than may stay."""
    system, bench = hologram(noise((8, 8)), pixels=(200, 190)), hologram(noise((8, 8)), pixels=(200, 190)).bench("hologram")
    phase = noise((8, 8))

    def once() -> None:
        system.simulate(progress=False)
        passage = bench(phase)
        passage.adjoint(passage.field)

    for _ in range(100):
        once()
    gc.collect()
    before = resident()
    for _ in range(1000):
        once()
    gc.collect()
    assert resident() - before < 20.0
