"""Several runs as a table of few digits: as text that fits into 80 columns, and as HTML."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from html import escape
from typing import Any, NamedTuple

from raylet.result import SUM

#: The names of what a field is: angles of collimated light, or the place of a point source.
FIELDS = {2: ("angle_x_deg", "angle_y_deg"), 3: ("source_x_mm", "source_y_mm", "source_z_mm")}

#: Characters of the widest line of a table that is not split.
WIDTH = 80

#: The most runs that are shown.
_MOST_RUNS = 100

#: Behind an error above the target.
_MARK = "*"

Row = Mapping[str, Any]


class _Column(NamedTuple):
    """A column: where it stands if the table is split ("name": in both parts, "run": in the first, "light": in the
    second), whether an entry that is the same in all runs is said once, and its entry of a run."""

    title: str
    unit: str
    part: str
    once: bool
    entry: Callable[[Row], str | None]


def _field(count: int) -> Callable[[Row], str | None]:
    names = FIELDS[count]
    return lambda row: ", ".join(f"{row[name]:g}" for name in names) if names[0] in row else None


_COLUMNS = (
    _Column("field", "°", "name", True, _field(2)),
    _Column("source", "mm", "name", True, _field(3)),
    _Column("λ", "µm", "name", True, lambda row: f"{row['wavelength_um']:g}"),
    _Column("distance", "mm", "name", True, lambda row: f"{row['distance_mm']:g}" if "distance_mm" in row else None),
    _Column("error", "", "run", False, lambda row: _error(row)),
    _Column("light", "%", "run", False, lambda row: _percent(row["light_share"])),
    _Column("method", "", "run", True, lambda row: row["method"].replace(" ", ", ")),
    _Column("time", "s", "run", False, lambda row: f"{row['seconds']:.{2 if row['seconds'] < 100.0 else 0}f}"),
    _Column("peak", "", "light", False, lambda row: _powers(row["peak"], 2)),
    _Column("at x, y", "mm", "light", False, lambda row: _pair([row["peak_x_mm"], row["peak_y_mm"]], 4)),
    _Column("width x, y", "µm", "light", False, lambda row: _pair([row["fwhm_x_um"], row["fwhm_y_um"]], 2)),
)


class SweepTable:
    """The table of some rows of :attr:`raylet.Sweep.table`, under a title."""

    def __init__(self, title: str, rows: Sequence[Row]) -> None:
        self._title, self._runs = title, len(rows)
        shown = rows[:_MOST_RUNS]
        filled = [(column, [column.entry(row) for row in shown]) for column in _COLUMNS]
        told = [(column, entries) for column, entries in filled if column.part != "name" or any(entries)]
        same = [column.once and len(set(entries)) == 1 < len(entries) for column, entries in told]
        self._same = [
            f"{column.title} {entries[0]} {column.unit}".strip()
            for (column, entries), is_same in zip(told, same)
            if is_same
        ]
        self._columns = [
            (column, [entry or "-" for entry in entries])
            for (column, entries), is_same in zip(told, same)
            if not is_same
        ]
        missed = [row["target_error"] for row in shown if row["target_reached"] is False]
        self._notes = [f"{_MARK} above the target error {_powers(missed[0], 0)}"] if missed else []
        if self._runs > _MOST_RUNS:
            self._notes.append(f"… ({self._runs} runs)")

    @property
    def head(self) -> str:
        """The title, with what is the same in all runs."""
        return f"<{self._title}{'; ' if self._same else ''}{'; '.join(self._same)}>"

    def text(self) -> str:
        """One table if it is not too wide, else two."""
        lines = self._lines("name", "run", "light")
        if any(len(line) > WIDTH for line in lines):
            lines = [*self._lines("name", "run"), *self._lines("name", "light")]
        return "\n".join([self.head, *lines, *(f"  {note}" for note in self._notes)])

    def html(self) -> str:
        """One table, whatever its width."""
        titles = [f"{column.title} in {column.unit}" if column.unit else column.title for column, _ in self._columns]
        head = "".join(f"<th>{escape(title)}</th>" for title in titles)
        rows = zip(*(entries for _, entries in self._columns))
        body = "".join(f"<tr>{''.join(f'<td>{escape(entry)}</td>' for entry in row)}</tr>" for row in rows)
        notes = "".join(f"<p>{escape(note)}</p>" for note in self._notes)
        table = f"<table><thead><tr>{head}</tr></thead><tbody>{body}</tbody></table>"
        return f"<p>{escape(self.head)}</p>{table}{notes}"

    def _lines(self, *parts: str) -> list[str]:
        """The columns of some parts, with units under the titles."""
        columns = []
        for column, entries in self._columns:
            if column.part in parts:
                cells = [column.title, column.unit, *entries]
                width = max(map(len, cells))
                number = column.part != "name" and column.unit
                columns.append([cell.rjust(width) if number else cell.ljust(width) for cell in cells])
        return [f"  {'  '.join(line)}".rstrip() for line in zip(*columns)]


def _error(row: Row) -> str | None:
    """An expected error, marked where it misses the target."""
    mark = _MARK if row["target_reached"] is False else ""
    return None if row["error"] is None else _powers(row["error"], 1) + mark


def _percent(share: float | None) -> str | None:
    """A share of the light. More than all of it is an error of the method, and no share."""
    if share is None:
        return None
    return "> 100" if share > 1.0 + SUM else f"{100.0 * min(share, 1.0):.2f}"


def _pair(values: Sequence[float | None], digits: int) -> str:
    return ", ".join("-" if value is None else f"{value:.{digits}f}" for value in values)


def _powers(value: float, digits: int) -> str:
    """A number as 1.2e-3."""
    mantissa, exponent = f"{value:.{digits}e}".split("e")
    return f"{mantissa}e{int(exponent)}"
