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

from fuzz.case import VERBS, Case, random_case
from fuzz.tally import Tally
from fuzz.trial import Outcome, attempt

CORPUS = Path(__file__).with_name("corpus")


def arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog="python3 -m fuzz", description=__doc__)
    parser.add_argument("--binary", type=Path, default=Path("target/release/raylet"), help="the program")
    parser.add_argument("--cases", type=int, default=2000, help="number of random cases (2000)")
    parser.add_argument("--verb", choices=sorted(VERBS), default="", help="random cases of this verb alone")
    parser.add_argument("--seed", type=int, default=1, help="seed of the random cases (1)")
    parser.add_argument("--from", type=int, default=0, dest="first", metavar="N", help="first random case (0)")
    parser.add_argument("--jobs", type=int, default=1, help="cases at a time (1)")
    parser.add_argument("--only", metavar="N", help="one random case, or one of the corpus by name; keeps its folder")
    parser.add_argument("--corpus", type=Path, default=CORPUS, help="folder of cases to begin with")
    parser.add_argument("--failed", type=Path, default=Path("out/fuzz"), help="where failed cases are kept (out/fuzz)")
    return parser.parse_args()


def corpus(folder: Path) -> list[Case]:
    """The cases of the corpus; the folder `files` in it holds what several of them name."""
    shared = {path.name: path.read_bytes() for path in sorted((folder / "files").glob("*"))}
    return [Case.load(path.parent, shared) for path in sorted(folder.glob("*/case.json"))]


def begin(options: argparse.Namespace) -> list[Case]:
    """The cases before the random ones."""
    return corpus(options.corpus) if options.first == 0 and not options.verb else []


def drawn(options: argparse.Namespace, number: int) -> Case:
    """The random case of a number."""
    return random_case(options.seed, number, options.verb)


def work(options: argparse.Namespace, queue: Any, counter: Any, stop: Any, scratch: Path) -> None:
    """One worker: takes the next case until there is none. The main process handles Ctrl-C and requests to end."""
    for request in (signal.SIGINT, signal.SIGTERM):
        signal.signal(request, signal.SIG_IGN)
    kept = begin(options)
    while not stop.is_set():
        with counter.get_lock():
            number = counter.value
            counter.value += 1
        if number >= len(kept) + options.cases:
            break
        try:
            case = kept[number] if number < len(kept) else drawn(options, options.first + number - len(kept))
            queue.put(attempt(case, options.binary, scratch, options.failed))
        except Exception as error:
            name = f"random-{options.first + number - len(kept)}"
            queue.put(Outcome(name, "failed", [f"the fuzzer itself: {type(error).__name__}: {error}"]))
    queue.put(None)


def campaign(options: argparse.Namespace, scratch: Path) -> Tally:
    """Runs all cases with some workers; after Ctrl-C only those that have begun are finished."""
    queue: Any = multiprocessing.Queue()
    counter, stop = multiprocessing.Value("q", 0), multiprocessing.Event()
    tally = Tally(options.cases + len(begin(options)))
    workers = [
        multiprocessing.Process(target=work, args=(options, queue, counter, stop, scratch / str(i)))
        for i in range(options.jobs)
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
                print(f"\nstopping; --from {options.first + max(0, tally.done - options.jobs)} goes on", flush=True)
            stop.set()
    return tally


def only(options: argparse.Namespace) -> int:
    """One case, whose folder is kept."""
    known = {case.name: case for case in corpus(options.corpus)}
    case = known.get(options.only) or drawn(options, int(options.only))
    folder = options.failed / f"only-{case.name}"
    shutil.rmtree(folder, ignore_errors=True)
    outcome = attempt(case, options.binary, folder, None)
    print(f"{case.name} in {folder}: {outcome.end}, {outcome.cpu:.2f} s, {outcome.peak_mb:.0f} MB {outcome.slow}")
    print("\n".join(outcome.reasons) or "not failed")
    return 1 if outcome.reasons else 0


def main() -> int:
    options = arguments()
    for request in (signal.SIGINT, signal.SIGTERM):
        signal.signal(request, signal.default_int_handler)
    options.binary = options.binary.resolve()
    if not options.binary.is_file():
        sys.exit(f"error: no program {options.binary}; build it with cargo build --release -p raylet-cli")
    if options.only is not None:
        return only(options)
    with tempfile.TemporaryDirectory(prefix="raylet-fuzz-") as scratch:
        tally = campaign(options, Path(scratch))
    print("\n" + tally.table())
    return 1 if tally.failed or tally.done < tally.total else 0


if __name__ == "__main__":
    sys.exit(main())
