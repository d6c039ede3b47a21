"""Engines that run the groups of a fleet: each maps one function over them.

An engine may run a group more than once and in any place: the result is the same bytes.
"""

from __future__ import annotations

import pickle
import warnings
from collections.abc import Iterable, Iterator, Sequence
from concurrent.futures import BrokenExecutor
from importlib import import_module
from typing import Any

from .._errors import ArgumentTypeError
from ._unit import Job, work

__all__ = ["worked"]

#: Spark tasks, at most: each costs Spark 40 ms.
TASKS = 256


def worked(engine: Any, jobs: Sequence[Job]) -> Iterable[str]:
    """What jobs come to on an engine: an executor, ``"ray"`` or a SparkSession."""
    if hasattr(engine, "submit"):
        return _executor(engine, jobs)
    if engine == "ray":
        ray: Any = import_module("ray")
        task = ray.remote(max_retries=3)(work)
        return map(ray.get, [task.remote(job) for job in jobs])
    if hasattr(engine, "createDataFrame"):
        return _spark(engine, jobs)
    raise ArgumentTypeError(
        f"an engine is None, a concurrent.futures.Executor, 'ray' or a SparkSession, not {type(engine).__name__}"
    )


def _executor(engine: Any, jobs: Sequence[Job]) -> Iterator[str]:
    """Processes, threads, Dask. Groups that a broken executor leaves are done here."""
    futures: list[Any] = []
    done = 0
    try:
        for job in jobs:
            futures.append(engine.submit(work, job))
        for future in futures:
            yield future.result()
            done += 1
    except BrokenExecutor as error:
        text = f"the executor lost a worker ({error}); {len(jobs) - done} groups are done by this process"
        warnings.warn(text, RuntimeWarning, stacklevel=2)
        yield from map(work, jobs[done:])
    finally:
        # What has not begun need not begin.
        for future in futures:
            future.cancel()


def _spark(session: Any, jobs: Sequence[Job]) -> Iterator[str]:
    """Spark tasks through ``mapInArrow``; what they come to is collected."""
    if not jobs:
        return
    # The robot travels once with the function, groups as rows.
    packed = pickle.dumps(jobs[0]._replace(group=""))

    def mapped(batches: Any) -> Any:
        pyarrow: Any = import_module("pyarrow")
        job = pickle.loads(packed)
        for batch in batches:
            found = [work(job._replace(group=group)) for group in batch.column(0).to_pylist()]
            yield pyarrow.RecordBatch.from_arrays([pyarrow.array(found, pyarrow.string())], names=["done"])

    rows = session.createDataFrame([(job.group,) for job in jobs], "group string")
    rows = rows.repartition(min(len(jobs), TASKS)).mapInArrow(mapped, "done string")
    yield from (row["done"] for row in rows.collect())
