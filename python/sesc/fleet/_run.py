"""Running a fleet: groups to an engine, rows and what they say together."""

from __future__ import annotations

import json
import os
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from .. import _run, _sesc
from .._robot import Robot
from ._engines import worked
from ._unit import Job

__all__ = ["COLUMNS", "Fleet", "run"]

#: The columns of the table, in their order.
COLUMNS = (
    "robot",
    "day",
    "urdf_hash",
    "support",
    "postures",
    "independent",
    "noise_floor",
    "held_out_rmse",
    "verdict",
    "sentence",
    "effects",
    "health",
    "params",
    "std",
    "inputs",
    "error",
    "version",
)


class Fleet:
    """Rows of a fleet, sorted by robot and day, and what they say together.

    ``fleet.columns()`` is what ``polars.DataFrame`` and ``pandas.DataFrame`` take.

    Attributes:
        rows: a dict for each robot and day; ``effects`` and ``health`` are JSON texts.
        shared: effects that robots share, each with its size, deviation and robots.
        changes: what changed in a robot, with the first day on which it is so.
        look_first: robots, the first to look at first.
        failed: logs with errors.
        twice: logs that came more than once.
    """

    def __init__(self, found: _sesc.FleetFound) -> None:
        self._found = found
        self._about: dict[str, Any] = json.loads(found.json())
        self.rows: list[dict[str, Any]] = json.loads(found.rows())
        for row in self.rows:
            for name in ("effects", "health"):
                row[name] = json.dumps(row[name], separators=(",", ":"), ensure_ascii=False)

    def columns(self) -> dict[str, list[Any]]:
        """The table, by column."""
        return {name: [row[name] for row in self.rows] for name in COLUMNS}

    def to_dict(self) -> dict[str, Any]:
        """What ``sesc fleet --json`` prints, besides its schema."""
        return dict(self._about)

    @property
    def shared(self) -> list[dict[str, Any]]:
        found: list[dict[str, Any]] = self._about["shared"]
        return found

    @property
    def changes(self) -> list[dict[str, Any]]:
        found: list[dict[str, Any]] = self._about["changes"]
        return found

    @property
    def look_first(self) -> list[str]:
        found: list[str] = self._about["look_first"]
        return found

    @property
    def failed(self) -> list[dict[str, Any]]:
        found: list[dict[str, Any]] = self._about["failed"]
        return found

    @property
    def twice(self) -> list[dict[str, Any]]:
        found: list[dict[str, Any]] = self._about["twice"]
        return found

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the table to ``.parquet`` or ``.csv``, whole or not at all: the bytes of ``sesc fleet``."""
        self._found.write(os.fspath(path))

    def report(self, path: str | os.PathLike[str]) -> None:
        """Write the page: what robots share, what changed, what to look at first, every row."""
        _run.written(path, self._found.page())

    def __len__(self) -> int:
        return len(self.rows)

    def __iter__(self) -> Iterator[dict[str, Any]]:
        return iter(self.rows)

    def __repr__(self) -> str:
        return f"<sesc.fleet.Fleet: {len(self.rows)} rows, {len(self.failed)} failed>"

    def _repr_html_(self) -> str:
        from .._html import table

        names = ("robot", "day", "verdict", "postures", "sentence", "error")
        return table(repr(self)[1:-1], names, [[row[name] for name in names] for row in self.rows])


def run(
    robot: Robot,
    paths_or_table: Any,
    by: Sequence[str] = ("robot", "day"),
    store: str | os.PathLike[str] | None = None,
    engine: Any = None,
    *,
    support: str | None = None,
    angles: str | None = None,
    prior: str | os.PathLike[str] | None = None,
    noise: float | None = None,
    progress: _run.Progress = False,
) -> Fleet:
    """Fit and diagnose every robot and day of a fleet, and say what robots share and what changed.

    Args:
        robot: the robot of every log that has no URDF of its own.
        paths_or_table: a pattern (``"logs/robot=*/day=*/*.parquet"``), a folder, a list file or a
            manifest, several of these, or a table with the column ``path`` and any of ``by``,
            ``urdf``, ``support``.
        by: what makes a group, from the table's columns, the path's folders or the file's name:
            the last is the day, those before it the robot.
        store: a folder that keeps rows under the hash of what they were made from.
        engine: any ``concurrent.futures.Executor`` (processes, Dask's ``client.get_executor()``),
            ``"ray"`` or a SparkSession; threads of this process, one a processor, unless given.
        support, angles, prior, noise: as in :func:`sesc.diagnose`; the parameters are fitted with
            the usual tolerances unless ``prior`` is given.
        progress: print how far it is, or a function of what is done, how much, and of how much.

    Example:
        >>> sesc.fleet.run(robot, [])
        <sesc.fleet.Fleet: 0 rows, 0 failed>
    """
    given = {
        "support": support,
        "angles": None if _run.degrees(angles) is None else angles,
        "prior": None if prior is None else os.fspath(prior),
        "noise": noise,
        "snap": robot.snap,
    }
    options = json.dumps({key: value for key, value in given.items() if value is not None})
    data, table = _named(paths_or_table, by)
    groups = _sesc.fleet_groups(data, table, list(by))
    folder = None if store is None else os.fspath(store)
    show = _run.shown(progress)
    if engine is None:
        found = _sesc.FleetFound.run(robot, options, groups, folder, show)
    else:
        jobs = [Job(robot, options, group, folder) for group in groups]
        done = []
        for one in worked(engine, jobs):
            done.append(one)
            if show is not None:
                show("diagnosing", len(done), len(jobs))
        found = _sesc.FleetFound.gathered(robot, done)
    _run.ended(progress)
    return Fleet(found)


def _named(given: Any, by: Sequence[str]) -> tuple[list[str], list[tuple[str, dict[str, str]]]]:
    """Patterns and files, and the rows of a table with what it says of each path."""
    if isinstance(given, (str, os.PathLike)):
        return [os.fspath(given)], []
    if isinstance(given, Mapping) or hasattr(given, "columns"):
        return [], _of_table(given, by)
    if isinstance(given, Iterable):
        return [os.fspath(path) for path in given], []
    raise TypeError(f"a fleet is a glob, paths or a table with the column `path`, not {type(given).__name__}")


def _of_table(table: Any, by: Sequence[str]) -> list[tuple[str, dict[str, str]]]:
    names = [str(name) for name in (table if isinstance(table, Mapping) else table.columns)]
    if "path" not in names:
        raise ValueError(f"the table has no column `path`; it has {', '.join(names)}")
    used = [name for name in (*by, "urdf", "support") if name in names]
    columns = {name: [None if x is None else str(x) for x in table[name]] for name in used}
    rows = []
    for k, path in enumerate(table["path"]):
        said = {name: column[k] for name, column in columns.items()}
        rows.append((str(Path(str(path))), {name: text for name, text in said.items() if text is not None}))
    return rows
