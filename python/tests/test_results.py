"""What fits, diagnoses, plans and parts give; their life; Ctrl-C."""

from __future__ import annotations

import json
import os
import pickle
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import sesc
from sesc import _run
from sesc._html import framed, table

HIDDEN = {"joint_offset:r_knee": 0.026}


@pytest.fixture(scope="module")
def log(model: sesc.Model) -> sesc.Log:
    return sesc.simulate(model, 100, range=0.5, noise=5e-4, hide=HIDDEN)


@pytest.fixture(scope="module")
def found(op2: sesc.Robot, log: sesc.Log) -> sesc.Diagnosis:
    return sesc.diagnose(op2, log)


def test_a_hidden_offset_is_among_the_explanations(found: sesc.Diagnosis) -> None:
    assert found.verdict in ("named", "class")
    assert ["joint_offset:r_knee"] in found.explanations
    assert found.steps and found.steps[0].sentence and found.sentence
    assert found.health == [] and found.unexplained is False


def test_healthy_logs_and_fitted_models_take_the_place_of_cad(
    model: sesc.Model, op2: sesc.Robot, log: sesc.Log, tmp_path: Path
) -> None:
    before = sesc.simulate(model, 200, range=0.5, noise=5e-4, seed=2)
    by_log = sesc.diagnose(op2, log, healthy=before)
    assert ["joint_offset:r_knee"] in by_log.explanations
    fitted = tmp_path / "before.toml"
    sesc.fit(op2, before).save(fitted)
    by_file = sesc.diagnose(op2, log, prior=fitted)
    assert by_file.explanations == by_log.explanations
    with pytest.raises(sesc.SescError, match="fitted to this very log"):
        sesc.diagnose(op2, before, prior=fitted)


def test_the_model_of_a_diagnosis_has_the_effect(
    found: sesc.Diagnosis, model: sesc.Model, op2: sesc.Robot
) -> None:
    q = np.random.default_rng(2).uniform(-0.5, 0.5, (50, 20))
    bent = q.copy()
    bent[:, model.joints.index("r_knee")] += HIDDEN["joint_offset:r_knee"]
    truth = model.com(bent)

    def rms(com: Any) -> float:
        return float(np.sqrt(((com - truth) ** 2).mean()))

    assert rms(found.model.com(q)) < 0.4 * rms(model.com(q))


def test_files_are_written_whole_and_read_again(
    found: sesc.Diagnosis, op2: sesc.Robot, tmp_path: Path
) -> None:
    found.save(tmp_path / "model.toml")
    np.testing.assert_array_equal(op2.on("r_sole", tmp_path / "model.toml").params, found.model.params)
    corrected = found.correct_urdf(total_mass=2.93)
    corrected.save(tmp_path / "op2.urdf")
    again = sesc.Robot(tmp_path / "op2.urdf")
    assert again.on("r_sole").total_mass == pytest.approx(2.93, abs=1e-9)
    with pytest.raises(sesc.SescError):
        found.correct_urdf(total_mass=-1.0)
    with pytest.raises(OSError):
        found.save(tmp_path / "none" / "model.toml")
    assert sorted(os.listdir(tmp_path)) == ["model.toml", "op2.urdf"]


def test_next_postures_are_postures(found: sesc.Diagnosis, tmp_path: Path) -> None:
    postures = found.next_postures(30)
    assert postures.shape[1] == 20 and len(postures) <= 30
    few = found.next_postures(5)
    assert {tuple(row) for row in few.q} <= {tuple(row) for row in postures.q}
    if len(found.explanations) > 1:
        assert len(postures) == 30 and len(few) == 5
    postures.save(tmp_path / "next.csv")
    assert len((tmp_path / "next.csv").read_text().splitlines()) == 1 + len(postures)


