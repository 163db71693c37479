"""Compares methods on random systems and writes docs/cross_check.md; `make cross-check` runs it."""

from __future__ import annotations

import argparse
import json
import multiprocessing
import os
import time
from dataclasses import asdict
from pathlib import Path

from benches.cross_check.comparison import Row, compared
from benches.cross_check.page import page

PAGE = Path("docs/cross_check.md")


def arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog="python -m benches.cross_check", description=__doc__)
    parser.add_argument("--systems", type=int, default=200, help="number of random systems (200)")
    parser.add_argument("--seed", type=int, help="one system alone; the page is left as it is")
    parser.add_argument("--jobs", type=int, default=os.cpu_count(), help="systems at a time")
    parser.add_argument("--rows", type=Path, default=Path("out/cross_check.jsonl"), help="where rows are kept")
    parser.add_argument("--resume", action="store_true", help="goes on with the rows of a run that was stopped")
    return parser.parse_args()


def told(row: Row) -> str:
    """A row on the terminal."""
    if row.refused:
        return f"{row.seed:5d}  {row.method:11s}  refused: {row.refused[:90]}"
    mark = "!" if row.is_known() and row.ratio() > 2 else " "
    numbers = f"expected {row.expected:.1e}  error {row.error:.1e}  {row.seconds:6.1f} s"
    return f"{row.seed:5d}{mark} {row.method:11s}  {numbers}  {row.system}"


def kept(path: Path) -> list[Row]:
    """The rows of an earlier run."""
    return [Row(**json.loads(line)) for line in path.read_text().splitlines()] if path.exists() else []


def campaign(options: argparse.Namespace) -> list[Row]:
    """The rows of all seeds; each is kept as soon as it is there."""
    options.rows.parent.mkdir(parents=True, exist_ok=True)
    rows = kept(options.rows) if options.resume else []
    if not options.resume:
        options.rows.write_text("")
    done = {row.seed for row in rows}
    todo = [seed for seed in range(options.systems) if seed not in done]
    begin = time.monotonic()
    with multiprocessing.get_context("spawn").Pool(options.jobs) as pool, options.rows.open("a") as file:
        for number, found in enumerate(pool.imap_unordered(compared, todo), 1):
            for row in found:
                file.write(json.dumps(asdict(row)) + "\n")
                print(told(row), flush=True)
            file.flush()
            rows += found
            left = (time.monotonic() - begin) / number * (len(todo) - number)
            print(f"{len(done) + number} of {options.systems}, {left / 60:.0f} min left", end="\r", flush=True)
    return rows


def main() -> None:
    options = arguments()
    if options.seed is not None:
        for row in compared(options.seed):
            print(told(row))
        return
    try:
        rows = campaign(options)
    except KeyboardInterrupt:
        raise SystemExit(f"stopped; --resume goes on with the rows in {options.rows}") from None
    PAGE.write_text(page(sorted(rows, key=lambda row: (row.seed, row.method))))
    print(f"wrote {PAGE}")


if __name__ == "__main__":
    main()
