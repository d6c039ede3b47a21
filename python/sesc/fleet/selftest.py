"""``python -m sesc.fleet.selftest --logs 10000 --postures 2000``: a fleet, tried on this machine.

Virtual logs are made, a driver of its own process fits the parameters of each, and runs them again:
the second run has to read no log and to give the same bytes. ``--only all`` diagnoses each log too,
which takes some twenty times as long and tries nothing else of a fleet. ``--kill driver`` or
``--kill worker`` kills one of them by its process id when a third of the rows is made; the driver is
then started again and has to make no row anew. ``--table 10,100,1000,10000`` runs so many logs by one
process and by two, and prints what that takes as a table. Exit code 0 where all that holds; seconds
and memory are printed.
"""

from __future__ import annotations

import argparse
import sys
import time
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from ._scaling import scaling
from ._trials import ENGINES, SETTLED, driven, make, rows_in

__all__ = ["main"]


def main(words: list[str] | None = None) -> int:
    """Run the fleet; gives the exit code."""
    parser = argparse.ArgumentParser(prog="python -m sesc.fleet.selftest", description=__doc__.split("\n")[0])
    parser.add_argument("--logs", type=int, default=60, help="how many logs")
    parser.add_argument("--days", type=int, default=10, help="logs of each robot")
    parser.add_argument("--postures", type=int, default=60, help="postures of each log")
    parser.add_argument("--engine", choices=ENGINES, default="threads")
    parser.add_argument("--workers", type=int, default=2, help="workers of the engine")
    parser.add_argument("--kill", choices=("driver", "worker"), default="")
    parser.add_argument(
        "--only", choices=("parameters", "all"), default="parameters", help="all: diagnose each log, too"
    )
    parser.add_argument("--folder", type=Path, help="where logs, store and table go; a new folder unless given")
    parser.add_argument(
        "--table", type=_counts, help="numbers of logs, such as 10,100,1000: print what each takes"
    )
    given = parser.parse_args(words)
    if given.folder is not None:
        given.folder.mkdir(parents=True, exist_ok=True)
        return _tried(given, given.folder)
    with TemporaryDirectory() as folder:
        return _tried(given, Path(folder))


def _counts(text: str) -> list[int]:
    """Numbers of logs of ``--table``: positive and separated by commas."""
    counts = text.split(",")
    if not all(count.isdecimal() and int(count) > 0 for count in counts):
        raise argparse.ArgumentTypeError(f"{text!r} is no list of positive numbers, such as 10,100,1000")
    return [int(count) for count in counts]


def _tried(given: Any, folder: Path) -> int:
    only = "" if given.only == "all" else given.only
    if given.table:
        return _said(scaling(folder, given.table, (given.postures, given.days), only))
    logs, store = folder / "logs", folder / "store"
    if not logs.exists():
        start = time.perf_counter()
        make(logs, given.logs, given.postures, given.days)
        print(f"{given.logs} logs of {given.postures} postures made in {time.perf_counter() - start:.0f} s")
        time.sleep(SETTLED)
    pattern = str(logs / "robot=*/day=*/*.parquet")
    options = (given.engine, only, str(given.workers))

    def run(name: str, into: Path | None, kill: str = "") -> dict[str, Any]:
        found = driven(pattern, into, folder / f"{name}.parquet", options, kill, given.logs // 3)
        if "seconds" not in found:
            print(f"{name}: driver {found['killed']} killed, {rows_in(store)} rows in the store", flush=True)
            return found
        print(
            f"{name}: {found['seconds']:.1f} s, {found['cpu_seconds']:.1f} s of processors, "
            f"driver {found['memory_mb']:.0f} MB, {found['logs_read']} logs read, "
            f"{found['from_store']} of {found['groups']} rows from the store, {found['sha256']}",
            flush=True,
        )
        if found["killed"]:
            print(f"  worker {found['killed']} killed when {found['rows_when_killed']} rows were made", flush=True)
        return found

    holds = []
    if given.kill:
        calm = run("calm", None)
        killed = run("killed", store, given.kill)
        made = rows_in(store)
        holds.append(killed.get("killed") is not None)
        if given.kill == "driver":
            again = run("again", store)
            holds.append(0 < made < given.logs and again["from_store"] == made)
            holds.append(again["sha256"] == calm["sha256"])
        else:
            holds.append(killed["sha256"] == calm["sha256"] and killed["rows_when_killed"] < given.logs)
    else:
        first = run("first", store)
        second = run("second", store)
        holds.append(second["logs_read"] == 0 and second["from_store"] == given.logs)
        holds.append(second["sha256"] == first["sha256"])
    return _said(all(holds))


def _said(holds: bool) -> int:
    print("ok" if holds else "FAILED")
    return 0 if holds else 1


if __name__ == "__main__":
    sys.exit(main())
