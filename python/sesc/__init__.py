"""Centre of mass by the statically equivalent serial chain.

Fast functions of any URDF's centre of mass, parameters identified from posture logs, and the
names of effects that a simulation misses. Arrays in and out are numpy's, in SI units and in
the support frame.

    >>> robot = sesc.Robot(urdf)
    >>> model = robot.on("foot")
    >>> model.com([0.0]).tolist()
    [0.1, 0.0, 1.0]
"""

from typing import TYPE_CHECKING, Any

from ._checks import Comparison, Effect, Verification, compare, effects, verify
from ._diagnose import Diagnosis, Quantity, Step, diagnose
from ._errors import (
    ArgumentError,
    ArgumentTypeError,
    FitError,
    InternalError,
    LogError,
    ModelFileError,
    PartError,
    PlanError,
    PriorError,
    SescError,
    SupportError,
    UrdfError,
)
from ._fit import CorrectedUrdf, Fit, Parameter, fit
from ._found import Finding
from ._log import Log
from ._model import Model, Robot
from ._part import Part, gather
from ._postures import Plan, Postures, plan, predict, simulate
from ._sesc import OP2_URDF, __version__

if TYPE_CHECKING:
    from . import fleet

__all__ = [
    "ArgumentError",
    "ArgumentTypeError",
    "Comparison",
    "CorrectedUrdf",
    "Diagnosis",
    "Effect",
    "Finding",
    "Fit",
    "FitError",
    "InternalError",
    "Log",
    "LogError",
    "Model",
    "ModelFileError",
    "OP2_URDF",
    "Parameter",
    "Part",
    "PartError",
    "Plan",
    "PlanError",
    "Postures",
    "PriorError",
    "Quantity",
    "Robot",
    "SescError",
    "Step",
    "SupportError",
    "UrdfError",
    "Verification",
    "__version__",
    "compare",
    "diagnose",
    "effects",
    "fit",
    "fleet",
    "gather",
    "plan",
    "predict",
    "simulate",
    "verify",
]


def __dir__() -> list[str]:
    return sorted(__all__)


def __getattr__(name: str) -> Any:
    # Executors and their like are loaded when a fleet is.
    if name == "fleet":
        from importlib import import_module

        return import_module("sesc.fleet")
    raise AttributeError(f"module 'sesc' has no attribute {name!r}")
