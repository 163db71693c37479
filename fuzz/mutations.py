"""What is done to a valid scene so that it makes no sense: to its tree, to its text, to its files."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from fuzz import arrays, toml
from fuzz.draft import Draft

NUMBERS = [0, -1, 1, 2, 1e-3, 1e3, 1e-12, 1e-320, 5e-324, 1e155, -1e155, 1e300, 1e308, -1e308, 2**31, 2**53]
NUMBERS += [2**63 - 1, -(2**63), -0.0, 0.1, 90, 180, float("nan"), float("inf"), -float("inf"), toml.Raw("0b11")]
NUMBERS += [toml.Raw("9223372036854775808"), toml.Raw("1e400"), toml.Raw("0x_1"), toml.Raw("+0.0"), toml.Raw("1_000")]

#: Other values than the one that is expected.
VALUES = [
    True,
    "",
    "nan",
    "../nothing.npy",
    "../decoy.npy",
    "first",
    [],
    {},
    [[]],
    [1, [2]],
    {"index": 0.5},
    {"kind": "lens"},
    "\0",
    "✗",
]
VALUES += [toml.Raw("1979-05-27"), toml.Raw("'''\n'''"), "x" * 3000, [0.5] * 500, [{}] * 3, ["a", 1]]

#: Counts of steps: larger ones take longer, as they should.
LABOUR = ("iterations", "rays", "secondary", "each", "checkpoint", "refresh", "orders")


def places(tree: Any) -> Iterator[tuple[Any, Any]]:
    """Every value in a tree, as what holds it and its key there."""
    for key in list(tree) if isinstance(tree, dict) else range(len(tree)):
        yield tree, key
        if isinstance(tree[key], (dict, list)):
            yield from places(tree[key])


def mutate(draft: Draft, tree: dict) -> None:
    """Alters one to three places of a scene, never its memory limit."""
    for _ in range(draft.weighted({1: 6, 2: 2, 3: 1})):
        found = [(holder, key) for holder, key in places(tree) if key not in ("memory_limit_mb", "settings", "version")]
        numbers = [(holder, key) for holder, key in found if is_number(holder[key])]
        if numbers and draft.chance(0.65):
            holder, key = draft.pick(numbers)
            if key not in LABOUR:
                holder[key] = number(draft, holder[key])
        elif found:
            alter(draft, *draft.pick(found))


def is_number(value: object) -> bool:
    return isinstance(value, (int, float)) and not isinstance(value, bool)


def number(draft: Draft, value: float) -> object:
    """Another number, from the table or of another size or sign."""
    kind = draft.weighted({"table": 5, "sign": 1, "size": 2, "type": 0.5})
    if kind == "sign":
        return -value
    if kind == "size":
        return value * draft.pick([10, 0.1, 3, 100, 1e-3])
    return str(value) if kind == "type" else draft.pick(NUMBERS)


def alter(draft: Draft, holder: Any, key: Any) -> None:
    """Takes a value away, doubles or renames it, or puts another in its place."""
    kind = draft.weighted({"drop": 3, "rename": 1, "value": 4, "add": 1, "swap": 1})
    if kind == "drop":
        del holder[key]
    elif kind == "value":
        holder[key] = draft.pick(VALUES)
    elif kind == "swap":
        other = draft.pick(list(holder) if isinstance(holder, dict) else range(len(holder)))
        holder[key], holder[other] = holder[other], holder[key]
    elif isinstance(holder, list):
        holder.insert(draft.whole(0, len(holder)), holder[key])
    else:
        name = draft.pick([f"{key}s", "kind", "name", "shape", "a.b", "", "thickness_mm", "memory_limit_gb"])
        holder[name] = holder.pop(key) if kind == "rename" else holder[key]


def garble(draft: Draft, text: bytes) -> bytes:
    """The text of a scene with bytes that do not belong there."""
    at = draft.whole(0, len(text))
    lines = text.splitlines(keepends=True)
    line = draft.whole(0, len(lines) - 1)
    deep = draft.pick([10, 200, 100_000])
    garbled = {
        "cut": text[:at],
        "flip": text[:at] + bytes(byte ^ 1 << draft.whole(0, 7) for byte in text[at : at + 1]) + text[at + 1 :],
        "insert": text[:at] + draft.random.randbytes(draft.whole(1, 6)) + text[at:],
        "double": b"".join([*lines[: line + 1], *lines[line:]]),
        "lose": b"".join([*lines[:line], *lines[line + 1 :]]),
        "deep list": b"a = " + b"[" * deep + b"]" * deep + b"\n" + text,
        "deep table": text + b"[" + b".".join([b"a"] * deep) + b"]\n",
        "deep inline": text + b"a = " + b"{a = " * deep + b"1" + b"}" * deep,
        "long": b'title = "' + b"x" * draft.pick([5000, 1_000_000]) + b'"\n' + text,
        "long key": b"k" * draft.pick([5000, 300_000]) + b" = 1\n" + text,
        "returns": text.replace(b"\n", b"\r\n"),
        "lone returns": text.replace(b"\n", b"\r"),
        "mark": b"\xef\xbb\xbf" + text,
        "wide": text.decode().encode("utf-16"),
        "latin": 'title = "µ"\n'.encode("latin-1") + text,
        "empty": b"",
        "zeros": b"\0" * 3000,
    }
    return garbled[draft.pick(sorted(garbled))]


def spoil(draft: Draft, name: str, content: bytes) -> bytes:
    """An array or picture that is not what it says."""
    at = draft.whole(0, len(content))
    common = [content[:at], content[:at] + draft.random.randbytes(3) + content[at + 3 :], content + b"\0" * 99, b""]
    if draft.chance(0.3):
        return draft.pick(common)
    return picture(draft) if name.endswith(".png") else array(draft)


def array(draft: Draft) -> bytes:
    """An array of another kind or shape, with values that are no numbers, or whose header is wrong."""
    shape = draft.pick(["(4, 4)", "(0, 4)", "(4,)", "()", "(2, 2, 4)", "(-4, 4)", "(4, 4", "(100000, 100000)"])
    shape = draft.pick([shape, "(9223372036854775807, 9223372036854775807)", "(4294967296, 4294967296)", "(16, 1)"])
    kind = draft.pick(
        ["'<f8'", "'<f8'", "'|O'", "'<i8'", "'|u1'", "'<c16'", "'<U9'", "[('a', '<f8')]", "'<f16'", "'x'"]
    )
    order = draft.pick(["False", "True", "None"])
    start = arrays.header(kind, shape, order, draft.pick([1, 1, 2, 3, 9]))
    odd = [draft.pick([float("nan"), float("inf"), 1e308, 5e-324, -1e300]) for _ in range(16)]
    choices = {"header": start + bytes(128), "values": arrays.npy(odd, (4, 4)), "archive": archive(draft, start)}
    return choices[draft.weighted({"header": 5, "values": 2, "archive": 2})]


def archive(draft: Draft, start: bytes) -> bytes:
    """An archive with a name too many or too few, or one that unpacks without end."""
    if draft.chance(0.2):
        return arrays.zip_bomb(draft.pick(["(4, 4)", "(5000, 10000)"]), draft.pick([256, arrays.BOMB + 128, 2**32 - 1]))
    names = draft.pick([[], ["phase"], ["a", "b"], ["../phase"], ["phase", "phase"]])
    return arrays.npz(dict.fromkeys(names, start + bytes(128)), draft.chance(0.5))


def picture(draft: Draft) -> bytes:
    """A picture whose head says another size or kind than its data have, or whose data never end."""
    if draft.chance(0.15):
        return arrays.png_bomb(*draft.pick([(4, 4), (20_000, 20_000), (2**31 - 1, 2**31 - 1)]))
    claimed = draft.pick([(4, 4), (0, 4), (5, 5), (2**31 - 1, 1), (60_000, 60_000), (2**32 - 1, 2**32 - 1)])
    depth = draft.pick([8, 16, 1, 4, 7, 0])
    return arrays.png(4, 4, depth, draft.random.randbytes(64), draft.pick([0, 0, 2, 3, 4, 6, 1]), claimed)
