"""Examples in docstrings run: of everything public, and of its members."""

from __future__ import annotations

import doctest
import inspect
import json
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import sesc

from conftest import POLE

#: Exceptions say what they are of, and are made by the package alone.
WITHOUT = {name for name in sesc.__all__ if isinstance(getattr(sesc, name), type) and issubclass(getattr(sesc, name), Exception)}


def documented() -> Iterator[tuple[str, Any]]:
    """Everything public by its name: functions, classes and what classes have."""
    yield "sesc", sesc
    own_names = [(name, getattr(sesc, name)) for name in sorted(set(sesc.__all__) - WITHOUT)]
    own_names += [(f"fleet.{name}", getattr(sesc.fleet, name)) for name in sesc.fleet.__all__]
    for name, thing in own_names:
        if isinstance(thing, type) or inspect.isfunction(thing):
            yield name, thing
        if isinstance(thing, type):
            own = {key: value for base in reversed(thing.__mro__) if base.__module__.startswith("sesc") for key, value in vars(base).items()}
            fields = getattr(thing, "_fields", ())
            for key, value in sorted(own.items()):
                if not key.startswith("_") and key not in fields and getattr(value, "__doc__", None) is not None:
                    yield f"{name}.{key}", value


#: What the package calls itself, and fields that are said with their class.
QUIET = {"Model.bounds", "Model.inspection", "Model.model_file", "Model.next_steps", "Model.robot"}
THINGS = {name: thing for name, thing in documented() if name not in QUIET}


@pytest.fixture(scope="module")
def space(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Any]:
    """What examples speak of: a robot whose hip is 0.02 rad off, and what is made of its log."""
    k = np.arange(30)
    hip = 0.6 * np.sin(0.7 * k)
    x = 0.1 + np.sin(hip + 0.02) + 1e-4 * np.sin(7.1 * k)
    log = sesc.Log({"hip": hip, "cop_x": x, "cop_y": 1e-4 * np.sin(3.3 * k)}, support="foot")
    robot = sesc.Robot(POLE)
    folder = tmp_path_factory.mktemp("examples")
    return {
        "sesc": sesc,
        "np": np,
        "urdf": POLE,
        "robot": robot,
        "model": robot.on("foot"),
        "log": log,
        "fit": sesc.fit(robot, log, noise=1e-4),
        "found": sesc.diagnose(robot, log, noise=1e-4),
        "part": sesc.gather(robot, log),
        "plan": sesc.plan(robot, "foot", poses=5, cop_box=0.3, sigmas=0.0, candidates=50),
        "postures": sesc.Postures(robot.on("foot"), np.array([[0.0], [0.5]])),
        "folder": folder,
        "fleet": sesc.fleet.run(robot, days(robot, folder), information=True),
        "json": json,
    }


def days(robot: sesc.Robot, folder: Path) -> str:
    """Logs of six robots, each on one day, whose tops differ by hundredths of a millimetre."""
    (folder / "logs").mkdir()
    for k in range(6):
        own = sesc.Robot(POLE.replace("xyz='0 0 1'", f"xyz='{1e-5 * k:.5f} 0 1'")).on("foot")
        sesc.simulate(own, 30, noise=2e-4, seed=k + 1).save(folder / "logs" / f"r{k}_1.csv")
    return str(folder / "logs" / "*.csv")


@pytest.mark.parametrize("name", THINGS)
def test_examples_run(name: str, space: dict[str, Any]) -> None:
    text = inspect.getdoc(THINGS[name]) or ""
    test = doctest.DocTestParser().get_doctest(text, dict(space), name, None, 0)
    assert test.examples, f"{name} has no example"
    said: list[str] = []
    doctest.DocTestRunner().run(test, out=said.append)
    assert not said, "".join(said)


#: Functions and methods that look things up, and cannot fail.
CALM = {"Plan.columns", "Postures.columns", "effects", "fleet.Fleet.columns"}
CALM |= {name for name in THINGS if name.endswith(".to_dict") and name != "Log.to_dict"}


@pytest.mark.parametrize("name", THINGS)
def test_functions_say_what_they_raise(name: str) -> None:
    thing = THINGS[name]
    raises = re.search(r"^Raises:\n +\S+: ", inspect.getdoc(thing) or "", re.M)
    if callable(thing) and not isinstance(thing, type):
        assert bool(raises) != (name in CALM), f"{name} says nothing of errors, or is calm and does"


def test_members_are_among_them() -> None:
    for name in ("Fit.params", "Diagnosis.steps", "Plan.report", "Postures.save", "Model.c99", "Model.joints", "Robot.links", "fleet.run", "fleet.Fleet.report"):
        assert name in THINGS
    assert len(THINGS) > 100


def test_everything_public_says_what_it_is() -> None:
    for name in sesc.__all__:
        thing = getattr(sesc, name)
        if callable(thing):
            assert thing.__doc__, name
            for member, value in vars(thing).items() if isinstance(thing, type) else ():
                if not member.startswith("_") and (callable(value) or isinstance(value, property)):
                    assert value.__doc__, f"{name}.{member}"
