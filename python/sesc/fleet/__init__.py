"""A fleet: one row for each robot and day, from many logs, on one machine or on an engine.

    files ─▶ groups (robot, day) ─▶ unit.analyse, one call a group ─▶ rows ─▶ table

The unit is a pure function of the logs' contents: its row depends on no path, no time and no
order of arrival. A store keeps rows under the hash of what they were made of, so that a second
run reads nothing that was read, and a task that runs twice writes the same bytes.
"""

from ._manifest import Item, manifest
from ._run import Fleet, run
from ._unit import COLUMNS, Job, analyse

__all__ = ["COLUMNS", "Fleet", "Item", "Job", "analyse", "manifest", "run"]
