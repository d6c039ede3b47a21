"""Python gives what the command line gives: JSON equal key by key, floats to the bit."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import sesc

from conftest import POLE, without_commands, worded

LEGS = ("two_link/two_link.urdf", "foot")


@pytest.fixture(scope="module")
def small(robots: Path) -> sesc.Robot:
    return sesc.Robot(robots / LEGS[0])


@pytest.fixture(scope="module")
def log(small: sesc.Robot, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A simulated log of the small robot, written by Python."""
    path = tmp_path_factory.mktemp("log") / "log.csv"
    hidden = {f"joint_offset:{small.joints[0]}": 0.05}
    sesc.simulate(small.on(LEGS[1]), 120, noise=5e-4, seed=3, hide=hidden).save(path)
    return path


def test_simulations_are_equal(small: sesc.Robot, robots: Path, log: Path, command: Any, tmp_path: Path) -> None:
    words = ["--support", LEGS[1], "--poses", 120, "--noise", "0.0005", "--seed", 3]
    words += ["--hide", f"joint_offset:{small.joints[0]}=0.05", "--out", tmp_path / "log.csv"]
    command("simulate", robots / LEGS[0], *words)
    assert (tmp_path / "log.csv").read_bytes() == log.read_bytes()
    assert (tmp_path / "log.csv.toml").read_bytes() == (log.parent / "log.csv.toml").read_bytes()


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({}, []),
        ({"prior": "tight", "noise": 4e-4}, ["--prior", "tight", "--noise", "0.0004"]),
        ({"prior": "free", "robust": "huber"}, ["--prior", "free", "--robust", "huber"]),
        ({"folds": 5, "physical": True}, ["--folds", 5, "--physical"]),
    ],
)
def test_fits_are_equal(
    small: sesc.Robot, robots: Path, log: Path, command_json: Any, options: Any, words: Any, tmp_path: Path, command: Any
) -> None:
    found = sesc.fit(small, log, **options)
    want = command_json("fit", robots / LEGS[0], "--data", log, *words)
    assert json.dumps(worded(found.to_dict())) == json.dumps(worded(want))
    outputs = ["--out", tmp_path / "a.toml", "--urdf", tmp_path / "a.urdf", "--total-mass", "3.5"]
    text = command("fit", robots / LEGS[0], "--data", log, *words, "--long", *outputs)
    assert without_commands(str(found)) in without_commands(text)
    found.save(tmp_path / "b.toml")
    found.correct_urdf(total_mass=3.5).save(tmp_path / "b.urdf")
    for end in ("toml", "urdf"):
        assert (tmp_path / f"a.{end}").read_bytes() == (tmp_path / f"b.{end}").read_bytes()


def test_diagnoses_are_equal(small: sesc.Robot, robots: Path, log: Path, command_json: Any, command: Any, tmp_path: Path) -> None:
    found = sesc.diagnose(small, log)
    want = command_json("diagnose", robots / LEGS[0], "--data", log)
    assert json.dumps(worded(found.to_dict())) == json.dumps(worded(want))
    outputs = ["--out", tmp_path / "a.toml", "--urdf", tmp_path / "a.urdf", "--total-mass", "3.5"]
    command("diagnose", robots / LEGS[0], "--data", log, *outputs, "--report", tmp_path / "a.html")
    found.save(tmp_path / "b.toml")
    found.correct_urdf(total_mass=3.5).save(tmp_path / "b.urdf")
    for end in ("toml", "urdf"):
        assert (tmp_path / f"a.{end}").read_bytes() == (tmp_path / f"b.{end}").read_bytes()
    found.report(tmp_path / "b.html")
    assert (tmp_path / "b.html").stat().st_size > 10_000


