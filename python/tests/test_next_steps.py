"""Next steps are calls that run, and no text of the package names options of the command."""

from __future__ import annotations

import html
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import sesc

from conftest import POLE


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
    assert "all are named in JSON and on the page" in str(found) and "--" not in str(found)


def test_pages_name_calls(op2: sesc.Robot, tmp_path: Path) -> None:
    model = op2.on("r_sole")
    sesc.plan(op2, "r_sole", poses=5, candidates=100).report(tmp_path / "plan.html")
    log = sesc.simulate(model, 100, range=0.5, noise=3e-4, seed=4, hide={"joint_offset:r_knee": 0.026})
    sesc.diagnose(op2, log).report(tmp_path / "found.html")
    for name, call in (("plan", 'sesc.fit(robot, "LOG", support="r_sole")'), ("found", 'sesc.diagnose(robot, "LOG").save("model.toml")')):
        page = (tmp_path / f"{name}.html").read_text()
        assert f"<code>{html.escape(call)}</code>" in page and "<code>sesc " not in page


def test_calls_of_next_steps_run(op2: sesc.Robot, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    model = op2.on("r_sole")
    for name, hide in (("clean", {}), ("knee", {"joint_offset:r_knee": 0.05})):
        sesc.simulate(model, 60, range=0.5, noise=3e-4, seed=4, hide=hide).save(f"{name}.csv")
    fitted = sesc.fit(op2, "clean.csv")
    fitted.save("model.toml")
    results: list[tuple[str, Any]] = [
        ("clean.csv", model),
        ("clean.csv", fitted),
        ("knee.csv", sesc.fit(op2, "knee.csv", prior="tight")),
        ("clean.csv", sesc.diagnose(op2, "clean.csv")),
        ("knee.csv", sesc.diagnose(op2, "knee.csv")),
        ("clean.csv", sesc.verify(model, samples=20)),
        ("clean.csv", sesc.verify(op2.on("r_sole", model="model.toml"), samples=20)),
    ]
    ran = set()
    for log, result in results:
        for step in result.to_dict()["next_steps"]:
            if "command" in step:
                call = step["command"].replace('"LOG"', f'"{log}"').replace("LATER_LOG", "knee.csv")
                eval(call, {"sesc": sesc, "robot": op2})
                ran.add(step["what"])
    assert {"Choose postures to record", "Diagnose the log", "Write the functions as source code"} <= ran
    assert {"Keep the corrected model", "Look at the page of the diagnosis"} <= ran
    assert "Keep this log, and compare a later one with it" in ran
    assert (tmp_path / "src").is_dir() and (tmp_path / "report.html").exists()
