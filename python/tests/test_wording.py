"""Who calls functions is told of functions: no text of the package names options of the command."""

from __future__ import annotations

import html
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import sesc
from sesc._wording import in_python

from conftest import POLE


@pytest.mark.parametrize(
    ("command", "call"),
    [
        ("sesc diagnose URDF --data LOG", 'sesc.diagnose(robot, "LOG")'),
        ("sesc fit URDF --support foot --data 'a b.csv'", 'sesc.fit(robot, "a b.csv", support="foot")'),
        ("sesc diagnose URDF --data LOG --prior PRIOR.toml", 'sesc.diagnose(robot, "LOG", prior="PRIOR.toml")'),
        ("sesc diagnose URDF --data LOG --out model.toml", 'sesc.diagnose(robot, "LOG").save("model.toml")'),
        ("sesc plan URDF --support foot --poses 40 --out p.csv", 'sesc.plan(robot, support="foot", poses=40).save("p.csv")'),
        ("sesc generate URDF --support foot --lang c --out src", 'robot.on("foot").c99("src")'),
        (
            "sesc generate URDF --support foot --model 'b c.toml' --lang c --out src",
            'robot.on("foot", model="b c.toml").c99("src")',
        ),
        (
            "sesc verify URDF --support foot --model model.toml --no-snap",
            'sesc.verify(sesc.Robot("URDF", snap=False).on("foot", model="model.toml"))',
        ),
        (
            "sesc compare LOG LATER_LOG --urdf URDF",
            'sesc.compare(sesc.diagnose(robot, "LOG"), sesc.diagnose(robot, "LATER_LOG"))',
        ),
        ("sesc diagnose URDF --data LOG --next n.csv", 'sesc.diagnose(robot, "LOG").next_postures().save("n.csv")'),
    ],
)
def test_command_lines_are_calls(command: str, call: str) -> None:
    assert in_python(f"next  Do it.\n      {command}\nend") == f"next  Do it.\n      {call}\nend"
    assert in_python("so sesc fit is") == "so sesc fit is"


def log(offset: float = 0.0, noise: float = 1e-4, jump: float = 0.0) -> sesc.Log:
    k = np.arange(60)
    hip = 0.6 * np.sin(0.7 * k)
    x = 0.1 + np.sin(hip + offset) + noise * np.sin(7.1 * k) + jump * (k % 3 == 0)
    return sesc.Log({"hip": hip, "cop_x": x, "cop_y": noise * np.sin(3.3 * k)}, support="foot")


@pytest.mark.parametrize("log", [log(), log(offset=0.02), log(jump=0.03), log(offset=0.02, noise=0.0)])
@pytest.mark.parametrize("options", [{}, {"prior": "cad"}, {"prior": "free"}])
def test_texts_of_results_name_no_options(log: sesc.Log, options: dict[str, Any]) -> None:
    robot = sesc.Robot(POLE)
    fit = sesc.fit(robot, log, robust="huber", **options)
    found = sesc.diagnose(robot, log, **options)
    said = [str(fit), str(found), found.sentence, *fit.warnings, *fit.notes, *fit.unobservable, *found.warnings]
    said += [step.sentence for step in found.steps] + [finding.sentence for finding in found.health]
    for text in said:
        assert not re.search(r"(^|[\s`(])--[a-z]|\bsesc (fit|diagnose|plan) [A-Z]", text), text


def test_what_is_left_out_of_a_text_is_found_in_python(op2: sesc.Robot) -> None:
    found = sesc.fit(op2, sesc.simulate(op2.on("r_sole"), 100, noise=1e-4))
    assert "all named by `.to_dict()`, `.report(…)`" in str(found) and "--" not in str(found)


def test_pages_name_calls(op2: sesc.Robot, tmp_path: Path) -> None:
    model = op2.on("r_sole")
    sesc.plan(op2, "r_sole", poses=5, candidates=100).report(tmp_path / "plan.html")
    log = sesc.simulate(model, 100, range=0.5, noise=3e-4, seed=4, hide={"joint_offset:r_knee": 0.026})
    sesc.diagnose(op2, log).report(tmp_path / "found.html")
    for name, call in (("plan", 'sesc.fit(robot, "LOG", support="r_sole")'), ("found", 'sesc.diagnose(robot, "LOG").save("model.toml")')):
        page = (tmp_path / f"{name}.html").read_text()
        assert f"<code>{html.escape(call)}</code>" in page and "<code>sesc " not in page
