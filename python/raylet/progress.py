"""How far a long call has come."""

from __future__ import annotations

import sys
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any, Union

from raylet._refusal import type_name

Progress = Union[bool, None, Callable[[float, str], Any]]

#: Seconds before a bar appears by itself.
_PATIENCE = 1.0


@contextmanager
def reporting(progress: Progress, words: str = "to '{}'") -> Iterator[Callable[[float, float, str], None] | None]:
    """What the library is to call with (done, all, what), for as long as the call lasts; `words` has a place for it."""
    if progress is not None and not isinstance(progress, bool) and not callable(progress):
        raise TypeError(f"progress is {type_name(progress)}, expected a function, True, False or None")
    if callable(progress):
        report = progress
        yield lambda done, whole, what: report(done / whole if whole else 1.0, words.format(what))
    elif progress is False or (progress is None and not _watched()):
        yield None
    else:
        with _bar(words, patience=_PATIENCE if progress is None else 0.0) as shown:
            yield shown


def _watched() -> bool:
    """Whether somebody looks at a terminal or a notebook."""
    shell = sys.modules.get("IPython")
    notebook = shell is not None and getattr(shell.get_ipython(), "kernel", None) is not None
    return notebook or (sys.stderr is not None and sys.stderr.isatty())


@contextmanager
def _bar(words: str, patience: float) -> Iterator[Callable[[float, float, str], None] | None]:
    try:
        from tqdm.auto import tqdm
    except ImportError:
        if patience == 0.0:
            warnings.warn("progress=True shows a bar by tqdm, which is not installed: pip install tqdm", stacklevel=7)
        yield None
        return
    layout = "{desc} {percentage:3.0f}%|{bar}| {elapsed}<{remaining}"
    with tqdm(total=1.0, leave=False, delay=patience, bar_format=layout) as bar:

        def show(done: float, whole: float, what: str) -> None:
            bar.set_description_str(words.format(what), refresh=False)
            bar.update(min(done / whole if whole else 1.0, 1.0) - bar.n)

        yield show
