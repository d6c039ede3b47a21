"""The unit of work: the logs of one robot and day to one row. No engine, no state."""

from __future__ import annotations

from functools import lru_cache
from typing import Any, NamedTuple

from .. import _sesc
from .._robot import Robot, _restore
from ._objects import Objects

__all__ = ["Job", "work"]


class Job(NamedTuple):
    """What one call works on; it is pickled to wherever it runs.

    Attributes:
        robot: the robot, unless the group has a URDF of its own.
        options: how the group is looked at, as JSON.
        group: robot, day and paths, as JSON. The paths have to be readable where it runs.
        store: the folder of rows, or None; it may be an address.
        disk: what reads and writes addresses, where there are such.
    """

    robot: Robot
    options: str
    group: str
    store: str | None = None
    disk: Objects | None = None

    def __reduce__(self) -> tuple[Any, ...]:
        robot, *others = self
        return _arrived, ((robot.file, robot.urdf, robot.snap), *others)


#: A worker reads a URDF once, and keeps what all logs of a robot ask for.
_known = lru_cache(maxsize=8)(_restore)


def _arrived(robot: tuple[str, str, bool], *others: Any) -> Job:
    return Job(_known(*robot), *others)


def work(job: Job) -> str:
    """What a group comes to, as JSON: its row, and what is known of its files."""
    return _sesc.fleet_work(*job)