def test_simulations_of_given_postures_are_theirs(model: sesc.Model) -> None:
    q = np.random.default_rng(3).uniform(-0.5, 0.5, (9, 20))
    log = sesc.simulate(model, q).columns()
    np.testing.assert_array_equal(np.column_stack([log[name] for name in model.joints]), q)
    np.testing.assert_array_equal(np.column_stack([log["cop_x"], log["cop_y"]]), model.cop(q))
    noisy = sesc.simulate(model, q, noise=1e-3, seed=4).columns()
    assert 0 < np.abs(noisy["cop_x"] - log["cop_x"]).max() < 5e-3
    with pytest.raises(ValueError):
        sesc.simulate(model, np.zeros((3, 19)))


def test_plans_balance_and_are_simulated(op2: sesc.Robot, model: sesc.Model) -> None:
    plan = sesc.plan(op2, "r_sole", poses=6, candidates=60, limits={"head_pan": (-0.1, 0.1)})
    assert plan.shape == (6, 20) and plan.joints == model.joints
    assert np.abs(model.cop(plan.q)).max() < 0.023
    assert np.abs(plan.q[:, model.joints.index("head_pan")]).max() <= 0.1
    assert len(sesc.simulate(model, plan)) == 6
    again = pickle.loads(pickle.dumps(plan))
    np.testing.assert_array_equal(again.q, plan.q)
    assert "srcdoc" in plan._repr_html_() and str(plan).startswith("op2 on r_sole")
    assert str(plan).rstrip().endswith('sesc.fit(robot, "LOG", support="r_sole")')


def test_a_plan_has_the_rows_of_its_file(op2: sesc.Robot, model: sesc.Model, tmp_path: Path) -> None:
    plan = sesc.plan(op2, "r_sole", poses=6, candidates=60, revisits=3)
    plan.save(tmp_path / "plan.csv")
    rows = np.loadtxt(tmp_path / "plan.csv", delimiter=",", skiprows=1)
    again = pickle.loads(pickle.dumps(plan))
    for one in (plan, again):
        assert one.shape == (9, 20) and len(one) == 9 and one.poses == 6
        assert one.q.tolist() == np.asarray(one).tolist() == rows[:, 1:].tolist()
        assert np.column_stack(list(one.columns().values())).tolist() == rows.tolist()
        log = sesc.simulate(model, one, noise=5e-4)
        assert log.columns()["pose"].tolist() == rows[:, 0].tolist()
    # Visits of one posture are known as such.
    assert len(set(rows[:, 0])) == 6 and sesc.fit(op2, log).postures == 6
    again.save(tmp_path / "again.csv")
    assert (tmp_path / "again.csv").read_bytes() == (tmp_path / "plan.csv").read_bytes()


#: A hand of 400 joints on a foot.
HAND = "<robot name='hand'><link name='foot'/>" + "".join(
    f"<link name='l{k}'><inertial><mass value='1'/></inertial></link><joint name='a_joint_with_a_long_name_{k}' type='revolute'>"
    f"<parent link='foot'/><child link='l{k}'/><origin xyz='0 0 {k}'/><axis xyz='1 0 0'/><limit lower='-1' upper='1'/></joint>"
    for k in range(400)
) + "</robot>"


def test_a_cell_of_a_notebook_is_below_200_kb(op2: sesc.Robot, model: sesc.Model, found: sesc.Diagnosis) -> None:
    log = sesc.simulate(model, 1000, noise=5e-4, hide=HIDDEN)
    fit, plan = sesc.fit(op2, log), sesc.plan(op2, "r_sole", poses=60, candidates=200)
    hand = sesc.Robot(HAND)
    drawn = sesc.Postures(hand.on("foot"), np.zeros((10, 400)))
    things: list[Any] = [fit, sesc.diagnose(op2, log), found, plan, sesc.compare(fit, found), op2, model]
    for thing in [*things, hand, hand.on("foot"), drawn]:
        assert len(thing._repr_html_().encode()) < 200_000, thing
    # What is left out is said, and what has room is there.
    cell = found._repr_html_()
    assert "figures have no room here" in cell and cell.count("<svg") > 10 and found.sentence[:20] in cell
    fleet = table("t", ("a", "b"), [("x" * 90, k) for k in range(9000)])
    assert len(fleet) < 200_000 and "more rows" in fleet
    page = "<p class='a'>x & \"y\", 1 µm</p><script>1</script>"
    assert "srcdoc='<p class=&#x27;a&#x27;>x &amp; \"y\", 1 µm</p>'" in framed(page, "")
    text = "\n".join("x" * 99 for _ in range(9000))
    assert len(framed("y" * 200_000, text)) < 200_000 and "more lines" in framed("y" * 200_000, text)


