"""Robots, models, their faults, and their life between processes."""

from __future__ import annotations

import copy
import io
import multiprocessing
import os
import pickle
import re
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import sesc

from conftest import POLE


def com_of(model: sesc.Model) -> Any:
    return model.com(np.zeros((3, model.dof)))


def test_a_urdf_is_given_in_any_form(robots: Path, tmp_path: Path) -> None:
    (tmp_path / "pole.urdf").write_text(POLE)
    forms: list[Any] = [POLE, POLE.encode(), io.StringIO(POLE), io.BytesIO(POLE.encode())]
    forms += [tmp_path / "pole.urdf", str(tmp_path / "pole.urdf"), open(tmp_path / "pole.urdf")]
    for form in forms:
        assert sesc.Robot(form).hash == sesc.Robot(POLE).hash
    with pytest.raises(TypeError, match="path"):
        sesc.Robot(3)


def test_right_angles_are_snapped_unless_asked_not_to() -> None:
    skewed = POLE.replace("xyz='0.1 0 0'", "xyz='0.1 0 0' rpy='1.5708 0 0'")
    exact = sesc.Robot(skewed).on("foot").com([0.0])
    literal = sesc.Robot(skewed, snap=False).on("foot").com([0.0])
    assert exact[2] == 0.0 and literal[2] == pytest.approx(np.cos(1.5708), rel=1e-9)


def test_a_robot_stands_on_the_sole_of_a_link() -> None:
    robot = sesc.Robot(POLE)
    above, below = (robot.on(name).com([0.3]) for name in ("foot", "foot@40mm"))
    assert below - above == pytest.approx([0.0, 0.0, 0.04], abs=1e-15)
    with pytest.raises(sesc.SupportError, match="such as `foot@0.5mm`"):
        robot.on("foot@0.50mm")


def test_objects_say_what_they_are(op2: sesc.Robot, model: sesc.Model) -> None:
    for thing in (op2, model):
        assert "\n" not in repr(thing) and "op2" in repr(thing)
    assert "r_sole" in repr(model) and "20 joints" in repr(model)


def test_notebooks_show_the_robot(op2: sesc.Robot, model: sesc.Model, robots: Path) -> None:
    for thing in (op2, model):
        text = thing._repr_html_()
        assert text.count("<svg ") == 2 and "From the front" in text and "r_knee" in text
        assert "<script" not in text and "NaN" not in text
    few = sesc.plan(op2, "r_sole", poses=3, candidates=60, cop_box=0.05, sigmas=0.0)
    assert sesc.Postures(model, few.q)._repr_html_().count("<svg ") == 3
    for path in robots.glob("*/*.urdf"):
        assert "<svg " in sesc.Robot(path)._repr_html_(), path


def test_a_defect_is_an_error_of_its_own() -> None:
    from sesc._errors import make

    error = make("InternalError", "index 3; this is a defect of sesc, please report it", (None, None, None), None, [])
    assert isinstance(error, RuntimeError) and not isinstance(error, sesc.SescError)
    assert type(pickle.loads(pickle.dumps(error))) is sesc.InternalError
    # A panic of the library, whose own check of the shape is left out here.
    model = sesc.Robot(POLE).on("foot")
    options = {"poses": 1, "postures": np.zeros((1, 0)), "numbers": None, "range": None, "noise": 0.0, "seed": 1}
    with pytest.raises(sesc.SescError):
        sesc._sesc.simulate_log(model, {**options, "rate": None, "motion": True, "hide": []})


@pytest.mark.skipif(not hasattr(sesc._sesc, "_panic"), reason="a release has no panic to ask for")
@pytest.mark.parametrize("way", ["short", "long", "watched"])
def test_a_panic_is_an_internal_error(way: str, capfd: Any) -> None:
    """An index out of range inside the package, in a call of each kind."""
    fail: Any = getattr(sesc._sesc, "_panic")
    for _ in range(2):
        with pytest.raises(sesc.InternalError, match=f"the index is {len(way)}") as caught:
            fail(way)
        assert "calls.rs" in str(caught.value) and "a defect of sesc" in str(caught.value)
        assert isinstance(caught.value, RuntimeError)
    assert capfd.readouterr() == ("", "")
    # Nothing is left behind: no lock that is held, no sentence that another error would get.
    assert com_of(sesc.Robot(POLE).on("foot")).shape == (3, 3)


@pytest.mark.parametrize("copied", [copy.copy, copy.deepcopy, lambda x: pickle.loads(pickle.dumps(x))])
def test_copies_compute_the_same(model: sesc.Model, copied: Any) -> None:
    again = copied(model)
    np.testing.assert_array_equal(com_of(again), com_of(model))
    assert again.robot.hash == model.robot.hash and again.support == "r_sole"


@pytest.mark.parametrize("method", ["spawn", "fork"])
def test_models_go_to_other_processes(model: sesc.Model, method: str) -> None:
    model.com(np.zeros((256, 20)), threads=2)
    with multiprocessing.get_context(method).Pool(1) as pool:
        np.testing.assert_array_equal(pool.apply(com_of, (model,)), com_of(model))


def test_faults_of_a_urdf_have_file_and_line(tmp_path: Path) -> None:
    bad = tmp_path / "bad.urdf"
    bad.write_text(POLE.replace("value='2'", "value='two'"))
    with pytest.raises(sesc.UrdfError, match="two") as caught:
        sesc.Robot(bad)
    assert isinstance(caught.value, (sesc.SescError, ValueError))
    assert caught.value.file == str(bad) and caught.value.line == 2
    assert [line for line, _ in caught.value.complaints] == [2]
    again = pickle.loads(pickle.dumps(caught.value))
    assert type(again) is type(caught.value) and str(again) == str(caught.value) and again.line == 2


