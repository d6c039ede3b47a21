"""The unit of work: the logs of one robot and day to one row. No engine, no state."""

from __future__ import annotations

from functools import lru_cache
from threading import Event
from typing import Any, NamedTuple

from .. import _sesc
from .._model import Robot, _restore

__all__ = ["Job", "work"]


class Job(NamedTuple):
    """What one call works on; it is pickled to wherever it runs.

    Attributes:
        robot: the robot, unless the group has a URDF of its own.
        options: how the group is looked at, as JSON.
        group: robot, day and paths, as JSON. The paths have to be readable where it runs.
        store: the folder of rows, or None.
        stop: ends the work from another thread of the same process; None arrives elsewhere.

    Example:
        >>> sesc.fleet.Job(robot, "{}", '{"robot": "r07", "day": "1", "logs": []}').store is None
        True
    """

    robot: Robot
    options: str
    group: str
    store: str | None = None
    stop: Event | None = None

    def __reduce__(self) -> tuple[Any, ...]:
        robot, *others = self[:-1]
        return _arrived, ((robot.file, robot.urdf, robot.snap), *others)


#: A worker reads a URDF once, and keeps what all logs of a robot ask for.
_known = lru_cache(maxsize=8)(_restore)


def _arrived(robot: tuple[str, str, bool], *others: Any) -> Job:
    return Job(_known(*robot), *others)


def work(job: Job) -> str:
    """What a group comes to, as JSON: its row, and what is known of its files.

    Raises:
        SescError: a store that cannot be written, or options that make no sense; what is wrong
            with a log is in its row.
        KeyboardInterrupt: Ctrl-C, or :attr:`Job.stop`, within 0.2 s.

    Example:
        >>> sesc.simulate(model, 20, noise=1e-4).save(folder / "r07_1.csv")
        >>> group = {"robot": "r07", "day": "1", "logs": [str(folder / "r07_1.csv")]}
        >>> "row" in sesc.fleet.work(sesc.fleet.Job(robot, '{"support": "foot"}', json.dumps(group)))
        True
    """

    def check() -> None:
        if job.stop is not None and job.stop.is_set():
            raise KeyboardInterrupt("the run was stopped")

    return _sesc.fleet_work(job.robot, job.options, job.group, job.store, check)
