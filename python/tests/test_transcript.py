"""The blocks that a roboticist types, as the documentation and the package's page have them."""

from __future__ import annotations

import re
import shutil
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import sesc

from conftest import repository
from recording import record


#: What was asked for, word for word; what its comments name is looked at below.
ASKED = """
import sesc
robot = sesc.Robot("op2.urdf"); model = robot.on("r_sole")      # model.joints, .params, .param_names, .total_mass, .limits, .unobservable
model.com(q)                    # (20,) -> (3,); (n, 20) -> (n, 3); out=, threads=
model.com_jacobian(q), model.gravity_moments(q), model.cop(q), model.cop_rows(q), model.com_rows(q), model.zmp(q, qd, qdd)
log = sesc.Log("log.parquet")   # CSV, gzip, Parquet, MCAP, file object, DataFrame, dict of arrays; support=, angles="deg", columns={…}
log.health
fit = sesc.fit(robot, log, prior="cad", progress=True)          # .parameters["r_knee_link.z"].std, .params, .covariance, .noise_floor, .held_out_rmse, .unobservable, .warnings
found = sesc.diagnose(robot, log, prior="tight")                # .verdict, .steps, .explanations, .sentence, .health, .next_postures(30)
better = found.model                                            # a model with the effects in it: better.com(q)
fit.save("model.toml"); found.report("found.html"); found.correct_urdf(total_mass=2.93).save("op2.urdf")
sesc.plan(robot, "r_sole", poses=38), sesc.simulate(model, poses, noise=5e-4, hide={"joint_offset:r_knee": 0.026})
model.c99("fw/", scalar="fixed32"); model.rust("src/")
a, b = sesc.gather(robot, "monday.mcap"), sesc.gather(robot, "tuesday.mcap"); sesc.fit(a | b); bytes(a); sesc.Part.from_bytes(data)
"""


def blocks(page: str) -> list[str]:
    found = re.findall(r"```python\n(.*?)```", (repository() / page).read_text(), flags=re.S)
    assert found
    return found


@pytest.fixture(scope="module")
def files(robots: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """What the blocks speak of: a robot, a log, and the recordings of two days."""
    folder = tmp_path_factory.mktemp("files")
    shutil.copy(robots / "op2" / "op2.urdf", folder / "op2.urdf")
    model = sesc.Robot(folder / "op2.urdf").on("r_sole")
    hide = {"joint_offset:r_knee": 0.026}
    sesc.simulate(model, 100, range=0.5, noise=5e-4, hide=hide).save(folder / "log.parquet")
    for name, seed in (("monday", 2), ("tuesday", 3)):
        log = sesc.simulate(model, 40, range=0.5, noise=5e-4, seed=seed, hide=hide)
        record(folder / f"{name}.mcap", log, model)
    return folder


@pytest.fixture
def here(files: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A copy of the files, which a test works in."""
    shutil.copytree(files, tmp_path, dirs_exist_ok=True)
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_what_was_asked_for_runs_word_for_word(here: Path, capsys: Any) -> None:
    rng = np.random.default_rng(1)
    model = sesc.Robot("op2.urdf").on("r_sole")
    q, qd, qdd = rng.uniform(-0.3, 0.3, (3, 50, 20))
    data = bytes(sesc.gather(model.robot, "monday.mcap"))
    space: dict[str, Any] = {"q": q, "qd": qd, "qdd": qdd, "poses": q, "data": data}
    exec(compile(ASKED, "asked", "exec"), space)
    model, log, fit, found = (space[name] for name in ("model", "log", "fit", "found"))
    assert len(model.joints) == 20 and len(model.param_names) == model.params.size == 43
    assert model.total_mass > 2 and model.limits.shape == (20, 2) and len(model.unobservable) == 21
    assert model.com(q[0]).shape == (3,) and model.com(q).shape == (50, 3)
    out = np.zeros((50, 3))
    assert model.com(q, out=out, threads=2) is out and (out == model.com(q)).all()
    assert log.health == [] and fit.parameters["r_knee_link.z"].std > 0
    assert fit.params.shape == (43,) and fit.covariance.shape == (43, 43)
    assert 0 < fit.noise_floor < fit.held_out_rmse < 1e-3 and len(fit.unobservable) == 21
    # A fit has no word for the encoder that is off.
    missing, shifted = fit.warnings
    assert "something is missing" in missing and "readings are shifted" in shifted
    assert found.verdict == "named" and found.steps and found.explanations == [["joint_offset:r_knee"]]
    assert "r_knee" in found.sentence and found.health == [] and len(found.next_postures(30)) <= 30
    assert not (space["better"].com(q) == model.com(q)).all()
    assert bytes(space["a"]) == data and sesc.Part.from_bytes(data) == space["a"]
    for file in ("model.toml", "found.html", "fw/op2_r_sole.h", "src/op2_r_sole.rs"):
        assert (here / file).stat().st_size > 100, file
    # The corrected URDF, whose total mass was given.
    assert sesc.Robot("op2.urdf").on("r_sole").total_mass == pytest.approx(2.93, abs=1e-9)
    assert capsys.readouterr().err == ""


def test_the_block_runs(here: Path, capsys: Any) -> None:
    space: dict[str, Any] = {}
    for block in blocks("docs/python.md"):
        exec(compile(block, "docs/python.md", "exec"), space)
    assert np.shape(space["com"]) == (1000, 3) and len(space["poses"]) == 38
    assert (space["a"] | space["b"]).postures >= 80
    assert capsys.readouterr().err == ""
    for file in ("model.toml", "found.html", "op2_corrected.urdf", "fw/op2_r_sole.h", "src/op2_r_sole.rs"):
        assert (here / file).stat().st_size > 100, file


def test_the_block_of_the_package_s_page_runs(robots: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: Any) -> None:
    monkeypatch.chdir(tmp_path)
    shutil.copy(robots / "op2" / "op2.urdf", tmp_path / "op2.urdf")
    model = sesc.Robot("op2.urdf").on("r_sole")
    simulated = sesc.simulate(model, 100, range=0.5, noise=5e-4, hide={"joint_offset:r_knee": 0.026})
    frame = simulated.columns()
    space: dict[str, Any] = {"q": np.zeros((5, 20)), "frame": frame}
    for block in blocks("python/README.md"):
        exec(compile(block, "python/README.md", "exec"), space)
    assert np.shape(space["com"]) == (5, 3) and space["found"].verdict != "none"
    assert "joint_offset" in capsys.readouterr().out
