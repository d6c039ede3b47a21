"""A fleet: one row for each robot and day, from many logs, on one machine or on an engine.

    logs ─▶ groups (robot, day) ─▶ work, one call a group ─▶ gathered ─▶ table, summary, page

:func:`work` is a pure function of a URDF, options and what the logs of a group hold: its row
depends on no path, no time and no order of arrival. A store keeps rows under the hash of what
they were made of, so that a task that runs twice writes the same bytes. What is said across
robots is a pure function of the rows. Both are the library's own, as ``sesc fleet`` has them.
"""

from ._run import COLUMNS, Fleet, run
from ._unit import Job, work

__all__ = ["COLUMNS", "Fleet", "Job", "run", "work"]
