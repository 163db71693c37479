"""The modules of the package import each other without rings."""

from __future__ import annotations

import ast
from pathlib import Path

import pytest

PACKAGE = Path(__file__).parents[1] / "raylet"


def needs(text: str, modules: set[str]) -> set[str]:
    """The modules of the package that a text imports, anywhere but for types alone."""
    found: set[str] = set()

    def look(node: ast.AST) -> None:
        if isinstance(node, ast.If) and ast.unparse(node.test) in ("TYPE_CHECKING", "typing.TYPE_CHECKING"):
            return
        if isinstance(node, ast.Import):
            found.update(alias.name for alias in node.names)
        if isinstance(node, ast.ImportFrom):
            # A relative import starts at the package, which has no folders.
            base = ".".join(part for part in ("raylet" if node.level else "", node.module) if part)
            found.add(base)
            found.update(f"{base}.{alias.name}" for alias in node.names)
        for child in ast.iter_child_nodes(node):
            look(child)

    look(ast.parse(text))
    return {name.removeprefix("raylet.") for name in found if name.startswith("raylet.")} & modules


def ring(sources: dict[str, str]) -> list[str]:
    """The modules that are left when those that need none of the others are taken away, again and again."""
    left = {name: needs(text, set(sources)) - {name} for name, text in sources.items()}
    while free := [name for name, others in left.items() if not others & set(left)]:
        for name in free:
            del left[name]
    return sorted(left)


def test_the_package_has_no_ring() -> None:
    paths = sorted(PACKAGE.glob("*.py"))
    assert len(paths) > 10
    assert ring({path.stem: path.read_text() for path in paths if path.stem != "__init__"}) == []


@pytest.mark.parametrize(
    "bad",
    [
        "from raylet.a import x",
        "from raylet import a",
        "import raylet.a",
        "from . import a",
        "from .a import x",
        "def f():\n    import raylet.a as a",
    ],
)
def test_a_planted_ring_is_found(bad: str) -> None:
    good = {"a": "from raylet.b import y", "b": "from raylet.c import z", "c": "import numpy"}
    assert ring(good) == []
    assert ring({**good, "c": f"if TYPE_CHECKING:\n    {bad.splitlines()[0]}"} if "def" not in bad else good) == []
    assert ring({**good, "c": bad}) == ["a", "b", "c"]
