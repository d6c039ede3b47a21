"""Running a fleet: groups to an engine, rows and what they say together."""

from __future__ import annotations

import json
import os
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from threading import Event
from typing import Any

from .. import _run, _sesc
from .._errors import ArgumentTypeError, FitError
from .._model import Robot
from .._words import Angles, Motion, Only, Prior
from ._engines import worked
from ._tables import is_table, rows_of
from ._unit import Job

__all__ = ["COLUMNS", "Fleet", "run"]

#: The columns of the table, in their order.
COLUMNS = _sesc.FLEET_COLUMNS


class Fleet:
    """Rows of a fleet, sorted by robot and day, and what they say together.

    ``fleet.columns()`` is what ``polars.DataFrame`` and ``pandas.DataFrame`` take.

    Example:
        >>> fleet
        <sesc.fleet.Fleet: 6 rows, 0 failed>

    Attributes:
        rows: a dict for each robot and day; ``effects`` and ``health`` are JSON texts.
        shared: effects that robots share, each with its size, deviation and robots.
        changes: what changed in a robot, with the first day on which it is so.
        look_first: robots, the first to look at first.
        failed: logs with errors.
        twice: logs that came more than once.
    """

    def __init__(self, found: _sesc.FleetFound, asked: tuple[Robot, str]) -> None:
        self._found = found
        #: The robot, and the options as JSON.
        self._asked = asked
        self._about: dict[str, Any] = json.loads(found.json())
        self.rows: list[dict[str, Any]] = [dict(zip(COLUMNS, row)) for row in json.loads(found.rows())]

    def columns(self) -> dict[str, list[Any]]:
        """The table, by column.

        Example:
            >>> fleet.columns()["robot"]
            ['r0', 'r1', 'r2', 'r3', 'r4', 'r5']
        """
        return {name: [row[name] for row in self.rows] for name in COLUMNS}

    def to_dict(self) -> dict[str, Any]:
        """What ``sesc fleet --json`` prints, key by key.

        Example:
            >>> fleet.to_dict()["groups"]
            6
        """
        return dict(self._about)

    @property
    def shared(self) -> list[dict[str, Any]]:
        """Effects that robots share, each with its size, deviation and robots.

        Example:
            >>> fleet.shared
            []
        """
        found: list[dict[str, Any]] = self._about["shared"]
        return found

    @property
    def changes(self) -> list[dict[str, Any]]:
        """What changed in a robot, with the first day on which it is so.

        Example:
            >>> fleet.changes
            []
        """
        found: list[dict[str, Any]] = self._about["changes"]
        return found

    @property
    def look_first(self) -> list[str]:
        """Robots, the first to look at first.

        Example:
            >>> len(fleet.look_first) <= len(fleet)
            True
        """
        found: list[str] = self._about["look_first"]
        return found

    @property
    def failed(self) -> list[dict[str, Any]]:
        """Logs with errors: ``input``, ``error``.

        Example:
            >>> fleet.failed
            []
        """
        found: list[dict[str, Any]] = self._about["failed"]
        return found

    @property
    def twice(self) -> list[dict[str, Any]]:
        """Logs that came more than once.

        Example:
            >>> fleet.twice
            []
        """
        found: list[dict[str, Any]] = self._about["twice"]
        return found

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the table to ``.parquet`` or ``.csv``, whole or not at all: the bytes of ``sesc fleet``.

        Raises:
            SescError: a file that cannot be written; it is an ``OSError`` too.

        Example:
            >>> fleet.save(folder / "fleet.csv")
            >>> (folder / "fleet.csv").read_text().startswith("robot,day,")
            True
        """
        self._found.write(os.fspath(path))

    def report(self, path: str | os.PathLike[str], *, pages: int | None = None) -> None:
        """Write the page, ``fleet.html``: what robots share, what changed, what to look at first;
        and beside it a folder ``fleet`` with a page for each of so many robots, 2000 unless
        given, those to look at first before others.

        Raises:
            SescError: a file that cannot be written; it is an ``OSError`` too.

        Example:
            >>> fleet.report(folder / "fleet.html")
            >>> len(list((folder / "fleet").glob("*.html")))
            6
        """
        at = Path(path)
        text, folder, robots = self._found.pages(at.name, pages)
        at.with_name(folder).mkdir(exist_ok=True)
        for robot, page in robots:
            _run.written(os.fspath(at.with_name(folder) / robot), page)
        _run.written(os.fspath(at), text)

    def save_prior(self, path: str | os.PathLike[str]) -> None:
        """Write what is known of the next robot, for ``prior=`` of :func:`sesc.fit` and
        :func:`sesc.diagnose`; :func:`run` has to be called with ``information=True``.

        Raises:
            FitError: fewer than five robots, or no information of theirs.

        Example:
            >>> fleet.save_prior(folder / "population.toml")
            >>> sesc.fit(robot, log, prior=folder / "population.toml", noise=1e-4).rank
            4
        """
        _run.written(os.fspath(path), self._found.population())

    def __reduce__(self) -> tuple[Any, ...]:
        return _restored, (*self._asked, self._found.packed())

    def __len__(self) -> int:
        return len(self.rows)

    def __iter__(self) -> Iterator[dict[str, Any]]:
        return iter(self.rows)

    def __str__(self) -> str:
        return self._found.text()

    def __repr__(self) -> str:
        return f"<sesc.fleet.Fleet: {len(self.rows)} rows, {len(self.failed)} failed>"

    def _repr_html_(self) -> str:
        from .._html import table

        names = ("robot", "day", "verdict", "postures", "sentence", "error")
        return table(repr(self)[1:-1], names, [[row[name] for name in names] for row in self.rows])


def _restored(robot: Robot, options: str, packed: str) -> Fleet:
    return Fleet(_sesc.FleetFound.unpacked(robot, options, packed), (robot, options))


def run(
    robot: Robot,
    paths_or_table: Any,
    by: str | Sequence[str] = ("robot", "day"),
    store: str | os.PathLike[str] | None = None,
    engine: Any = None,
    *,
    support: str | None = None,
    angles: Angles | None = None,
    prior: Prior | None = None,
    noise: float | None = None,
    floor: float = 1e-4,
    motion: Motion = "auto",
    both_feet: bool | None = None,
    other_foot: str | None = None,
    only: Only | None = None,
    information: bool = False,
    threads: int | None = None,
    progress: _run.Progress = False,
) -> Fleet:
    """Fit and diagnose every robot and day of a fleet, and say what robots share and what changed.

    Args:
        robot: the robot of every log that has no URDF of its own.
        paths_or_table: a pattern (``"logs/robot=*/day=*/*.parquet"``), a folder, a list file or a
            manifest, several of these, or a table with the column ``path`` and any of ``by``,
            ``urdf``, ``support``: a dict of columns, a list of dicts, or a table of pandas, polars,
            pyarrow, DuckDB or whatever exports an Arrow stream. Empty cells say nothing.
        by: what makes a group, from the table's columns, the path's folders or the file's name:
            the last is the day, those before it the robot. A text is split at commas:
            ``"site,robot,day"``. ``week`` is the ISO week of ``day``: ``"robot,week"``.
        store: a folder that keeps rows, each in a file under the hash of what it was made from.
        engine: any ``concurrent.futures.Executor`` (processes, Dask's ``client.get_executor()``),
            ``"ray"`` or a SparkSession; threads of this process, one a processor, unless given.
        support, angles, prior, noise, floor, motion: as in :func:`sesc.diagnose`; the parameters
            are fitted with the usual tolerances unless ``prior`` is given.
        both_feet: both soles are flat on one floor in every row; as each log says unless given.
        other_foot: the link that is the other sole.
        only: ``"parameters"`` fits without a diagnosis, in a fraction of the time.
        information: put together what the next robot's parameters are, for
            :meth:`Fleet.save_prior`; rows of ``only="parameters"`` then keep their covariance, as
            those of diagnoses do (19 kB).
        threads: of this process, where there is no ``engine``; one a processor unless given.
        progress: print how far it is, or a function of what is done, how much, of how much, and, if
            it takes a fourth argument, of how many seconds are left (None before that is known).

    Raises:
        FitError: options that make no sense; what is wrong with a log is in its row.
        LogError: a pattern that no file has.
        ArgumentTypeError: no fleet, or no engine.
        ArgumentError: a table without the column ``path``, or with a row that has no path.
        KeyboardInterrupt: Ctrl-C, within 0.2 s; rows that are made stay in the store.

    Example:
        >>> sesc.fleet.run(robot, [])
        <sesc.fleet.Fleet: 0 rows, 0 failed>
    """
    given = {
        "support": support,
        "angles": None if _run.degrees(angles) is None else angles,
        "prior": None if prior is None else os.fspath(prior),
        "noise": _run.number("noise", noise),
        "floor": _run.number("floor", floor),
        "motion": _run.motion(motion),
        "both_feet": both_feet,
        "other_foot": other_foot,
        "snap": robot.snap,
        "only": only,
        "information": True if information else None,
    }
    options = json.dumps({key: value for key, value in given.items() if value is not None})
    threads = None if threads is None else _run.whole("threads", threads, 1, FitError)
    by = _keys(by)
    data, table = _named(paths_or_table, by)
    groups = _sesc.fleet_groups(data, table, by)
    folder = None if store is None else os.fspath(store)
    with _run.showing(progress) as show:
        if engine is None:
            found = _sesc.FleetFound.run(robot, options, groups, folder, show, threads)
        else:
            stop = Event()
            jobs = [Job(robot, options, group, folder, stop) for group in groups]
            done: list[str] = []
            try:
                for one in worked(engine, jobs):
                    done.append(one)
                    if show is not None:
                        show("diagnosing", len(done), len(jobs))
            finally:
                # Ctrl-C, or a `progress` that has enough: threads of an engine end.
                stop.set()
            found = _sesc.FleetFound.gathered(robot, options, done)
    return Fleet(found, (robot, options))


def _keys(by: str | Sequence[str]) -> list[str]:
    """What makes a group; a text is split at commas, as the command does."""
    return by.split(",") if isinstance(by, str) else list(by)


def _named(given: Any, by: Sequence[str]) -> tuple[list[str], list[tuple[str, dict[str, str]]]]:
    """Patterns and files, and the rows of a table with what it says of each path."""
    if isinstance(given, (str, os.PathLike)):
        return [os.fspath(given)], []
    if is_table(given):
        return [], list(rows_of(given, by))
    if not isinstance(given, Iterable):
        raise ArgumentTypeError(
            f"a fleet is a glob, paths or a table with the column `path`, not {type(given).__name__}"
        )
    return [os.fspath(path) for path in given], []