def test_a_file_that_is_not_there_is_an_error_of_python_too(tmp_path: Path) -> None:
    with pytest.raises(FileNotFoundError) as caught:
        sesc.Robot(tmp_path / "none.urdf")
    assert isinstance(caught.value, sesc.UrdfError) and "none.urdf" in str(caught.value)
    assert caught.value.filename == str(tmp_path / "none.urdf")
    assert pickle.loads(pickle.dumps(caught.value)).errno == caught.value.errno
    with pytest.raises(sesc.ModelFileError):
        sesc.Robot(POLE).on("foot", model=tmp_path / "none.toml")


def test_a_wrong_support_names_the_links(pole: sesc.Robot) -> None:
    with pytest.raises(sesc.SupportError, match="foot"):
        pole.on("fot")


def test_a_model_file_of_another_robot_is_refused(pole: sesc.Robot, tmp_path: Path) -> None:
    file = tmp_path / "model.toml"
    file.write_text("robot = 'x'\nhash = 'y'\nsupport = 'foot'\nparameters = []\n")
    with pytest.raises(sesc.ModelFileError, match="hash") as caught:
        pole.on("foot", model=file)
    assert caught.value.file == str(file)


def test_bad_urdfs_are_errors_and_nothing_is_written(robots: Path, capfd: Any) -> None:
    files = sorted((robots.parent / "tests" / "bad_urdf").glob("*.urdf"))
    assert len(files) > 10
    for file in files:
        try:
            robot = sesc.Robot(file)
            for link in robot.links[:3]:
                robot.on(link)
        except sesc.SescError as error:
            assert not re.search(r"(^|[\s`(])--[a-z]", str(error)), error
    for cut in range(0, len(POLE), 7):
        try:
            sesc.Robot(POLE[:cut] + "<")
        except sesc.UrdfError:
            pass
    assert capfd.readouterr() == ("", "")


def test_a_second_interpreter_of_the_process_is_refused() -> None:
    """Numpy says so, before the package can."""
    name = "_interpreters" if sys.version_info >= (3, 13) else "_xxsubinterpreters"
    pytest.importorskip(name)
    code = f"""
import sesc, {name} as interpreters
own = interpreters.create()
said = None
try:
    said = interpreters.run_string(own, "import sesc._sesc")
except Exception as error:
    said = error
print(said)
"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert done.returncode == 0 and "ImportError" in done.stdout, done.stdout + done.stderr


def test_importing_asks_for_numpy_and_json_alone() -> None:
    code = """
import sys, numpy
before = set(sys.modules)
import sesc
print(sorted({name.split('.')[0] for name in set(sys.modules) - before} - {"__future__", "_json"}))
"""
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert run.stdout.strip() == "['json', 'sesc']", run.stdout


@pytest.fixture
def calls(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Any:
    """What a stand-in for ``xacro``, which prints a robot, was called with."""
    noted, folder = tmp_path / "calls", tmp_path / "bin"
    folder.mkdir()
    (tmp_path / "pole.txt").write_text(POLE)
    script = f"#!/bin/sh\necho \"$@\" >> '{noted}'\ncat '{tmp_path / 'pole.txt'}'\n"
    (folder / "xacro").write_text(script)
    (folder / "xacro").chmod(0o755)
    monkeypatch.setenv("PATH", str(folder), prepend=os.pathsep)
    return lambda: noted.read_text().split() if noted.exists() else []


XACRO = "<robot name='r' xmlns:xacro='http://www.ros.org/wiki/xacro'>{}<link name='${{n}}'/></robot>"


@pytest.mark.skipif(sys.platform == "win32", reason="the stand-in is a shell script")
def test_no_urdf_starts_a_program(robots: Path, tmp_path: Path, calls: Any) -> None:
    evil = XACRO.format("<xacro:property name='n' value='${(lambda: 1)()}'/><xacro:leg/>")
    (tmp_path / "evil.urdf").write_text(evil)
    bad = list((robots.parent / "tests" / "bad_urdf").glob("*.urdf"))
    assert len(bad) > 50
    forms: list[Any] = [evil, evil.encode(), io.StringIO(evil), tmp_path / "evil.urdf", tmp_path, "missing.urdf"]
    for form in [*forms, *bad]:
        with pytest.raises(sesc.UrdfError):
            sesc.Robot(form)
    assert calls() == []


@pytest.mark.skipif(sys.platform == "win32", reason="the stand-in is a shell script")
def test_a_file_of_xacro_is_expanded_where_the_caller_names_it(tmp_path: Path, calls: Any) -> None:
    for name, options in [("a.urdf.xacro", {}), ("a.urdf", {"xacro": True})]:
        (tmp_path / name).write_text(XACRO.format(""))
        with pytest.warns(UserWarning, match=f"{name} was expanded by xacro, which ran code of that file"):
            robot = sesc.Robot(tmp_path / name, **options)
        assert robot.name == "pole"
    assert calls() == [str(tmp_path / "a.urdf.xacro"), str(tmp_path / "a.urdf")]
    with pytest.raises(TypeError, match="give the path"):
        sesc.Robot(POLE, xacro=True)
