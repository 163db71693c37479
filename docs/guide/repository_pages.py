"""Pages of the repository outside the guide, as pages of the site: reports of accuracy, limits, files of results."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

from mkdocs.structure.files import File

#: The pages, by their place in the repository, and pictures that they show.
PAGES = [
    "docs/accuracy.md",
    "docs/real_size.md",
    "docs/performance.md",
    "docs/aperture_scaling.md",
    "docs/exact_fields.md",
    "docs/huygens_psf.md",
    "docs/cross_check.md",
    "docs/hybrid_lens.md",
    "docs/limits.md",
    "docs/result.md",
    "docs/design.md",
    "docs/estimators.md",
    "docs/paper.md",
    "docs/rays.md",
    "GLOSSARY.md",
]
PICTURES = [
    "docs/aperture_scaling.png",
    "docs/exact_fields.png",
    "docs/estimators.png",
    "docs/hybrid_lens.png",
    "docs/performance.png",
]

LINK = re.compile(r"\]\(((?!https?:)[^)#\s]+)(#[^)\s]*)?\)")


def on_files(files: Any, config: Any) -> Any:
    """Adds the pages and pictures under their own names, in small letters."""
    root = Path(config.config_file_path).parent
    for place in PAGES:
        text = linked((root / place).read_text())
        files.append(File.generated(config, name_of(place), content=text))
    for place in PICTURES:
        files.append(File.generated(config, name_of(place), content=(root / place).read_bytes()))
    return files


def name_of(place: str) -> str:
    return Path(place).name.lower()


def linked(text: str) -> str:
    """The text with its links to other pages, which all stand in one folder. Of links to other files words stay."""
    pages = {name_of(place) for place in [*PAGES, *PICTURES]}

    def there(found: re.Match[str]) -> str:
        name, part = name_of(found.group(1)), found.group(2) or ""
        guide = "guide/" in found.group(1)
        return f"]({name}{part})" if guide or name in pages else "]"

    return LINK.sub(there, text)