def test_parts_merge_to_the_fit_of_all(op2: sesc.Robot, model: sesc.Model) -> None:
    logs = [sesc.simulate(model, 100, range=0.5, noise=1e-4, seed=seed) for seed in (1, 2, 3)]
    a, b, c = (sesc.gather(op2, log) for log in logs)
    together = sesc.fit(op2, logs)
    for whole in (a | b | c, c | (a | b), sesc.Part.from_bytes(bytes(a | c)) | b):
        apart = sesc.fit(whole)
        np.testing.assert_allclose(apart.params, together.params, atol=1e-12)
        assert apart.postures == 300 and len(whole.logs) == 3
    with pytest.raises(sesc.PartError):
        a | a
    with pytest.raises(sesc.PartError):
        sesc.Part.from_bytes(bytes(a)[:-100])
    with pytest.raises(sesc.PartError):
        sesc.Part.from_bytes(b"")
    assert pickle.loads(pickle.dumps(a)) == a and hash(pickle.loads(pickle.dumps(a))) == hash(a)


def test_results_are_pickled(found: sesc.Diagnosis, op2: sesc.Robot, log: sesc.Log, tmp_path: Path) -> None:
    again = pickle.loads(pickle.dumps(found))
    assert again.to_dict() == found.to_dict() and str(again) == str(found)
    np.testing.assert_array_equal(again.next_postures(5).q, found.next_postures(5).q)
    fit = sesc.fit(op2, log)
    same = pickle.loads(pickle.dumps(fit))
    assert same.to_dict() == fit.to_dict() and same.correct_urdf() == fit.correct_urdf()
    np.testing.assert_array_equal(same.covariance, fit.covariance)
    same.report(tmp_path / "fit.html")
    assert (tmp_path / "fit.html").stat().st_size > 10_000
    for thing in (found, fit, sesc.gather(op2, log)):
        assert "\n" not in repr(thing)
        assert thing._repr_html_().startswith(("<iframe", "<table"))
        assert "<script" not in thing._repr_html_()


def test_progress_is_told_and_may_stop_a_call(op2: sesc.Robot, log: sesc.Log, capfd: Any) -> None:
    told: list[tuple[str, int, int | None]] = []
    sesc.diagnose(op2, log, progress=lambda *progress: told.append(progress))
    assert told and all(isinstance(what, str) for what, _, _ in told)

    left: list[float | None] = []

    def with_end(what: str, done: int, total: int | None, seconds: float | None) -> None:
        left.append(seconds)

    sesc.diagnose(op2, log, progress=with_end)
    assert left and all(seconds is None or seconds >= 0.0 for seconds in left)

    def stop(*_: object) -> None:
        raise RuntimeError("enough")

    with pytest.raises(RuntimeError, match="enough"):
        sesc.diagnose(op2, log, progress=stop)
    sesc.diagnose(op2, log, progress=True)
    assert capfd.readouterr().err == ""


def test_parameters_of_a_fit_are_a_table_of_any_library(op2: sesc.Robot, log: sesc.Log) -> None:
    pa = pytest.importorskip("pyarrow")
    fit = sesc.fit(op2, log)
    table = pa.Table.from_pylist(fit.to_dict()["parameters"])
    assert table.column_names == ["name", "value", "std", "cad", "source"]
    np.testing.assert_array_equal(table["value"].to_numpy(), fit.params)
    assert table["name"].to_pylist() == list(fit.parameters)
    assert table["std"].to_pylist() == [one.std for one in fit.parameters.values()]


