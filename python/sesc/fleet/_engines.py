"""Engines that run the groups of a fleet: each gives what they come to, in any order.

An engine may run a group more than once and in any place: the result is the same bytes.
"""

from __future__ import annotations

import os
import pickle
import warnings
from collections.abc import Iterable, Iterator, Sequence
from concurrent.futures import BrokenExecutor, Executor, Future, ThreadPoolExecutor, as_completed
from importlib import import_module
from typing import Any

from .._errors import ArgumentTypeError
from ._unit import Job, work

__all__ = ["worked"]

#: Spark tasks for each processor.
TASKS = 8


def worked(engine: Any, jobs: Sequence[Job]) -> Iterator[str]:
    """What jobs come to on an engine: an executor, ``"ray"`` or a SparkSession."""
    if isinstance(engine, Executor) or hasattr(engine, "submit"):
        return _executor(engine, jobs)
    if engine == "ray":
        return _ray(jobs)
    if hasattr(engine, "createDataFrame"):
        return _spark(engine, jobs)
    raise ArgumentTypeError(
        f"an engine is None, a concurrent.futures.Executor, 'ray' or a SparkSession, not {type(engine).__name__}"
    )


def _executor(engine: Executor, jobs: Sequence[Job]) -> Iterator[str]:
    """Processes, threads, Dask. Groups that a broken executor leaves are done by threads here."""
    open_jobs: dict[int, Job] = dict(enumerate(jobs))
    pending: dict[Future[str], int] = {}
    broken = None
    try:
        try:
            for k, job in open_jobs.items():
                pending[engine.submit(work, job)] = k
        except BrokenExecutor as error:
            broken = error
        for future in _completed(pending):
            try:
                found = future.result()
            except BrokenExecutor as error:
                broken = error
                continue
            del open_jobs[pending[future]]
            yield found
    finally:
        # Nobody waits any more for what has not begun.
        for future in pending:
            future.cancel()
    if open_jobs:
        text = f"the executor lost a worker ({broken}); {len(open_jobs)} groups are done by threads of this process"
        warnings.warn(text, RuntimeWarning, stacklevel=2)
        with ThreadPoolExecutor(os.cpu_count() or 1) as own:
            yield from own.map(work, open_jobs.values())


def _completed(pending: dict[Future[str], int]) -> Iterable[Future[str]]:
    """Futures as they complete; those of other libraries in the order of their groups."""
    if all(isinstance(future, Future) and hasattr(future, "_condition") for future in pending):
        return as_completed(pending)
    return list(pending)


def _ray(jobs: Sequence[Job]) -> Iterator[str]:
    """Ray tasks, each tried again three times; the caller has called ``ray.init()``, or Ray does."""
    ray: Any = import_module("ray")
    task = ray.remote(max_retries=3)(work)
    pending = [task.remote(job) for job in jobs]
    while pending:
        ready, pending = ray.wait(pending)
        yield from ray.get(ready)


def _spark(session: Any, jobs: Sequence[Job]) -> Iterator[str]:
    """Spark tasks through ``mapInArrow``, several for each processor; what they come to is collected."""
    if not jobs:
        return iter(())
    # The robot travels once with the function, groups as rows.
    packed = pickle.dumps(jobs[0]._replace(group=""))

    def mapped(batches: Any) -> Any:
        pyarrow: Any = import_module("pyarrow")
        job = pickle.loads(packed)
        for batch in batches:
            found = [work(job._replace(group=group)) for group in batch.column(0).to_pylist()]
            yield pyarrow.RecordBatch.from_arrays([pyarrow.array(found, pyarrow.string())], names=["done"])

    rows = session.createDataFrame([(job.group,) for job in jobs], "group string")
    # A task costs Spark 40 ms; one that is lost takes the rows that it made from the store.
    tasks = min(len(jobs), TASKS * _processors(session))
    rows = rows.repartition(tasks).mapInArrow(mapped, "done string")
    return (row["done"] for row in rows.collect())


def _processors(session: Any) -> int:
    """What a Spark cluster runs at once; Spark Connect does not say."""
    try:
        return max(1, int(session.sparkContext.defaultParallelism))
    except Exception:
        return 64
