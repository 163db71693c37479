"""`docs/cross_check.md`: how errors compare with expected ones, and the systems where they are largest."""

from __future__ import annotations

from collections.abc import Sequence
from importlib.metadata import version

import numpy as np
from benches.cross_check.comparison import EXACT, METHODS, Row

HEAD = """# Methods beside each other

`make cross-check` makes this page. {count} random systems 0.1 to 0.8 mm wide: pixels of all forms, analytic phases and
superpositions, apertures of all outlines, one or two screens, three in ten with a plate or a lens behind them. Each is
carried by local bands and by beamlets with the usual target error of 1e-3, and beside them by the method that `auto`
takes for a target of {exact:.0e}. The error is ‖U − U₀‖/‖U₀‖ on the sensor. It is known where the run for comparison
expects less than 0.3 of it. raylet {version}, one thread, seeds {first} to {last}{without}.

Of the runs whose error is known: the part with an error of at most twice the expected one (A), and within a factor of
two of it (B). Of their errors over the expected ones: the median and quantiles.

| method | runs | known | A | B | median | 90 % | 97 % | largest error |
| --- | --- | --- | --- | --- | --- | --- | --- | --- |
"""

WORST = """
The systems whose error is largest beside the expected one (`make cross-check SEED=n` runs one again):

| seed | method | system | expected | error | seconds |
| --- | --- | --- | --- | --- | --- |
"""

REFUSED = """
{count} of the runs were refused. Reasons:

"""

# Rows of the second table.
LISTED = 15


def known(rows: Sequence[Row], method: str) -> list[Row]:
    """The rows of a method whose error is known."""
    return [row for row in rows if row.method == method and row.is_known()]


def summary(rows: Sequence[Row], method: str) -> str:
    """A line of the first table."""
    own = [row for row in rows if row.method == method and not row.refused]
    found = known(rows, method)
    ratios = np.array([row.ratio() for row in found])
    share = [f"{100 * float(np.mean(part)):.0f} %" for part in (ratios <= 2, (ratios <= 2) & (ratios >= 0.5))]
    quantiles = [f"{np.quantile(ratios, part):.2f}" for part in (0.5, 0.9, 0.97)]
    largest = f"{max(row.error for row in found):.1e}"
    return "| " + " | ".join([method, str(len(own)), str(len(found)), *share, *quantiles, largest]) + " |\n"


def page(rows: Sequence[Row]) -> str:
    """The whole page."""
    seeds = sorted({row.seed for row in rows})
    absent = sorted(set(range(seeds[0], seeds[-1])) - set(seeds))
    text = HEAD.format(
        count=len(seeds),
        exact=EXACT,
        version=version("raylet"),
        first=seeds[0],
        last=seeds[-1],
        without=f" without {', '.join(map(str, absent))}" if absent else "",
    ) + "".join(summary(rows, method) for method in METHODS if known(rows, method))
    ranked = sorted((row for method in METHODS for row in known(rows, method)), key=Row.ratio, reverse=True)
    text += WORST + "".join(
        f"| {row.seed} | {row.method} | {row.system} | {row.expected:.1e} | {row.error:.1e} | {row.seconds:.1f} |\n"
        for row in ranked[:LISTED]
    )
    refused = [row for row in rows if row.refused]
    if refused:
        text += REFUSED.format(count=len(refused))
        text += "".join(f"- {row.seed}, {row.method}: {row.system}: {row.refused}\n" for row in refused)
    return text
