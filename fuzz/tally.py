"""Counts how the cases end, and prints it."""

from __future__ import annotations

import sys
import time
from collections import Counter

from fuzz.trial import Outcome


class Tally:
    """How the cases so far have ended."""

    def __init__(self, total: int) -> None:
        self.total, self.done, self.start, self.last_line = total, 0, time.monotonic(), 0.0
        self.failed: list[Outcome] = []
        self.slow: list[Outcome] = []
        self.ends: Counter[tuple[str, str]] = Counter()
        self.seconds: Counter[str] = Counter()
        self.slowest = Outcome("none")
        self.peak = 0.0

    def add(self, outcome: Outcome) -> None:
        self.done += 1
        verb = outcome.name.split("-")[0]
        self.ends[verb, outcome.end] += 1
        self.seconds[verb] += outcome.cpu
        self.slowest = max(self.slowest, outcome, key=lambda one: one.cpu)
        self.peak = max(self.peak, outcome.peak_mb)
        if outcome.reasons:
            self.failed.append(outcome)
            print(f"\nFAILED {outcome.name}: {'; '.join(outcome.reasons)}", flush=True)
        elif outcome.slow:
            self.slow.append(outcome)
        self.progress()

    def progress(self) -> None:
        """A line each second on a terminal, each half minute elsewhere."""
        now, terminal = time.monotonic(), sys.stdout.isatty()
        if now - self.last_line < (1 if terminal else 30) and self.done < self.total:
            return
        self.last_line = now
        rate = self.done / (now - self.start)
        left = (self.total - self.done) / rate
        line = f"{self.done} of {self.total}, {rate:.1f} a second, {left:.0f} s left, {len(self.failed)} failed"
        print(f"\r{line}" if terminal else line, end="" if terminal else "\n", flush=True)

    def table(self) -> str:
        """Cases by verb and end with the program's seconds, then what is worth knowing."""
        ends = sorted({end for _, end in self.ends})
        rows = [["verb", *ends, "seconds"]]
        for verb in sorted({verb for verb, _ in self.ends}):
            rows.append([verb, *(str(self.ends[verb, end]) for end in ends), f"{self.seconds[verb]:.1f}"])
        total = [str(sum(count for (_, one), count in self.ends.items() if one == end)) for end in ends]
        rows.append(["all", *total, f"{sum(self.seconds.values()):.1f}"])
        lines = ["  ".join(f"{cell:>9}" for cell in row) for row in rows]
        lines.append(f"{self.done} cases in {time.monotonic() - self.start:.0f} s; most memory {self.peak:.0f} MB")
        lines.append(f"slowest: {self.slowest.name}, {self.slowest.cpu:.1f} s")
        lines += [f"slow: {one.name} took {one.cpu:.1f} s; {one.slow}" for one in self.slow]
        lines += [f"failed: {one.name}: {'; '.join(one.reasons)[:200]}" for one in self.failed]
        return "\n".join([*lines, f"{len(self.failed)} failed"])
