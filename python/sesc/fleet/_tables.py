"""Manifests as tables: the path of each log, and what is said of it."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from datetime import date, datetime
from importlib import import_module
from typing import Any

from .._errors import ArgumentError, ArgumentTypeError

__all__ = ["is_table", "rows_of"]


def is_table(given: Any) -> bool:
    """Whether it is a table, and no path or list of paths."""
    if isinstance(given, Mapping) or _is_rows(given):
        return True
    return any(hasattr(given, name) for name in ("columns", "column_names", "__arrow_c_stream__"))


def rows_of(table: Any, by: Sequence[str]) -> list[tuple[str, dict[str, str]]]:
    """Each path with what its row says of it: keys, ``urdf``, ``support``; empty cells say nothing.

    Raises:
        ArgumentError: no column `path`, or a row without a path.
        ArgumentTypeError: a table that cannot be read here.
    """
    columns = _columns(table)
    if "path" not in columns:
        raise ArgumentError(f"the table has no column `path`; it has {', '.join(columns)}")
    used = [name for name in (*by, "day", "urdf", "support") if name in columns]
    rows = []
    for k, cell in enumerate(columns["path"]):
        path = _text(cell)
        if not path:
            raise ArgumentError(f"row {k} of the table, counted from 0, has no path")
        said = {name: _text(columns[name][k]) for name in used}
        rows.append((path, {name: text for name, text in said.items() if text}))
    return rows


def _is_rows(given: Any) -> bool:
    return isinstance(given, Sequence) and bool(given) and all(isinstance(row, Mapping) for row in given)


def _columns(table: Any) -> dict[str, Sequence[Any]]:
    if _is_rows(table):
        keys = dict.fromkeys(str(name) for row in table for name in row)
        return {name: [row.get(name) for row in table] for name in keys}
    if isinstance(table, Mapping):
        return {str(name): _cells(column) for name, column in table.items()}
    if hasattr(table, "collect_schema") and hasattr(table, "collect"):
        # A lazy frame of polars.
        table = table.collect()
    if hasattr(table, "fetchall") and hasattr(table, "columns"):
        # A relation of DuckDB.
        names, rows = [str(name) for name in table.columns], table.fetchall()
        return {name: [row[k] for row in rows] for k, name in enumerate(names)}
    if hasattr(table, "to_pydict"):
        return {str(name): column for name, column in table.to_pydict().items()}
    if hasattr(table, "columns") and hasattr(table, "__getitem__"):
        return {str(name): _cells(table[name]) for name in table.columns}
    if hasattr(table, "__arrow_c_stream__"):
        try:
            pyarrow: Any = import_module("pyarrow")
        except ImportError as error:
            raise ArgumentTypeError(f"a table of {type(table).__name__} needs pyarrow; install it") from error
        found: dict[str, Sequence[Any]] = pyarrow.RecordBatchReader.from_stream(table).read_all().to_pydict()
        return found
    raise ArgumentTypeError(f"a table of {type(table).__name__} cannot be read; give a dict of columns")


def _cells(column: Iterable[Any]) -> Sequence[Any]:
    return list(column)


def _text(cell: Any) -> str | None:
    """A cell as text; None of null, NaN and NaT. Midnight is a date, and a whole number has no point."""
    if type(cell).__name__ == "datetime64":
        # Nanoseconds are beyond Python's own times.
        cell = cell.astype("datetime64[us]").item()
    if cell is None or type(cell).__name__ in ("NAType", "NaTType"):
        return None
    if isinstance(cell, float):
        if math.isnan(cell):
            return None
        return str(int(cell)) if cell.is_integer() else str(cell)
    if isinstance(cell, datetime):
        is_midnight = (cell.hour, cell.minute, cell.second, cell.microsecond) == (0, 0, 0, 0)
        return cell.date().isoformat() if is_midnight else cell.isoformat(sep=" ")
    if isinstance(cell, date):
        return cell.isoformat()
    return str(cell)
