"""The unit of work: the logs of one robot and day to one row. No engine, no state."""

from __future__ import annotations

from typing import NamedTuple

from .. import _sesc
from .._robot import Robot

__all__ = ["Job", "work"]


class Job(NamedTuple):
    """What one call works on; it is pickled to wherever it runs.

    Attributes:
        robot: the robot, unless the group has a URDF of its own.
        options: how the group is looked at, as JSON.
        group: robot, day and paths, as JSON. The paths have to be readable where it runs.
        store: the folder of rows, or None.
    """

    robot: Robot
    options: str
    group: str
    store: str | None = None


def work(job: Job) -> str:
    """What a group comes to, as JSON: its row, and what is known of its files."""
    return _sesc.fleet_work(job.robot, job.options, job.group, job.store)
