"""The unit of work: the logs of one robot and day to one row. No engine, no state."""

from __future__ import annotations

import json
from typing import Any, NamedTuple

from .._diagnose import diagnose
from .._errors import SescError
from .._fit import fit
from .._log import Log
from .._robot import Robot
from .._sesc import __version__

__all__ = ["COLUMNS", "Job", "analyse", "content_hash"]

#: Columns behind those of ``by``, in their order.
COLUMNS = (
    "urdf_hash",
    "support",
    "postures",
    "independent",
    "noise_floor",
    "held_out_rmse",
    "verdict",
    "sentence",
    "effects",
    "health",
    "params",
    "std",
    "inputs",
    "error",
    "version",
)


class Job(NamedTuple):
    """What one call works on; it is pickled to wherever it runs.

    Attributes:
        robot: the robot.
        paths: the logs of one group, each content once, in the order of their hashes.
        inputs: hashes of their contents.
        options: keywords of the fit and the diagnosis.
    """

    robot: Robot
    paths: tuple[str, ...]
    inputs: tuple[str, ...]
    options: dict[str, Any]


def analyse(job: Job) -> dict[str, Any]:
    """The row of a group: parameters, noise, verdict, effects, health; an error is a row too."""
    row: dict[str, Any] = dict.fromkeys(COLUMNS)
    row |= {"urdf_hash": job.robot.hash, "inputs": list(job.inputs), "version": __version__}
    names = [f"log {k + 1}" for k in range(len(job.paths))]
    try:
        logs = []
        for name, path in zip(names, job.paths, strict=True):
            logs.append(_named(path, name))
        found = diagnose(job.robot, logs[0], then=logs[1:], **job.options)
        row |= {"support": found.to_dict()["support"], "verdict": found.verdict, "sentence": found.sentence}
        steps = [
            {
                "effect": step.effect,
                "target": step.target,
                "parameters": {name: q._asdict() for name, q in step.parameters.items()},
            }
            for step in found.steps
        ]
        row["effects"] = json.dumps(steps)
        row["health"] = json.dumps([finding._asdict() for finding in found.health])
        if found.verdict != "unusable":
            options = {key: value for key, value in job.options.items() if key in ("support", "angles", "noise")}
            known = fit(job.robot, logs, **options)
            row |= {
                "postures": known.postures,
                "independent": known.to_dict()["samples"]["independent"],
                "noise_floor": known.noise_floor,
                "held_out_rmse": known.held_out_rmse,
                "params": [p.value for p in known.parameters.values()],
                "std": [p.std for p in known.parameters.values()],
            }
    except (SescError, OSError) as error:
        # Without the path: a row is what the content is.
        text = str(error)
        for name, path in zip(names, job.paths, strict=True):
            text = text.replace(path, name)
        row["error"] = f"{type(error).__name__}: {text}"
    return row


def _named(path: str, name: str) -> Log:
    """The log at ``path``, with its own sidecar."""
    log = Log(path)
    with open(path, "rb") as file:
        settings = log.settings
        settings.pop("robot", None)
        return Log(file.read(), name=name, **settings)


def content_hash(path: str) -> str:
    """Hash of a file and of the sidecar beside it."""
    import hashlib

    total = hashlib.sha256()
    with open(path, "rb") as file:
        while chunk := file.read(1 << 20):
            total.update(chunk)
    settings = Log(path).settings
    settings.pop("robot", None)
    total.update(json.dumps(settings, sort_keys=True).encode())
    return total.hexdigest()[:32]
