"""Running a fleet: groups to an engine, rows to a store."""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import Executor, ThreadPoolExecutor
from pathlib import Path
from typing import Any

from .. import _run, _sesc
from .._errors import SescError
from .._robot import Robot
from .._sesc import __version__
from ._manifest import Item, manifest
from ._unit import COLUMNS, Job, analyse, content_hash

__all__ = ["Fleet", "run"]


class Fleet:
    """Rows of a fleet, sorted by group; a file that cannot be read is a row with its error.

    ``fleet.columns()`` is what ``polars.DataFrame`` and ``pandas.DataFrame`` take.
    """

    def __init__(self, by: tuple[str, ...], rows: list[dict[str, Any]]) -> None:
        self.by, self.rows = by, rows

    def columns(self) -> dict[str, list[Any]]:
        """The table, by column."""
        names = (*self.by, *COLUMNS)
        return {name: [row[name] for row in self.rows] for name in names}

    @property
    def failed(self) -> list[dict[str, Any]]:
        """Rows with an error."""
        return [row for row in self.rows if row["error"] is not None]

    def to_dict(self) -> dict[str, Any]:
        """Number of groups, and what failed, as ``sesc fleet --json`` has them."""
        groups = {tuple(row[key] for key in self.by) for row in self.rows}
        failed = [{"input": ",".join(row["inputs"]), "error": row["error"]} for row in self.failed]
        return {"groups": len(groups), "failed": failed}

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the rows as JSON, one a line, whole or not at all."""
        lines = [json.dumps(row, sort_keys=True) for row in self.rows]
        _run.written(path, "".join(line + "\n" for line in lines))

    def __len__(self) -> int:
        return len(self.rows)

    def __iter__(self) -> Iterator[dict[str, Any]]:
        return iter(self.rows)

    def __repr__(self) -> str:
        return f"<sesc.fleet.Fleet: {len(self.rows)} rows, {len(self.failed)} failed>"

    def _repr_html_(self) -> str:
        from .._html import table

        names = (*self.by, "verdict", "postures", "sentence", "error")
        return table(repr(self)[1:-1], names, [[row[name] for name in names] for row in self.rows])


def run(
    robot: Robot,
    paths_or_table: Any,
    by: Sequence[str] = ("robot", "day"),
    store: str | os.PathLike[str] | None = None,
    engine: Executor | None = None,
    *,
    support: str | None = None,
    angles: str | None = None,
    prior: str | os.PathLike[str] = "tight",
    noise: float | None = None,
    progress: _run.Progress = False,
) -> Fleet:
    """Fit and diagnose every robot and day of a fleet.

    Args:
        robot: the robot that all logs are of.
        paths_or_table: a glob (``"logs/robot=*/day=*/*.parquet"``), paths, or a table with the
            column ``path`` and columns of ``by``.
        by: what makes a group; from the table's columns or the path's folders.
        store: a folder for rows: a second run reads nothing that was read.
        engine: any ``concurrent.futures.Executor``: processes, Dask's ``client.get_executor()``,
            MPI; threads of this process, one a processor, unless given.
        support, angles, prior, noise: as in :func:`sesc.diagnose`.
        progress: print how far it is, or a function of what is done, how much, and of how much.

    Example:
        >>> sesc.fleet.run(robot, [])
        <sesc.fleet.Fleet: 0 rows, 0 failed>
    """
    by = tuple(by)
    options: dict[str, Any] = {"prior": os.fspath(prior)}
    given = {"support": support, "angles": angles, "noise": noise}
    options |= {key: value for key, value in given.items() if value is not None}
    kept = _Store(store)
    rows: list[dict[str, Any]] = []
    jobs: list[tuple[tuple[str, ...], Job]] = []
    for group, items in _grouped(manifest(paths_or_table, by)).items():
        job, broken = _job(robot, items, options, kept)
        rows += [dict(zip(by, group, strict=True)) | row for row in broken]
        if job is not None:
            jobs.append((group, job))
    told = _run.shown(progress)
    for (group, _), row in zip(jobs, _analysed(jobs, kept, engine, told), strict=True):
        rows.append(dict(zip(by, group, strict=True)) | row)
    _run.ended(progress)
    kept.close()
    return Fleet(by, sorted(rows, key=lambda row: ([row[key] for key in by], row["inputs"])))


def _grouped(items: list[Item]) -> dict[tuple[str, ...], list[Item]]:
    groups: dict[tuple[str, ...], list[Item]] = {}
    for item in items:
        groups.setdefault(item.group, []).append(item)
    return groups


def _job(
    robot: Robot, items: list[Item], options: dict[str, Any], store: _Store
) -> tuple[Job | None, list[dict[str, Any]]]:
    """The job of a group, each content once, and rows of what cannot be read at all."""
    contents: dict[str, str] = {}
    broken = []
    for item in items:
        try:
            contents.setdefault(store.hash_of(item.path), item.path)
        except (SescError, OSError) as error:
            text = str(error).replace(item.path, "the log")
            row = dict.fromkeys(COLUMNS) | {"urdf_hash": robot.hash, "inputs": [], "version": __version__}
            broken.append(row | {"error": f"{type(error).__name__}: {text}"})
    if not contents:
        return None, broken
    inputs = tuple(sorted(contents))
    return Job(robot, tuple(contents[hash] for hash in inputs), inputs, options), broken


def _analysed(
    jobs: list[tuple[tuple[str, ...], Job]],
    store: _Store,
    engine: Executor | None,
    told: Callable[[str, int, int | None], object] | None,
) -> Iterator[dict[str, Any]]:
    """Rows of jobs in their order: from the store, else from the engine."""
    rows: dict[int, dict[str, Any]] = {}
    for k, (_, job) in enumerate(jobs):
        known = store.row(job)
        if known is not None:
            rows[k] = known
    open_jobs = [(k, job) for k, (_, job) in enumerate(jobs) if k not in rows]
    own = ThreadPoolExecutor(os.cpu_count() or 1) if engine is None and open_jobs else None
    try:
        pool = engine or own
        pending = [(k, job, pool.submit(analyse, job)) for k, job in open_jobs] if pool else []
        for done, (k, job, future) in enumerate(pending):
            rows[k] = _alone(job, future.result())
            store.keep(job, rows[k])
            if told is not None:
                told("analysing", done + 1, len(pending))
    finally:
        if own is not None:
            own.shutdown(cancel_futures=True)
    return (rows[k] for k in range(len(jobs)))


def _alone(job: Job, row: dict[str, Any]) -> dict[str, Any]:
    """The row of a group with a log that cannot be used is that of the others, if there are any."""
    if row["error"] is None or len(job.paths) == 1:
        return row
    single = [analyse(job._replace(paths=(p,), inputs=(i,))) for p, i in zip(job.paths, job.inputs, strict=True)]
    good = [k for k, one in enumerate(single) if one["error"] is None]
    if not good or len(good) == len(single):
        return row
    paths, inputs = (tuple(all_[k] for k in good) for all_ in (job.paths, job.inputs))
    rest = analyse(job._replace(paths=paths, inputs=inputs))
    left = "; ".join(f"{one['inputs'][0]}: {one['error']}" for one in single if one["error"] is not None)
    return rest | {"inputs": list(job.inputs), "error": rest["error"] or left}


class _Store:
    """Rows by the hash of what they were made of, and hashes of files that were read."""

    def __init__(self, folder: str | os.PathLike[str] | None) -> None:
        self._folder = None if folder is None else Path(folder)
        self._files: dict[str, Any] = {}
        self._new = False
        if self._folder is not None:
            self._folder.mkdir(parents=True, exist_ok=True)
            index = self._folder / "files.json"
            if index.exists():
                self._files = json.loads(index.read_text())

    def hash_of(self, path: str) -> str:
        about = os.stat(path)
        beside = [f"{path}.toml", str(Path(path).with_suffix(".toml"))]
        sidecar = [os.stat(file).st_mtime_ns for file in beside if os.path.exists(file)]
        mark = [about.st_size, about.st_mtime_ns, *sidecar]
        known = self._files.get(os.path.abspath(path))
        if known is not None and known["mark"] == mark:
            return str(known["hash"])
        found = content_hash(path)
        self._files[os.path.abspath(path)] = {"mark": mark, "hash": found}
        self._new = True
        return found

    def _place(self, job: Job) -> Path | None:
        if self._folder is None:
            return None
        about: Mapping[str, Any] = {
            "urdf": job.robot.hash,
            "snap": job.robot.snap,
            "inputs": job.inputs,
            "options": job.options,
            "version": __version__,
        }
        key = hashlib.sha256(json.dumps(about, sort_keys=True).encode()).hexdigest()[:32]
        return self._folder / f"{key}.json"

    def row(self, job: Job) -> dict[str, Any] | None:
        place = self._place(job)
        if place is None or not place.exists():
            return None
        found: dict[str, Any] = json.loads(place.read_text())
        return found

    def keep(self, job: Job, row: dict[str, Any]) -> None:
        place = self._place(job)
        if place is not None:
            _sesc.write_text(os.fspath(place), json.dumps(row))

    def close(self) -> None:
        if self._folder is not None and self._new:
            _sesc.write_text(os.fspath(self._folder / "files.json"), json.dumps(self._files, sort_keys=True))