def test_what_is_left_goes_as_the_last_tenth_went(monkeypatch: pytest.MonkeyPatch) -> None:
    now = [0.0]
    monkeypatch.setattr(time, "monotonic", lambda: now[0])
    told = []

    def keep(what: str, done: int, total: int | None, left: float | None) -> None:
        told.append((done, left))

    show = _run.shown(keep)
    assert show is not None
    # Twenty of a store at once, and the others at 2 s each.
    for done, seconds in [(0, 0.0), (20, 0.1), (30, 20.1), (40, 40.1), (100, 160.1)]:
        now[0] = seconds
        show("diagnosing", done, 100)
    assert told[0] == (0, None) and told[1][1] == pytest.approx(0.4)
    assert [left for _, left in told[2:]] == pytest.approx([140.0, 120.0, 0.0])
    assert [_run._time(s) for s in (3, 120, 7800)] == ["3 s", "2 min", "2 h 10 min"]
    assert _run.shown(print) is print


def test_other_threads_go_on_during_a_fit(op2: sesc.Robot, model: sesc.Model) -> None:
    """Another thread counts at least half as quickly as while this one sleeps. Other programs may
    take a processor in the middle: one try of five is enough, and a kept lock fails all."""
    log = sesc.simulate(model, 100_000, range=0.5, noise=1e-4)

    def counted(call: Any) -> float:
        """How often another thread counts in a second meanwhile."""
        count, over = [0], threading.Event()

        def go_on() -> None:
            while not over.is_set():
                count[0] += 1

        counter = threading.Thread(target=go_on)
        counter.start()
        before, start = count[0], time.perf_counter()
        call()
        rate = (count[0] - before) / (time.perf_counter() - start)
        over.set()
        counter.join()
        return rate

    shares: list[float] = []
    while len(shares) < 5 and max(shares, default=0.0) < 0.5:
        free = counted(lambda: time.sleep(0.3))
        shares.append(counted(lambda: sesc.fit(op2, log)) / free)
    assert max(shares) >= 0.5, shares


