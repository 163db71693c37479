"""`python3 -m fuzz`: the corpus, then random cases, with a table at the end."""

from __future__ import annotations

import argparse
import multiprocessing
import shutil
import signal
import sys
import tempfile
from pathlib import Path
from typing import Any

from fuzz.case import Case, random_case
from fuzz.tally import Tally
from fuzz.trial import Outcome, attempt

CORPUS = Path(__file__).with_name("corpus")


def arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog="python3 -m fuzz", description=__doc__)
    parser.add_argument("--binary", type=Path, default=Path("target/release/raylet"), help="the program")
    parser.add_argument("--cases", type=int, default=2000, help="number of random cases (2000)")
    parser.add_argument("--seed", type=int, default=1, help="seed of the random cases (1)")
    parser.add_argument("--from", type=int, default=0, dest="first", metavar="N", help="first random case (0)")
    parser.add_argument("--jobs", type=int, default=1, help="cases at a time (1)")
    parser.add_argument("--only", metavar="N", help="one random case, or one of the corpus by name; keeps its folder")
    parser.add_argument("--corpus", type=Path, default=CORPUS, help="folder of cases to begin with")
    parser.add_argument("--fallen", type=Path, default=Path("out/fuzz"), help="where fallen cases are kept (out/fuzz)")
    return parser.parse_args()


def corpus(folder: Path) -> list[Case]:
    """The cases of the corpus; the folder `files` in it holds what several of them name."""
    shared = {path.name: path.read_bytes() for path in sorted((folder / "files").glob("*"))}
    return [Case.load(path.parent, shared) for path in sorted(folder.glob("*/case.json"))]


def work(asked: argparse.Namespace, queue: Any, counter: Any, stop: Any, scratch: Path) -> None:
    """One worker: takes the next case until there is none. The main process handles Ctrl-C and requests to end."""
    for asking in (signal.SIGINT, signal.SIGTERM):
        signal.signal(asking, signal.SIG_IGN)
    kept = corpus(asked.corpus) if asked.first == 0 else []
    while not stop.is_set():
        with counter.get_lock():
            number = counter.value
            counter.value += 1
        if number >= len(kept) + asked.cases:
            break
        try:
            case = kept[number] if number < len(kept) else random_case(asked.seed, asked.first + number - len(kept))
            queue.put(attempt(case, asked.binary, scratch, asked.fallen))
        except Exception as error:
            name = f"random-{asked.first + number - len(kept)}"
            queue.put(Outcome(name, "failed", [f"the fuzzer itself: {type(error).__name__}: {error}"]))
    queue.put(None)


def campaign(asked: argparse.Namespace, scratch: Path) -> Tally:
    """Runs all cases with some workers; Ctrl-C lets those finish that have begun."""
    queue: Any = multiprocessing.Queue()
    counter, stop = multiprocessing.Value("q", 0), multiprocessing.Event()
    tally = Tally(asked.cases + (len(corpus(asked.corpus)) if asked.first == 0 else 0))
    workers = [
        multiprocessing.Process(target=work, args=(asked, queue, counter, stop, scratch / str(i)))
        for i in range(asked.jobs)
    ]
    for worker in workers:
        worker.start()
    running = len(workers)
    while running:
        try:
            outcome = queue.get()
            running -= outcome is None
            if outcome is not None:
                tally.add(outcome)
        except KeyboardInterrupt:
            if not stop.is_set():
                print(f"\nstopping; --from {asked.first + max(0, tally.done - asked.jobs)} goes on", flush=True)
            stop.set()
    return tally


def only(asked: argparse.Namespace) -> int:
    """One case, whose folder is kept."""
    known = {case.name: case for case in corpus(asked.corpus)}
    case = known.get(asked.only) or random_case(asked.seed, int(asked.only))
    folder = asked.fallen / f"only-{case.name}"
    shutil.rmtree(folder, ignore_errors=True)
    outcome = attempt(case, asked.binary, folder, None)
    print(f"{case.name} in {folder}: {outcome.end}, {outcome.cpu:.2f} s, {outcome.peak_mb:.0f} MB {outcome.slow}")
    print("\n".join(outcome.reasons) or "not fallen")
    return 1 if outcome.reasons else 0


def main() -> int:
    asked = arguments()
    for asking in (signal.SIGINT, signal.SIGTERM):
        signal.signal(asking, signal.default_int_handler)
    asked.binary = asked.binary.resolve()
    if not asked.binary.is_file():
        sys.exit(f"error: no program {asked.binary}; build it with cargo build --release -p raylet-cli")
    if asked.only is not None:
        return only(asked)
    with tempfile.TemporaryDirectory(prefix="raylet-fuzz-") as scratch:
        tally = campaign(asked, Path(scratch))
    print("\n" + tally.table())
    return 1 if tally.fallen or tally.done < tally.total else 0


if __name__ == "__main__":
    sys.exit(main())
