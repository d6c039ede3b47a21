"""Hides effects in two simulators, asks sesc and its peers, and prints a table.  See README.md."""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
import time
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path

# One process is one core.
for variable in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"):
    os.environ.setdefault(variable, "1")

import methods
import numpy as np
from methods import Answer, Case
from simulate import simulate

ROOT = Path(__file__).resolve().parents[2]
#: Kinds of effects that act on the reading alone: the CoM is CAD's.
OF_SENSOR = ("sensor", "soft_ground")


def rms(values: np.ndarray) -> float:
    return float(np.sqrt((values**2).mean()))


def judged(case: Case, answer: Answer, seconds: float) -> dict[str, float]:
    """Gaps over CAD's, and whether the place is right: it alone is named."""
    cad = case.robot.com(case.fresh_q)[:, :2]
    of_sensor = str(case.truth["kind"]).startswith(OF_SENSOR)
    place = "sensor" if of_sensor else str(case.truth["place"])
    return {
        "cop": rms(answer.cop - case.fresh_cop) / rms(cad - case.fresh_cop),
        "com": np.nan if of_sensor else rms(answer.com - case.fresh_com) / rms(cad - case.fresh_com),
        "place": float(set(answer.places) == {place}),
        "seconds": seconds,
    }


def ask(folder: Path, command: Path, names: list[str]) -> tuple[Path, dict[str, dict[str, float]]]:
    case = Case.read(folder, ROOT)
    all_methods: dict[str, Callable[[Case], Answer]] = {
        "sesc diagnose": lambda case: methods.sesc(case, command, ROOT),
        "least squares (scipy)": methods.least_squares,
        "Gaussian process (scikit-learn)": methods.gaussian_process,
        "PySINDy": methods.pysindy,
        "gplearn": methods.gplearn,
    }
    found = {}
    for name, method in all_methods.items():
        if names and name not in names:
            continue
        begun = time.perf_counter()
        answer = method(case)
        found[name] = judged(case, answer, time.perf_counter() - begun)
    return folder, found


def table(cases: dict[Path, Case], found: dict[Path, dict[str, dict[str, float]]]) -> str:
    lines = ["| effects | logs | method | CoP gap | CoM gap | place | seconds |", "|---|---|---|---|---|---|---|"]
    groups: dict[str, list[Path]] = {}
    for folder, case in sorted(cases.items()):
        is_in_table = "with a form of the table" if case.truth["is_in_table"] else "with a form of no table"
        groups.setdefault(f"{case.truth['simulator']}, {is_in_table}", []).append(folder)
    groups["all"] = sorted(cases)
    for group, folders in groups.items():
        for k, name in enumerate(found[folders[0]]):
            rows = [found[folder][name] for folder in folders]
            column = {key: np.array([row[key] for row in rows]) for key in rows[0]}
            cop, com = np.median(column["cop"]), np.nanmedian(column["com"])
            place, seconds = int(column["place"].sum()), np.median(column["seconds"])
            first = f"{group} | {len(rows)}" if k == 0 else " | "
            lines.append(f"| {first} | {name} | {cop:.0%} | {com:.0%} | {place} of {len(rows)} | {seconds:.1f} |")
    return "\n".join(lines)


def check(urdf: Path, case: Case) -> None:
    """MuJoCo and the robot in numpy put the CoM at the same place."""
    from simulate import Standing

    standing = Standing(urdf, str(case.truth["support"]))
    order = [case.joints.index(name) for name in standing.names]
    ours = case.robot.com(case.q[:20])
    theirs = np.array([standing.at(q[order])[0] for q in case.q[:20]])
    if np.abs(ours - theirs).max() > 1e-9:
        sys.exit(f"MuJoCo and numpy disagree by {np.abs(ours - theirs).max():.2e} m")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--logs", type=int, default=1, help="logs of each kind and simulator")
    parser.add_argument("--seed", type=int, default=1, help="of the first log")
    parser.add_argument("--only", default="", help="kinds in whose folder this stands")
    parser.add_argument("--method", action="append", default=[], help="only this method, may be repeated")
    parser.add_argument("--jobs", type=int, default=2, help="logs at a time")
    parser.add_argument("--folder", type=Path, required=True, help="where logs are written")
    parser.add_argument("--sesc", type=Path, required=True, help="the command")
    parser.add_argument("--xtask", type=Path, required=True, help="the command that hides effects in the virtual robot")
    asked = parser.parse_args()
    folder, seed, logs = asked.folder, asked.seed, asked.logs
    subprocess.run([asked.xtask, "hidden", folder / "virtual", "--logs", str(logs), "--seed", str(seed)], check=True)
    urdf = ROOT / "robots/op2/op2.urdf"
    simulate(urdf, "r_sole", folder / "mujoco", logs, seed)
    folders = [path.parent for path in sorted(folder.glob("*/*/truth.json")) if asked.only in path.parent.name]
    cases = {folder: Case.read(folder, ROOT) for folder in folders}
    check(urdf, cases[folders[0]])
    found: dict[Path, dict[str, dict[str, float]]] = {}
    with ProcessPoolExecutor(asked.jobs) as pool:
        tasks = [pool.submit(ask, folder, asked.sesc, asked.method) for folder in folders]
        for task in tasks:
            path, row = task.result()
            found[path] = row
            gaps = ", ".join(f"{name} {one['cop']:.2f} {one['com']:.2f} {one['place']:.0f}" for name, one in row.items())
            print(f"{len(found)} of {len(folders)}  {path.parent.name}/{path.name}: {gaps}", file=sys.stderr, flush=True)
    print(table(cases, found))


if __name__ == "__main__":
    main()