@pytest.fixture(scope="module")
def stays(log: Path) -> Path:
    """The log held still for 0.6 s in each posture, with times and moves of 0.4 s between."""
    header, *rows = [line.split(",") for line in log.read_text().splitlines()]
    kept = [k for k, name in enumerate(header) if name != "pose"]
    lines = [["t", *(header[k] for k in kept)]]
    for row, values in enumerate(rows):
        for k in range(7):
            lines.append([f"{row + 0.1 * k:.1f}", *(values[k] for k in kept)])
    path = log.parent / "stays.csv"
    path.write_text("\n".join(",".join(line) for line in lines) + "\n")
    path.with_name("stays.csv.toml").write_text(log.with_name("log.csv.toml").read_text())
    return path


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"settle": 0.5}, ["--settle", 0.5]),
        ({"settle": 0.0}, ["--settle", 0]),
        ({"motion": "off"}, ["--motion", "off"]),
    ],
)
def test_stays_and_motion_are_equal(
    small: sesc.Robot, robots: Path, stays: Path, command_json: Any, options: Any, words: Any
) -> None:
    asks: list[tuple[Any, str]] = [(sesc.fit, "fit"), (sesc.diagnose, "diagnose")]
    for ask, name in asks:
        want = command_json(name, robots / LEGS[0], "--data", stays, *words)
        assert json.dumps(worded(ask(small, stays, **options).to_dict())) == json.dumps(worded(want))
    part = sesc.gather(small, stays, **options)
    assert part.postures == sesc.fit(small, stays, **options).to_dict()["postures"]


def test_stays_of_no_length_and_unknown_motion_are_refused(small: sesc.Robot, stays: Path) -> None:
    asks: list[Any] = [sesc.fit, sesc.diagnose, sesc.gather]
    for ask in asks:
        with pytest.raises(sesc.FitError, match="`settle`: give 0.01 to 3600 seconds"):
            ask(small, stays, settle=-0.5)
        with pytest.raises(ValueError, match="`motion` 'slow': give 'auto' or 'off'"):
            ask(small, stays, motion="slow")


def test_predictions_are_equal(small: sesc.Robot, robots: Path, log: Path, command: Any, tmp_path: Path) -> None:
    found = sesc.diagnose(small, log)
    found.save(tmp_path / "model.toml")
    for file in (None, tmp_path / "model.toml"):
        words = [] if file is None else ["--model", file]
        printed = command("predict", robots / LEGS[0], "--data", log, *words).splitlines()[1:]
        table = np.array([line.split(",") for line in printed], dtype=float)
        ours = sesc.predict(small.on(LEGS[1], model=file), log)
        np.testing.assert_array_equal(table, np.column_stack([ours["pose"], ours["com"], ours["cop"]]))
    # The model of a diagnosis is that of its file.
    again = small.on(LEGS[1], model=tmp_path / "model.toml")
    q = np.zeros((3, small.on(LEGS[1]).dof))
    np.testing.assert_array_equal(found.model.com(q), again.com(q))
    np.testing.assert_array_equal(small.on(LEGS[1], model=again).cop(q), again.cop(q))


def test_plans_are_equal(robots: Path, op2: sesc.Robot, command_json: Any, tmp_path: Path) -> None:
    found = sesc.plan(op2, "r_sole", poses=6, candidates=60, seed=2)
    words = ["--support", "r_sole", "--poses", 6, "--candidates", 60, "--seed", 2]
    want = command_json("plan", robots / "op2/op2.urdf", *words, "--out", tmp_path / "a.csv")
    assert json.dumps(worded(found.to_dict())) == json.dumps(worded(want))
    found.save(tmp_path / "b.csv")
    for end in ("csv", "csv.toml"):
        rows = [(tmp_path / f"{name}.{end}").read_text() for name in "ab"]
        assert rows[0] == rows[1]


@pytest.mark.parametrize("scalar", ["f64", "f32", "fixed32"])
def test_c_is_equal(robots: Path, model: sesc.Model, command: Any, scalar: Any, tmp_path: Path) -> None:
    words = ["--support", "r_sole", "--lang", "c", "--scalar", scalar]
    command("generate", robots / "op2/op2.urdf", *words, "--out", tmp_path / "a")
    files = model.c99(tmp_path / "b", scalar=scalar)
    assert sorted(file.name for file in files) == ["op2_r_sole.c", "op2_r_sole.h"]
    for file in files:
        assert file.read_bytes() == (tmp_path / "a" / file.name).read_bytes()


def test_rust_is_equal(robots: Path, model: sesc.Model, command: Any, tmp_path: Path) -> None:
    command("generate", robots / "op2/op2.urdf", "--support", "r_sole", "--out", tmp_path / "a")
    (file,) = model.rust(tmp_path / "b")
    assert file.read_bytes() == (tmp_path / "a" / file.name).read_bytes()


