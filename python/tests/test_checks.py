"""Comparisons, verifications and the list of effects: those of the command line."""

from __future__ import annotations

import html
import json
from pathlib import Path
from typing import Any

import pytest

import sesc

from conftest import without_commands, worded

SMALL = ("two_link/two_link.urdf", "foot")


@pytest.fixture(scope="module")
def robot(robots: Path) -> sesc.Robot:
    return sesc.Robot(robots / SMALL[0])


def fitted(robot: sesc.Robot, seed: int, **hide: float) -> sesc.Fit:
    log = sesc.simulate(robot.on(SMALL[1]), 80, noise=2e-4, seed=seed, hide=hide)
    return sesc.fit(robot, log, prior="free")


def without_command(page: str) -> str:
    """A page without the lines that say how it was made."""
    return "\n".join(line for line in page.splitlines() if "sesc compare" not in line and "sesc.compare" not in line)


def test_effects_are_those_of_the_command(command_json: Any) -> None:
    found = sesc.effects()
    want = command_json("effects")["effects"]
    assert [effect.to_dict() for effect in found.values()] == want
    assert list(found) == [effect["name"] for effect in want]
    assert found["joint_offset"].parameters == {"offset_rad": "rad", "offset_m": "m"}
    assert "<table>" in found["payload"]._repr_html_()


def test_a_comparison_is_that_of_the_command(robot: sesc.Robot, command: Any, command_json: Any, tmp_path: Path) -> None:
    before, after = fitted(robot, 1), fitted(robot, 2)
    before.save(tmp_path / "a.toml")
    after.save(tmp_path / "b.toml")
    found = sesc.compare(tmp_path / "a.toml", tmp_path / "b.toml")
    want = command_json("compare", tmp_path / "a.toml", tmp_path / "b.toml")
    assert json.dumps(worded(found.to_dict())) == json.dumps(worded(want))
    text = command("compare", tmp_path / "a.toml", tmp_path / "b.toml")
    assert "\nnext" in text and without_commands(str(found)) == without_commands(text)
    # Objects have what their files have, under the names of the arguments.
    objects = sesc.compare(before, after.model).to_dict()
    assert worded(objects) == {**worded(want), "next_steps": worded(objects)["next_steps"]}
    assert objects["next_steps"][0]["what"] == "Go on with before.model"
    found.report(tmp_path / "ours.html")
    command("compare", tmp_path / "a.toml", tmp_path / "b.toml", "--report", tmp_path / "theirs.html")
    ours, theirs = (without_command((tmp_path / name).read_text()) for name in ("ours.html", "theirs.html"))
    assert found.sentence and "<h2>What to do next</h2>" in ours and ours == theirs
    drawn = sesc.compare(before, after)._repr_html_()
    assert drawn.startswith("<iframe") and drawn.count("svg") > found._repr_html_().count("svg")


def test_a_robot_that_changed_is_told_from_chance(robot: sesc.Robot) -> None:
    heavier = {f"payload:{robot.links[-1]}": (0.2, 0.05, 0.0, 0.1)}
    log = sesc.simulate(robot.on(SMALL[1]), 80, noise=2e-4, seed=3, hide=heavier)
    changed = sesc.compare(fitted(robot, 1), sesc.fit(robot, log, prior="free"))
    same = sesc.compare(fitted(robot, 1), fitted(robot, 2))
    assert changed.changed and not same.changed
    call = 'robot.on("foot", model=after.model).c99("src")'
    assert changed.to_dict()["next_steps"][-1]["command"] == call and f"      {call}\n" in str(changed)
    assert f"<code>{html.escape(call)}</code>" in changed._state["page"]
    assert changed.chance is not None and changed.chance < 1e-3 < (same.chance or 0.0)
    with pytest.raises(sesc.ModelFileError, match="`after` has CAD's parameters"):
        sesc.compare(fitted(robot, 1), robot.on(SMALL[1]))
    with pytest.raises(FileNotFoundError):
        sesc.compare("none.toml", "none.toml")


def test_a_verification_is_that_of_the_command(robot: sesc.Robot, robots: Path, command_json: Any) -> None:
    found = sesc.verify(robot.on(SMALL[1]), samples=500, seed=3)
    words = ["--support", SMALL[1], "--samples", 500, "--seed", 3]
    want = command_json("verify", robots / SMALL[0], *words)
    assert json.dumps(worded(found.to_dict())) == json.dumps(worded(want))
    step = found.to_dict()["next_steps"][0]
    assert step["command"] == 'robot.on("foot").c99("src")' and "in C and in Rust" in step["why"]
    assert "<code>robot.on(&quot;foot&quot;).c99(&quot;src&quot;)</code>" in found._repr_html_()
    assert found and found.passed and found.samples >= 500
    assert set(found.units) == set(found.bound) == set(found.worst_error)
    assert all(error <= found.bound[name] for name, error in found.worst_error.items())
    with pytest.raises(ValueError, match="`samples` 0: give a whole number, 1 or more"):
        sesc.verify(robot.on(SMALL[1]), samples=0)
