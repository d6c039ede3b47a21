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


def blocks(page: str) -> list[str]:
    found = re.findall(r"```python\n(.*?)```", (repository() / page).read_text(), flags=re.S)
    assert found
    return found


def test_the_block_runs(robots: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: Any) -> None:
    monkeypatch.chdir(tmp_path)
    shutil.copy(robots / "op2" / "op2.urdf", tmp_path / "op2.urdf")
    model = sesc.Robot("op2.urdf").on("r_sole")
    hide = {"joint_offset:r_knee": 0.026}
    sesc.simulate(model, 100, range=0.5, noise=5e-4, hide=hide).save("log.parquet")
    for name, seed in (("monday", 2), ("tuesday", 3)):
        log = sesc.simulate(model, 40, range=0.5, noise=5e-4, seed=seed, hide=hide)
        record(tmp_path / f"{name}.mcap", log, model)
    space: dict[str, Any] = {}
    for block in blocks("docs/python.md"):
        exec(compile(block, "docs/python.md", "exec"), space)
    assert np.shape(space["com"]) == (1000, 3) and len(space["poses"]) == 38
    assert (space["a"] | space["b"]).postures >= 80
    assert capsys.readouterr().err == ""
    for file in ("model.toml", "found.html", "op2_corrected.urdf", "fw/op2_r_sole.h", "src/op2_r_sole.rs"):
        assert (tmp_path / file).stat().st_size > 100, file


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
