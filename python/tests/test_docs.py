"""Every piece of Python in the README and on pages that need PyTorch runs as it stands, from top to bottom. The other
pages of the guide, and its commands, are run when the site is built (docs/guide/snippets.py, commands.py)."""

from __future__ import annotations

import importlib.util
import re
from pathlib import Path

import pytest
from conftest import ROOT

FENCED = re.compile(r"^```python\n(.*?)^```", re.MULTILINE | re.DOTALL)
NEEDS_TORCH = re.compile(r"^# needs: (torch|deeplens)", re.MULTILINE)
GUIDE = sorted((ROOT / "docs" / "guide").glob("*.md"))
PAGES = [*(page for page in GUIDE if NEEDS_TORCH.search(page.read_text())), ROOT / "README.md"]


def marked(page: Path) -> object:
    """A page; those that need PyTorch run where it is, too."""
    marks = [pytest.mark.torch] if NEEDS_TORCH.search(page.read_text()) else []
    return pytest.param(page, marks=marks, id=page.stem)


@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize("page", [marked(page) for page in PAGES])
def test_snippets_run(page: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    matplotlib = pytest.importorskip("matplotlib")
    matplotlib.use("Agg")
    monkeypatch.chdir(tmp_path)
    text, names = page.read_text(), {"__name__": "guide"}
    for found in FENCED.finditer(text):
        code = found.group(1)
        needs = re.match(r"# needs: (\w+)", code)
        if needs and importlib.util.find_spec(needs.group(1)) is None:
            continue
        line = text[: found.start(1)].count("\n")
        exec(compile("\n" * line + code, str(page), "exec"), names)
    import matplotlib.pyplot as plt

    plt.close("all")


FENCES = re.compile(r"^```.*?\n(.*?)^```", re.MULTILINE | re.DOTALL)


@pytest.mark.parametrize("page", [*GUIDE, ROOT / "README.md"], ids=lambda page: page.stem)
def test_code_fits_its_box(page: Path) -> None:
    widest = 120 if page.name == "README.md" else 80
    long = [line for block in FENCES.findall(page.read_text()) for line in block.splitlines() if len(line) > widest]
    assert not long


def test_the_page_of_the_command_line_has_every_verb() -> None:
    """As the README lists them; its commands use no option that the program does not have."""
    page = (ROOT / "docs" / "guide" / "command_line.md").read_text()
    listed = "".join(FENCES.findall((ROOT / "README.md").read_text()))
    verbs = re.findall(r"^raylet (\w+) ", listed, re.MULTILINE)
    assert verbs[:2] == ["simulate", "reference"]
    assert all(f"| `{verb}` |" in page for verb in verbs)
    source = "".join(path.read_text() for path in (ROOT / "crates" / "raylet-cli" / "src").rglob("*.rs"))
    for option in set(re.findall(r"--([a-z-]+)", "".join(FENCES.findall(page)))):
        assert re.search(rf"\b{option.replace('-', '_')}:", source), option
