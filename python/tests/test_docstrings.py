"""Examples in docstrings run."""

from __future__ import annotations

import doctest
from typing import Any

import numpy as np
import pytest

import sesc

from conftest import POLE

THINGS = [sesc, sesc.Robot, sesc.Robot.on, sesc.Log, sesc.Part, sesc.fit, sesc.gather, sesc.diagnose, sesc.plan]
THINGS += [sesc.simulate, sesc.predict]
THINGS += [getattr(sesc.Model, n) for n in ("com", "com_jacobian", "gravity_moments", "cop", "cop_rows", "com_rows", "zmp", "reordered")]


@pytest.mark.parametrize("thing", THINGS, ids=lambda thing: getattr(thing, "__name__", "sesc"))
def test_examples_run(thing: Any) -> None:
    k = np.arange(30)
    hip = 0.6 * np.sin(0.7 * k)
    x = 0.1 + np.sin(hip + 0.02) + 1e-4 * np.sin(7.1 * k)
    log = sesc.Log({"hip": hip, "cop_x": x, "cop_y": 1e-4 * np.sin(3.3 * k)}, support="foot")
    robot = sesc.Robot(POLE)
    space = {"sesc": sesc, "urdf": POLE, "robot": robot, "model": robot.on("foot"), "log": log}
    text = thing.__doc__ or ""
    test = doctest.DocTestParser().get_doctest(text, space, "example", None, 0)
    assert test.examples
    said: list[str] = []
    doctest.DocTestRunner().run(test, out=said.append)
    assert not said, "".join(said)


def test_everything_public_says_what_it_is() -> None:
    for name in sesc.__all__:
        thing = getattr(sesc, name)
        if callable(thing):
            assert thing.__doc__, name
            for member, value in vars(thing).items() if isinstance(thing, type) else ():
                if not member.startswith("_") and callable(value):
                    assert value.__doc__, f"{name}.{member}"
