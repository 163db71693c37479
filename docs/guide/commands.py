"""Runs the commands of each page when the site is built, and puts what they print under them.

A block of the kind `console` has lines that begin with `$ raylet`. They run one after the other in a copy of the
repository's scenes; the pictures that they leave in their folders of results can be shown by name.
"""

from __future__ import annotations

import os
import re
import shlex
import shutil
import subprocess
import tempfile
from pathlib import Path
from typing import Any

from mkdocs.structure.files import File

FENCED = re.compile(r"^```console\n(.*?)^```\n", re.MULTILINE | re.DOTALL)

#: Where `make docs` builds the program.
PROGRAM = Path("target/release/raylet")


def on_page_markdown(markdown: str, page: Any, config: Any, files: Any) -> str:
    """The page with what its commands print; the pictures that they made are files of the site."""
    if not FENCED.search(markdown):
        return markdown
    root = Path(config.config_file_path).parent
    with tempfile.TemporaryDirectory() as folder:
        shutil.copytree(root / "scenes", Path(folder) / "scenes")

        def shown(found: re.Match[str]) -> str:
            commands = commands_of(found.group(1))
            text = "".join(f"{line}\n{output(root, line, folder)}" for line in commands)
            return f"``` {{ .text .no-copy }}\n{text}```\n"

        markdown = FENCED.sub(shown, markdown)
        for picture in sorted(Path(folder).glob("out/**/*.png")):
            name = f"figures/{picture.relative_to(folder)}"
            files.append(File.generated(config, name, content=picture.read_bytes()))
    return markdown


def commands_of(block: str) -> list[str]:
    """The commands of a block; a line that ends with a backslash goes on in the next one."""
    return re.split(r"(?<!\\)\n", block.rstrip("\n"))


def output(root: Path, line: str, folder: str) -> str:
    """What a line `$ raylet …` prints in a folder, progress left out."""
    words = shlex.split(line.removeprefix("$ ").replace("\\\n", " "))
    plain = {**os.environ, "NO_COLOR": "1", "COLUMNS": "80"}
    done = subprocess.run(
        [str(root / PROGRAM), *words[1:]], cwd=folder, env=plain, capture_output=True, text=True
    )
    if done.returncode:
        raise RuntimeError(f"{line}\n{done.stderr}")
    return done.stdout
