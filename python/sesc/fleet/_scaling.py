"""What a fleet costs on this machine, by the number of its logs and of processes: a table in Markdown."""

from __future__ import annotations

import shutil
import time
from collections.abc import Sequence
from pathlib import Path

from ._trials import SETTLED, driven, make

__all__ = ["scaling"]

#: Processes that share the work.
PROCESSES = (1, 2)
HEAD = """| logs | processes | s of processors | s on the clock | driver, MB | worker, MB | again: s of processors | s on the clock | logs read |
|---|---|---|---|---|---|---|---|---|"""


def scaling(folder: Path, counts: Sequence[int], fleet: tuple[int, int], only: str) -> bool:
    """Run the first logs of a fleet, so many at a time, by one process and by two, and again from
    the store. Prints a line for each; gives whether every second run read no log and all runs of
    the same logs gave the same bytes.

    Args:
        folder: where logs, store and table go; logs that are there are taken.
        counts: how many logs.
        fleet: postures of a log, and logs of a robot.
        only: what is made of each log: ``"parameters"``, or ``""`` for diagnoses too.
    """
    # Paths of a list are relative to the list.
    folder = folder.resolve()
    logs, store = folder / "logs", folder / "store"
    if not logs.exists():
        make(logs, max(counts), *fleet)
        time.sleep(SETTLED)
    names = sorted(str(path) for path in logs.glob("robot=*/day=*/*.parquet"))
    print(HEAD)
    holds = []
    for count in counts:
        some = folder / f"{count}.list"
        some.write_text("\n".join(names[:count]))
        tables = set()
        for processes in PROCESSES:
            shutil.rmtree(store, ignore_errors=True)
            options = ("executor", only, str(processes))
            first, second = (driven(str(some), store, folder / "fleet.parquet", options) for _ in range(2))
            tables |= {first["sha256"], second["sha256"]}
            read = (first["logs_read"], second["logs_read"])
            holds.append(read == (count, 0) and first["groups"] == second["from_store"] == count)
            print(
                f"| {count} | {processes} | {first['cpu_seconds']:.1f} | {first['seconds']:.1f} "
                f"| {first['memory_mb']:.0f} | {first['worker_mb']:.0f} "
                f"| {second['cpu_seconds']:.1f} | {second['seconds']:.1f} | {second['logs_read']} |",
                flush=True,
            )
        holds.append(len(tables) == 1)
    return all(holds)
