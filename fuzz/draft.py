"""A case while it is being drawn: the source of chance and the files beside the scene."""

from __future__ import annotations

import copy
import random
from collections.abc import Sequence
from typing import Any

from fuzz import arrays


class Draft:
    """Everything random comes from one generator, so that seed and number give the whole case."""

    def __init__(self, seed: int, number: int) -> None:
        self.random = random.Random(f"{seed} {number}")
        self.files: dict[str, bytes] = {}

    def chance(self, share: float) -> bool:
        return self.random.random() < share

    def pick(self, among: Sequence[Any]) -> Any:
        """One of these, as a copy: what is done to it later must not reach the next case."""
        return copy.deepcopy(self.random.choice(among))

    def weighted(self, weights: dict[Any, float]) -> Any:
        return self.random.choices(list(weights), list(weights.values()))[0]

    def whole(self, least: int, most: int) -> int:
        return self.random.randint(least, most)

    def number(self, least: float, most: float) -> float:
        """Evenly between two numbers, to a few digits."""
        return float(f"{self.random.uniform(least, most):.5g}")

    def scale(self, least: float, most: float) -> float:
        """Evenly among magnitudes, to a few digits."""
        return float(f"{least * (most / least) ** self.random.random():.4g}")

    def signed(self, least: float, most: float) -> float:
        return self.scale(least, most) * self.pick([-1, 1])

    def pair(self, most: float) -> list[float]:
        return [self.number(-most, most), self.number(-most, most)]

    def file(self, stem: str, ending: str, content: bytes) -> str:
        """Adds a file under a name that is not yet taken."""
        name = f"{stem}{len(self.files)}.{ending}"
        self.files[name] = content
        return name

    def array(self, stem: str, size: Sequence[int], most: float, least: float = 0.0) -> str:
        """Adds a real array of [nx, ny] random numbers."""
        nx, ny = size
        numbers = [self.random.uniform(least, most) for _ in range(nx * ny)]
        content = arrays.npy(numbers, (ny, nx), self.pick(["<f8", "<f8", "<f4", ">f8"]))
        if self.chance(0.1):
            return self.file(stem, "npz", arrays.npz({stem: content}, self.chance(0.5)))
        return self.file(stem, "npy", content)

    def waves(self, stem: str, size: Sequence[int]) -> str:
        """Adds a complex array of [nx, ny] random numbers."""
        nx, ny = size
        parts = [self.random.uniform(-0.7, 0.7) for _ in range(2 * nx * ny)]
        return self.file(stem, "npy", arrays.npy(parts, (ny, nx), self.pick(["<c16", "<c8"])))

    def picture(self, stem: str) -> str:
        """Adds a small grey picture."""
        nx, ny = self.whole(2, 12), self.whole(2, 12)
        depth = self.pick([8, 16])
        return self.file(stem, "png", arrays.png(nx, ny, depth, self.random.randbytes(nx * ny * depth // 8)))