INTERRUPTED = """
import os, sys, threading, time, signal
import sesc
# A shell that starts programs in the background has them ignore Ctrl-C.
signal.signal(signal.SIGINT, signal.default_int_handler)
robot = sesc.Robot(sesc.OP2_URDF)
model = robot.on("r_sole")
calls = {
    "fit": lambda: sesc.fit(robot, log),
    "gather": lambda: sesc.gather(robot, log),
    "diagnose": lambda: sesc.diagnose(robot, log),
    "simulate": lambda: sesc.simulate(model, 5_000_000, noise=1e-4),
    "plan": lambda: sesc.plan(robot, "r_sole", poses=38, candidates=20000),
    "save": lambda: big.save("log.csv"),
    "verify": lambda: sesc.verify(model, samples=1_000_000),
    "array": lambda: model.com_jacobian(q, out=out),
    "threads": lambda: model.com_jacobian(q, out=out, threads=3),
    "fleet": lambda: sesc.fleet.run(robot, table, store=sys.argv[3] + "/rows"),
    "executor": lambda: on_threads(),
    "table": lambda: sesc.Log(wide, support="r_sole"),
    "arrow": lambda: sesc.Log(wide, support="r_sole"),
    "predict": lambda: sesc.predict(model, log),
    "health": lambda: log.health,
    "c99": lambda: long.c99(sys.argv[3] + "/fw", lanes=8),
    "rust": lambda: long.rust(sys.argv[3] + "/src"),
}
def on_threads():
    from concurrent.futures import ThreadPoolExecutor
    with ThreadPoolExecutor(2) as engine:
        sesc.fleet.run(robot, table, store=sys.argv[3] + "/rows", engine=engine)
name = sys.argv[1]
log = sesc.simulate(model, 300_000, range=0.5, noise=1e-4) if name in ("fit", "gather", "diagnose", "predict", "health") else None
big = sesc.simulate(model, 300_000) if name == "save" else None
if name in ("array", "threads"):
    import numpy as np
    q = np.zeros((400_000, 20))
    out = np.zeros((400_000, 3, 20))
if name in ("table", "arrow"):
    import numpy as np
    wide = {column: np.zeros(4_000_000) for column in [*model.joints, "cop_x", "cop_y"]}
if name == "arrow":
    import pyarrow
    wide = pyarrow.table({column: values[:2_000_000] for column, values in wide.items()})
if name in ("c99", "rust"):
    link = "<link name='l{0}'><inertial><origin xyz='0.01 0.02 0.1'/><mass value='1'/></inertial></link>"
    joint = "<joint name='j{1}' type='revolute'><parent link='l{0}'/><child link='l{1}'/><origin xyz='0 0.01 0.1'/>"
    joint += "<axis xyz='{2}'/><limit lower='-1' upper='1' effort='1' velocity='1'/></joint>"
    axes = ["1 0 0", "0 1 0", "0 0 1"]
    parts = [link.format(k) for k in range(161)] + [joint.format(k, k + 1, axes[k % 3]) for k in range(160)]
    long = sesc.Robot("<robot name='long'>" + "".join(parts) + "</robot>").on("l0")
if name in ("fleet", "executor"):
    paths = [f"{sys.argv[3]}/{k}.csv" for k in range(24)]
    for k, path in enumerate(paths):
        sesc.simulate(model, 3000, range=0.5, noise=1e-4, seed=k).save(path)
    table = {"path": paths, "robot": [str(k) for k in range(24)], "day": ["1"] * 24}
def send():
    time.sleep(delay)
    sent.append(time.perf_counter())
    os.kill(os.getpid(), signal.SIGINT)
for delay in map(float, sys.argv[2].split()):
    # A quick machine may end the call before the signal comes: then it comes sooner.
    said = "ended"
    while said == "ended" and delay > 1e-3:
        sent = []
        sender = threading.Thread(target=send)
        sender.start()
        try:
            calls[name]()
            try:
                sender.join()
            except KeyboardInterrupt:
                pass
        except KeyboardInterrupt:
            said = str(time.perf_counter() - sent[0])
        if said == "ended" and os.path.exists("log.csv"):
            os.remove("log.csv")
        delay /= 2
    # Whole, whenever the signal comes.
    print(said, end=" ")
"""


CALLS = ["fit", "gather", "diagnose", "simulate", "plan", "save", "verify", "array", "threads", "fleet"]
CALLS += ["executor", "table", "arrow", "predict", "health", "c99", "rust"]


@pytest.mark.parametrize("name", CALLS)
def test_ctrl_c_stops_within_a_fifth_of_a_second(name: str, tmp_path: Path, tmp_path_factory: pytest.TempPathFactory) -> None:
    if name == "arrow":
        pytest.importorskip("pyarrow")
    aside = tmp_path_factory.mktemp("aside")
    words = [sys.executable, "-c", INTERRUPTED, name, "0.1 0.35", str(aside)]
    done = subprocess.run(words, capture_output=True, text=True, cwd=tmp_path, check=False)
    assert done.returncode == 0 and done.stderr == "", done.stderr
    early, late = done.stdout.split()
    assert "ended" not in (early, late), "too quick to be interrupted"
    assert float(early) < 0.2 and float(late) < 0.2, done.stdout
    assert os.listdir(tmp_path) == []
    # Of a fleet, rows that are whole stay in its store.
    assert all(json.loads(row.read_bytes()) for row in aside.glob("rows/**/*.json"))
    assert not [path for path in aside.rglob("*") if path.name.startswith(".") or path.suffix == ".tmp"]


