"""What all tests share. They run on the installed package; only data comes from the repository."""

from __future__ import annotations

import json
import re
import os
import subprocess
import sys
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from contextlib import contextmanager
from importlib import import_module
from multiprocessing import get_context
from pathlib import Path
from typing import Any

import pytest

import sesc

#: A mass of 2 kg, 1 m above an ankle that is 0.1 m in front of the sole's origin.
POLE = """<robot name='pole'><link name='foot'/><link name='top'><inertial><origin xyz='0 0 1'/>
<mass value='2'/></inertial></link><joint name='hip' type='revolute'><parent link='foot'/>
<child link='top'/><origin xyz='0.1 0 0'/><axis xyz='0 1 0'/>
<limit lower='-1' upper='1' effort='1' velocity='1'/></joint></robot>"""


def repository() -> Path:
    """The repository, named by ``SESC_REPOSITORY`` where the tests stand apart from it."""
    named = os.environ.get("SESC_REPOSITORY")
    return Path(named) if named else Path(__file__).resolve().parents[2]


@pytest.fixture(scope="session")
def robots() -> Path:
    return repository() / "robots"


@pytest.fixture(scope="session")
def op2(robots: Path) -> sesc.Robot:
    return sesc.Robot(robots / "op2" / "op2.urdf")


@pytest.fixture(scope="session")
def model(op2: sesc.Robot) -> sesc.Model:
    return op2.on("r_sole")


@pytest.fixture
def pole() -> sesc.Robot:
    return sesc.Robot(POLE)


@pytest.fixture(scope="session")
def command() -> Any:
    """Runs the command line that the repository built, named by ``SESC_COMMAND``."""
    program = os.environ.get("SESC_COMMAND")
    if not program:
        pytest.skip("SESC_COMMAND names no command line")

    def run(*words: object, expect: int | tuple[int, ...] = 0) -> str:
        done = subprocess.run([program, *map(str, words)], capture_output=True, text=True, check=False)
        assert done.returncode in (expect if isinstance(expect, tuple) else (expect,)), done.stderr
        return done.stdout

    return run


@pytest.fixture(scope="session")
def command_json(command: Any) -> Any:
    return lambda *words, expect=0: json.loads(command(*words, "--json", expect=expect))


def worded(found: dict[str, Any]) -> dict[str, Any]:
    """Without what does next steps: a command here, a call there."""
    steps = [{**step, "command": step.get("command") is not None} for step in found.get("next_steps", [])]
    return {**found, "next_steps": steps}


@contextmanager
def running(engine: str) -> Iterator[Any]:
    """An engine with two workers on this machine, as ``sesc.fleet.run`` takes it."""
    if engine == "executor":
        with ProcessPoolExecutor(2, mp_context=get_context("spawn")) as pool:
            yield pool
    elif engine == "dask":
        distributed: Any = import_module("distributed")
        with distributed.Client(n_workers=2, threads_per_worker=1, dashboard_address=None) as client:
            yield client.get_executor()
    elif engine == "ray":
        ray: Any = import_module("ray")
        ray.init(num_cpus=2, include_dashboard=False, log_to_driver=False)
        try:
            yield "ray"
        finally:
            ray.shutdown()
    else:
        # Workers have to find this package. Four tries a task; local[2] alone has one.
        os.environ.setdefault("PYSPARK_PYTHON", sys.executable)
        sql: Any = import_module("pyspark.sql")
        session = sql.SparkSession.builder.master("local[2,4]").getOrCreate()
        try:
            yield session
        finally:
            session.stop()


def without_commands(text: str) -> str:
    """A text without the lines of commands and calls below its next steps."""
    return re.sub(r"(?m)^ +(sesc |sesc\.|robot\.).*\n?", "", text).rstrip()
