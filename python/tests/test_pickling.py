"""Everything that can be pickled goes to other processes and comes back as it was."""

from __future__ import annotations

import multiprocessing
import pickle
import weakref
from pathlib import Path
from typing import Any

import pytest

import sesc

from conftest import POLE


def everything(folder: Path) -> dict[str, Any]:
    """One of each object, by its name."""
    robot = sesc.Robot(POLE)
    model = robot.on("foot")
    log = sesc.simulate(model, 40, noise=1e-4, hide={"joint_offset:hip": 0.05})
    fit, found = sesc.fit(robot, log), sesc.diagnose(robot, log, prior="tight")
    log.save(folder / "r1_monday.csv")
    return {
        "Robot": robot,
        "Model": model,
        "Log": log,
        "Fit": fit,
        "Parameter": next(iter(fit.parameters.values())),
        "CorrectedUrdf": fit.correct_urdf(),
        "Diagnosis": found,
        "Step": found.steps[0],
        "Quantity": next(iter(found.steps[0].parameters.values())),
        "Finding": sesc.Finding("kind", "-", "sentence"),
        "Postures": found.next_postures(3),
        "Plan": sesc.plan(robot, "foot", poses=4, cop_box=0.3, sigmas=0.0, candidates=50),
        "Part": sesc.gather(robot, log, unit="r07"),
        "Comparison": sesc.compare(fit, fit),
        "Verification": sesc.verify(model, samples=20),
        "Effect": sesc.effects()["backlash"],
        "Fleet": sesc.fleet.run(robot, str(folder / "r1_monday.csv"), support="foot", information=True),
    }


def seen(thing: Any) -> tuple[str, Any, str]:
    """What there is to see of an object."""
    return repr(thing), thing.to_dict(), thing._repr_html_()


def seen_there(things: dict[str, Any]) -> dict[str, Any]:
    return {name: (seen(thing), thing) for name, thing in things.items()}


def test_there_is_one_of_every_public_class(tmp_path: Path) -> None:
    things = everything(tmp_path)
    assert all(type(thing).__name__ == name for name, thing in things.items())
    spaces: list[Any] = [sesc, sesc.fleet]
    public = {name for space in spaces for name in space.__all__ if isinstance(getattr(space, name), type)}
    errors = {name for name in public if issubclass(getattr(sesc, name, object), Exception)}
    # A job is a row of what others here are made of.
    assert public - errors - {"Job"} == set(things)
    for name in errors:
        error = getattr(sesc, name)("a sentence")
        again = pickle.loads(pickle.dumps(error))
        assert type(again) is type(error) and str(again) == "a sentence"
    job = sesc.fleet.Job(things["Robot"], "{}", "{}")
    assert pickle.loads(pickle.dumps(job))[1:] == job[1:-1] + (None,)


def test_objects_are_referred_to_weakly(tmp_path: Path) -> None:
    for name, thing in everything(tmp_path).items():
        # What is a tuple of its fields has no place for it, as any tuple of Python's.
        if not isinstance(thing, tuple):
            assert weakref.ref(thing)() is thing, name


@pytest.mark.parametrize("method", ["spawn", "fork"])
def test_objects_go_to_other_processes_and_back(method: str, tmp_path: Path) -> None:
    things = everything(tmp_path)
    with multiprocessing.get_context(method).Pool(1) as pool:
        there = pool.apply(seen_there, (things,))
    for name, thing in things.items():
        own = seen(thing)
        assert "\n" not in own[0] and own[2], name
        said, again = there[name]
        assert said == own == seen(again), name


TOLERANCES = """[default]
mass = 0.05
com = 0.004
"""


@pytest.mark.parametrize("physical", [False, True])
def test_a_fit_corrects_the_urdf_after_its_journey(physical: bool, robots: Path, tmp_path: Path) -> None:
    """Also where the file of its tolerances is no more, and after a second journey."""
    robot = sesc.Robot(robots / "two_link/two_link.urdf")
    log = sesc.simulate(robot.on("foot"), 40, noise=5e-4, hide={f"joint_offset:{robot.joints[0]}": 0.01})
    tolerances = tmp_path / "tolerances.toml"
    tolerances.write_text(TOLERANCES)
    fit = sesc.fit(robot, log, prior=tolerances, physical=physical)
    data = pickle.dumps(fit)
    tolerances.unlink()
    again = pickle.loads(data)
    for there in (again, pickle.loads(pickle.dumps(again))):
        for total in (None, 3.5):
            assert there.correct_urdf(total_mass=total) == fit.correct_urdf(total_mass=total)
    assert fit.correct_urdf().text != robot.urdf
    for travelled in (fit, again):
        with pytest.raises(sesc.FitError, match="`total_mass` -1e0 kg"):
            travelled.correct_urdf(total_mass=-1.0)


def test_a_fleet_is_whole_after_its_journey(tmp_path: Path) -> None:
    fleet = everything(tmp_path)["Fleet"]
    again = pickle.loads(pickle.dumps(fleet))
    for found, name in ((fleet, "here"), (again, "there")):
        (tmp_path / name).mkdir()
        found.save(tmp_path / name / "fleet.csv")
        found.report(tmp_path / name / "fleet.html")
    for file in (tmp_path / "here").rglob("*.*"):
        there = tmp_path / "there" / file.relative_to(tmp_path / "here")
        assert there.read_bytes() == file.read_bytes()
    assert again.rows == fleet.rows and len(again) == 1