def test_calls_do_not_leak(pole: sesc.Robot) -> None:
    resource = pytest.importorskip("resource")
    model = pole.on("foot")
    log = sesc.simulate(model, 12, noise=1e-4)
    columns = dict(log.columns() or {})
    part, wide = sesc.gather(pole, log), np.zeros((4000, 1))

    def fails(call: Any) -> bool:
        with pytest.raises((sesc.SescError, ValueError)):
            call()
        return True

    calls: dict[str, Any] = {
        "fit": lambda: sesc.fit(pole, log),
        "functions": lambda: (model.com(wide), model.com_jacobian([0.1]), model.com(wide[::2])),
        "robots": lambda: (sesc.Robot(pole.urdf).on("foot").com([0.1]), pole._repr_html_()),
        "logs": lambda: sesc.Log({**columns, "hip": columns["hip"].copy()}, support="foot"),
        "parts": lambda: sesc.Part.from_bytes(bytes(part)),
        "pickles": lambda: pickle.loads(pickle.dumps(model)).com([0.1]),
        "errors": lambda: (fails(lambda: model.com([1.0, 2.0])), fails(lambda: pole.on("fot"))),
    }

    def peak(call: Any, times: int) -> int:
        for _ in range(times):
            call()
        return int(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss)

    for name, call in calls.items():
        before = peak(call, 50)
        assert peak(call, 1000) - before < 4096, name  # kB


def ticks(call: Any, seconds: float = 0.1) -> int:
    """How often another thread gets the lock, which nobody is made to give away, while calls follow each other."""
    seen, over = [0], threading.Event()

    def count() -> None:
        while not over.is_set():
            time.sleep(1e-4)
            seen[0] += 1

    usual = sys.getswitchinterval()
    counter = threading.Thread(target=count)
    # Before the other thread asks for the first time: it waits as long as it was told then.
    sys.setswitchinterval(60.0)
    counter.start()
    try:
        before, end = seen[0], time.perf_counter() + seconds
        while time.perf_counter() < end:
            call()
        return seen[0] - before
    finally:
        sys.setswitchinterval(usual)
        over.set()
        counter.join()


@pytest.mark.skipif(not getattr(sys, "_is_gil_enabled", lambda: True)(), reason="this Python has no lock")
@pytest.mark.parametrize("name", ["com", "com_jacobian", "gravity_moments", "cop", "cop_rows", "com_rows", "full_rows"])
def test_the_lock_is_free_in_calls_of_microseconds(name: str, model: sesc.Model) -> None:
    """Nobody is made to give the lock away meanwhile: another thread goes on where a call does."""
    call = getattr(model, name)

    def others(q: Any) -> int:
        # Where numpy makes a large array, it frees the lock itself.
        out = call(q)
        return ticks(lambda: call(q, out=out))

    # One posture is shorter than to give the lock away and get it back; 64 take some ten microseconds.
    assert others(np.zeros(20)) == 0
    assert others(np.zeros((64, 20))) > 5


def test_the_command_comes_along(tmp_path: Path) -> None:
    program = Path(sys.executable).with_name("sesc")

    def run(*words: str) -> subprocess.CompletedProcess[str]:
        return subprocess.run(words, capture_output=True, text=True, cwd=tmp_path, check=False)

    for words in ([str(program)], [sys.executable, "-m", "sesc"]):
        version = run(*words, "--version")
        assert version.returncode == 0 and version.stdout.startswith("sesc "), version.stderr
        (tmp_path / "op2.urdf").write_text(sesc.OP2_URDF)
        assert run(*words, "inspect", "op2.urdf", "--support", "r_sole").returncode == 0
        bad = run(*words, "inspect", "none.urdf", "--support", "r_sole", "--json")
        assert bad.returncode == 2 and '"error"' in bad.stdout and "none.urdf" in bad.stderr
    tested = run(sys.executable, "-m", "sesc.selftest")
    assert tested.returncode == 0 and tested.stdout.count("ok") == 3, tested.stdout + tested.stderr