@pytest.mark.parametrize("language", ["c99", "rust"])
def test_chosen_functions_are_equal(
    robots: Path, model: sesc.Model, command: Any, language: str, tmp_path: Path
) -> None:
    words = ["--support", "r_sole", "--lang", language.removesuffix("99"), "--functions", "cop,com_jacobian"]
    command("generate", robots / "op2/op2.urdf", *words, "--out", tmp_path / "a")
    for given in (["cop", "com_jacobian"], iter(("com_jacobian", "cop"))):
        for file in getattr(model, language)(tmp_path / "b", functions=given):
            assert file.read_bytes() == (tmp_path / "a" / file.name).read_bytes()
    (*_, alone) = getattr(model, language)(tmp_path / "c", functions="com")
    assert "com_jacobian(" not in alone.read_text()
    with pytest.raises(sesc.SescError, match="there is no function `zpm`; known are com, "):
        getattr(model, language)(tmp_path / "d", functions=["zpm"])
    assert not (tmp_path / "d").exists()


def test_parts_are_equal(small: sesc.Robot, robots: Path, log: Path, command: Any, tmp_path: Path) -> None:
    command("fit", robots / LEGS[0], "--data", log, "--unit", "r07", "--partial", tmp_path / "log.part")
    part = sesc.gather(small, log, unit="r07")
    assert bytes(part) == (tmp_path / "log.part").read_bytes()
    assert sesc.Part.load(tmp_path / "log.part") == part
    assert sesc.fit(part).to_dict()["parameters"] == sesc.fit(small, log).to_dict()["parameters"]


def test_motion_and_rate_are_equal(small: sesc.Robot, robots: Path, command: Any, tmp_path: Path) -> None:
    model = small.on(LEGS[1])
    for motion in ("auto", "off"):
        ours = tmp_path / f"{motion}.csv"
        sesc.simulate(model, 150, rate=40.0, motion=motion, noise=1e-4, seed=5).save(ours)
        words = ["--support", LEGS[1], "--poses", 150, "--noise", "0.0001", "--seed", 5, "--rate", 40]
        command("simulate", robots / LEGS[0], *words, "--motion", motion, "--out", tmp_path / "theirs.csv")
        assert ours.read_bytes() == (tmp_path / "theirs.csv").read_bytes()
        printed = command("predict", robots / LEGS[0], "--data", ours, "--motion", motion).splitlines()[1:]
        table = np.array([line.split(",") for line in printed], dtype=float)
        found = sesc.predict(model, ours, motion=motion)
        np.testing.assert_array_equal(table, np.column_stack([found["pose"], found["com"], found["cop"]]))
    moving, still = (sesc.predict(model, tmp_path / "auto.csv", motion=motion)["cop"] for motion in ("auto", "off"))
    assert np.abs(moving - still).max() > 1e-4


def test_plans_with_revisits_a_log_or_both_feet_are_equal(robots: Path, op2: sesc.Robot, command_json: Any, tmp_path: Path) -> None:
    log = tmp_path / "before.csv"
    sesc.simulate(op2.on("r_sole"), 60, range=0.5, noise=3e-4).save(log)
    asked: list[tuple[dict[str, Any], list[object]]] = [
        ({"revisits": 2}, ["--revisits", 2]),
        ({"data": log}, ["--data", log]),
        ({"both_feet": True, "other_foot": "l_sole"}, ["--both-feet", "--other-foot", "l_sole"]),
    ]
    for options, words in asked:
        found = sesc.plan(op2, "r_sole", poses=5, candidates=60, cop_box=0.1, sigmas=0.0, **options)
        common = ["--support", "r_sole", "--poses", 5, "--candidates", 60, "--cop-box", 0.1, "--sigmas", 0]
        want = command_json("plan", robots / "op2/op2.urdf", *common, *words, "--out", tmp_path / "a.csv")
        assert json.dumps(worded(found.to_dict())) == json.dumps(worded(want))
        found.save(tmp_path / "b.csv")
        for end in ("csv", "csv.toml"):
            assert (tmp_path / f"a.{end}").read_text() == (tmp_path / f"b.{end}").read_text()
    with pytest.raises(sesc.PlanError, match="`data` knows the noise"):
        sesc.plan(op2, "r_sole", poses=5, data=log, noise=1e-3)


ROBOTS = [
    ("arm6", "base_link"),
    ("lift_base", "base_link"),
    ("op2", "r_sole"),
    ("plain_humanoid", "right_sole"),
    ("quadruped", "lf_foot"),
    ("skew_humanoid", "right_sole"),
    ("two_link", "foot"),
]


def test_every_robot_is_compared(robots: Path) -> None:
    assert sorted(path.stem for path in robots.glob("*/*.urdf")) == [name for name, _ in ROBOTS]


