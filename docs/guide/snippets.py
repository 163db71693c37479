"""Runs the Python of each page when the site is built, and puts what it prints and draws under it.

The variable RAYLET_TESTED_PAGES names pages that are left as they are: python/tests/test_gallery.py has run them."""

from __future__ import annotations

import contextlib
import importlib.util
import io
import os
import re
import tempfile
import warnings
from pathlib import Path
from typing import Any

import matplotlib
from mkdocs.structure.files import File

matplotlib.use("Agg")
import matplotlib.pyplot as plt

#: Pictures of the repository that pages show, beside those of their snippets.
SHOWN = {"demo.png": "docs/demo.png"}

FENCED = re.compile(r"^```python\n(.*?)^```\n", re.MULTILINE | re.DOTALL)
NEEDS = re.compile(r"# needs: (\w+)")


def on_files(files: Any, config: Any) -> Any:
    for name, place in SHOWN.items():
        content = (Path(config.config_file_path).parent / place).read_bytes()
        files.append(File.generated(config, name, content=content))
    return files


def on_page_markdown(markdown: str, page: Any, config: Any, files: Any) -> str:
    """The page with outputs. Its snippets share their names from top to bottom, and a folder of their own."""
    names: dict[str, Any] = {"__name__": "guide"}
    pictures: list[bytes] = []
    stem = page.file.name
    if stem in os.environ.get("RAYLET_TESTED_PAGES", "").split():
        return markdown

    def shown(found: re.Match[str]) -> str:
        code = found.group(1)
        needs = NEEDS.match(code)
        if needs and importlib.util.find_spec(needs.group(1)) is None:
            return found.group(0)
        text, drawn = run(code, names)
        parts = [found.group(0)]
        if text:
            parts.append(f"``` {{ .text .no-copy }}\n{text}```\n")
        for picture in drawn:
            name = f"figures/{stem}-{len(pictures)}.png"
            pictures.append(picture)
            files.append(File.generated(config, name, content=picture))
            parts.append(f"![Figure of the snippet above]({name})\n")
        return "\n".join(parts)

    before = os.getcwd()
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        try:
            return FENCED.sub(shown, markdown)
        finally:
            os.chdir(before)


def run(code: str, names: dict[str, Any]) -> tuple[str, list[bytes]]:
    """What a snippet prints, and the figures that it leaves open, as PNG."""
    printed = io.StringIO()
    with contextlib.redirect_stdout(printed), warnings.catch_warnings():
        warnings.simplefilter("ignore")
        exec(compile(code, "snippet", "exec"), names)
    drawn = []
    for number in plt.get_fignums():
        page = io.BytesIO()
        plt.figure(number).savefig(page, format="png", dpi=90)
        drawn.append(page.getvalue())
    plt.close("all")
    return printed.getvalue(), drawn
