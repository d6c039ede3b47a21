"""Which logs there are, and whose they are."""

from __future__ import annotations

import glob
import os
from collections.abc import Iterable, Mapping, Sequence
from typing import Any, NamedTuple

__all__ = ["Item", "manifest"]


class Item(NamedTuple):
    """One log of a fleet.

    Attributes:
        path: the file.
        group: its values of ``by``, such as robot and day.
    """

    path: str
    group: tuple[str, ...]


def manifest(given: Any, by: Sequence[str]) -> list[Item]:
    """The logs of a glob, of paths, or of a table with the column ``path``.

    Values of ``by`` come from the table's columns, else from the path's folders
    (``robot=g1/day=2026-01-05/``); ``-`` where neither says them.
    """
    if isinstance(given, (str, os.PathLike)):
        path = os.fspath(given)
        files = [path] if os.path.isfile(path) else glob.glob(path, recursive=True)
        given = [file for file in files if not file.endswith(".toml")]
    if isinstance(given, Mapping) or hasattr(given, "columns"):
        return _of_table(given, by)
    paths = [os.fspath(path) for path in _iterated(given)]
    return sorted(Item(path, _of_path(path, by)) for path in paths)


def _iterated(given: Any) -> Iterable[Any]:
    if isinstance(given, Iterable):
        return given
    raise TypeError(f"a fleet is a glob, paths or a table with the column `path`, not {type(given).__name__}")


def _of_table(table: Any, by: Sequence[str]) -> list[Item]:
    names = [str(name) for name in (table if isinstance(table, Mapping) else table.columns)]
    if "path" not in names:
        raise ValueError(f"the table has no column `path`; it has {', '.join(names)}")
    paths = [str(path) for path in table["path"]]
    columns = [[str(x) for x in table[key]] if key in names else None for key in by]
    items = []
    for k, path in enumerate(paths):
        folders = _of_path(path, by)
        group = (column[k] if column else of_path for column, of_path in zip(columns, folders, strict=True))
        items.append(Item(path, tuple(group)))
    return sorted(items)


def _of_path(path: str, by: Sequence[str]) -> tuple[str, ...]:
    folders = dict(part.split("=", 1) for part in path.replace("\\", "/").split("/") if "=" in part)
    return tuple(folders.get(key, "-") for key in by)