@pytest.mark.parametrize("name", [name for name, _ in ROBOTS])
def test_robots_are_equal(name: str, robots: Path, command: Any, command_json: Any, tmp_path: Path) -> None:
    urdf = robots / name / f"{name}.urdf"
    robot = sesc.Robot(urdf)
    support = dict(ROBOTS)[name]
    model = robot.on(support)
    inspected = command_json("inspect", urdf, "--support", support)
    assert json.dumps(worded(model.to_dict())) == json.dumps(worded(inspected))
    words = ["--support", support, "--poses", 60, "--noise", "0.0005", "--seed", 2]
    command("simulate", urdf, *words, "--out", tmp_path / "log.csv")
    sesc.simulate(model, 60, noise=5e-4, seed=2).save(tmp_path / "ours.csv")
    assert (tmp_path / "ours.csv").read_bytes() == (tmp_path / "log.csv").read_bytes()
    printed = command("predict", urdf, "--data", tmp_path / "log.csv").splitlines()[1:]
    table = np.array([line.split(",") for line in printed], dtype=float)
    ours = sesc.predict(model, tmp_path / "log.csv")
    np.testing.assert_array_equal(table, np.column_stack([ours["pose"], ours["com"], ours["cop"]]))
    asks: list[tuple[Any, str]] = [(sesc.fit, "fit"), (sesc.diagnose, "diagnose")]
    for ask, word in asks:
        want = command_json(word, urdf, "--data", tmp_path / "log.csv")
        assert json.dumps(worded(ask(robot, tmp_path / "log.csv").to_dict())) == json.dumps(worded(want))


def test_a_shape_below_the_frame_is_noted_as_by_the_command(command_json: Any, tmp_path: Path) -> None:
    """The library says it, for both."""
    box = "<collision><origin xyz='0 0 -0.02'/><geometry><box size='0.1 0.1 0.04'/></geometry></collision>"
    urdf = tmp_path / "pole.urdf"
    urdf.write_text(POLE.replace("<link name='foot'/>", f"<link name='foot'>{box}</link>"))
    model = sesc.Robot(urdf).on("foot")
    notes = model.to_dict()["notes"]
    assert "collision shape of `foot` reaches 40.0 mm below it" in notes[-1] and "`foot@40mm`" in notes[-1]
    assert notes == command_json("inspect", urdf, "--support", "foot")["notes"] == model.notes


#: Rows of a log that cannot be used, the first of them on line 2.
BAD_LOGS = {
    "a word": "0,0.1,two,0.1,0\n",
    "a cell too many": "0,0.1,0.2,0.1,0,7\n",
    "a cell too few": "0,0.1,0.2,0.1\n",
    "an angle without end": "0,0.1,inf,0.1,0\n",
    "half a posture number": "0.5,0.1,0.2,0.1,0\n",
    "a quote that does not end": '0,0.1,"0.2,0.1,0\n',
    "nothing": "",
}


def error_of(call: Any) -> sesc.SescError:
    with pytest.raises(sesc.SescError) as caught:
        call()
    return caught.value


@pytest.mark.parametrize("rows", BAD_LOGS.values(), ids=BAD_LOGS)
def test_errors_of_logs_are_equal(small: sesc.Robot, robots: Path, rows: str, command_json: Any, tmp_path: Path) -> None:
    log = tmp_path / "log.csv"
    log.write_text(f"pose,{','.join(small.joints)},cop_x,cop_y\n{rows}")
    (tmp_path / "log.csv.toml").write_text(f"support = '{LEGS[1]}'\n")
    want = command_json("fit", robots / LEGS[0], "--data", log, expect=2)["error"]
    error = error_of(lambda: sesc.fit(small, log))
    assert (error.file, error.line) == (want.get("file"), want.get("line")) and error.file == str(log)
    assert str(error) == want["message"]


def test_errors_of_urdfs_are_equal(robots: Path, command: Any, capfd: Any) -> None:
    files = sorted((robots.parent / "tests" / "bad_urdf").glob("*.urdf"))
    assert len(files) > 80
    for file in files:
        said = json.loads(command("inspect", file, "--support", "foot", "--json", expect=(0, 2)))
        if "error" not in said:
            sesc.Robot(file).on("foot")
            continue
        error, want = error_of(lambda: sesc.Robot(file).on("foot")), said["error"]
        assert (error.file, error.line, str(error)) == (want.get("file"), want.get("line"), want["message"]), file
    assert capfd.readouterr() == ("", "")
