import os
from collections.abc import Callable
from typing import Any, TypeAlias, final

from typing_extensions import Self, disjoint_base

from ._arrays import Float64

__all__ = [
    "FLEET_COLUMNS",
    "FitReport",
    "FleetFound",
    "Log",
    "Model",
    "OP2_URDF",
    "Part",
    "Robot",
    "Unusable",
    "__version__",
    "arrow_columns",
    "c_files",
    "command",
    "compare_models",
    "correct_fit",
    "correct_urdf",
    "diagnose_log",
    "draw_postures",
    "draw_robot",
    "effects_about",
    "fit_logs",
    "fleet_groups",
    "fleet_work",
    "plan_postures",
    "predict_log",
    "rust_files",
    "simulate_log",
    "verify_model",
    "write_bytes",
    "write_postures",
    "write_text",
]

__version__: str
FLEET_COLUMNS: tuple[str, ...]
OP2_URDF: str

_Bytes: TypeAlias = bytes

@disjoint_base
class Robot:
    """A robot, and how right angles of its URDF are read."""
    def __new__(
        cls, file: str | os.PathLike[str], text: str | None, snap: bool, xacro: bool = False
    ) -> Self: ...
    @property
    def _expanded(self) -> bool: ...
    @property
    def name(self) -> str:
        """The name in the URDF."""
    @property
    def file(self) -> str:
        """The file that messages name."""
    @property
    def hash(self) -> str:
        """Hash of the description, in hexadecimal: model files and parts carry it."""
    @property
    def urdf(self) -> str:
        """The text of the URDF."""
    @property
    def snap(self) -> bool:
        """Whether decimals of right angles are made exact."""
    @property
    def links(self) -> list[str]:
        """Names of the links: any of them can be the support."""
    @property
    def root(self) -> str:
        """The link that no joint carries."""
    @property
    def joints(self) -> list[str]:
        """Names of the independent joints, in the order of the document."""

@disjoint_base
class Model:
    """A robot on its support link, with CAD's parameters or identified ones."""
    def __new__(
        cls, robot: Robot, support: str, file: str | os.PathLike[str] | None = None, text: str | None = None
    ) -> Self: ...
    @property
    def model_file(self) -> str | None: ...
    @property
    def support(self) -> str:
        """The link on the ground."""
    @property
    def joints(self) -> list[str]:
        """Names of the independent joints, in the order of ``q``."""
    @property
    def dof(self) -> int:
        """How many independent joints there are."""
    @property
    def params(self) -> Float64:
        """The base parameters, m (of a prismatic joint: a mass fraction), shape (p,): identified
        ones where the model has them, else CAD's."""
    @property
    def param_names(self) -> list[str]:
        """Their names: body and axis."""
    @property
    def total_mass(self) -> float:
        """Mass of the robot with its loads, kg."""
    @property
    def bounds(self) -> list[list[float]]: ...
    @property
    def unobservable(self) -> list[str]:
        """What no CoP of a flat foot can tell, a sentence each."""
    @property
    def notes(self) -> list[str]:
        """What is to be known of the robot, a sentence each."""
    def inspection(self) -> str:
        """What `sesc inspect --json` says."""
    def next_steps(self) -> str:
        """What it says to do next."""
    def com(self, q: Any, *, out: Float64 | None = None, threads: int | None = None) -> Float64:
        """Centre of mass in the support frame, m: ``(dof,)`` gives ``(3,)``, ``(n, dof)`` gives
        ``(n, 3)``."""
    def com_jacobian(self, q: Any, *, out: Float64 | None = None, threads: int | None = None) -> Float64:
        """Its derivative with respect to joint positions, m/rad (prismatic: m/m): ``(3, dof)`` or
        ``(n, 3, dof)``."""
    def com_velocity(
        self, q: Any, qd: Any, *, out: Float64 | None = None, threads: int | None = None
    ) -> Float64:
        """Velocity of the centre of mass, m/s, of joints at `qd` (rad/s, m/s): positions and
        velocities of one shape give ``(3,)`` or ``(n, 3)``."""
    def gravity_moments(self, q: Any, *, out: Float64 | None = None, threads: int | None = None) -> Float64:
        """The moment that gravity exerts about each joint, per kg of total mass times g, m, −∂z/∂q of
        the CoM: ``(dof,)`` or ``(n, dof)``. A motor that holds the posture applies the opposite,
        ``-model.total_mass * 9.80665`` times it in Nm, which is Pinocchio's
        ``computeGeneralizedGravity``."""
    def cop(self, q: Any, *, out: Float64 | None = None, threads: int | None = None) -> Float64:
        """Reading of the centre of pressure that a static posture gives, m, with the effects of the
        model: ``(2,)`` or ``(n, 2)``."""
    def cop_jacobian(self, q: Any, *, out: Float64 | None = None, threads: int | None = None) -> Float64:
        """How that reading moves with what encoders read, m/rad (prismatic: m/m): ``(2, dof)`` or
        ``(n, 2, dof)``."""
    def cop_rows(self, q: Any, *, out: Float64 | None = None, threads: int | None = None) -> Float64:
        """Rows of the CoP in the parameters, ``cop = cop_rows @ params`` without effects: ``(2,
        p)`` or ``(n, 2, p)``."""
    def com_rows(self, q: Any, *, out: Float64 | None = None, threads: int | None = None) -> Float64:
        """Rows of the CoM in the parameters, ``com = com_rows @ params``: ``(3, p)`` or ``(n, 3,
        p)``."""
    def full_rows(self, q: Any, *, out: Float64 | None = None, threads: int | None = None) -> Float64:
        """Rows of the CoM in all parameters of the chain, ``[B_0 B_1 …]``, three columns for the
        `r_i` of each body in its own frame (and one for each prismatic joint): ``(3, f)`` or
        ``(n, 3, f)``."""
    def correct_cop(self, reading: Any, *, out: Float64 | None = None, threads: int | None = None) -> Float64:
        """The CoP that a reading was made of, m: takes back the sensor's effects of the model
        (offset, gain, rotation); the reading itself where it has none. ``(2,)`` gives ``(2,)``,
        ``(n, 2)`` gives ``(n, 2)``; a data frame or dict is asked for ``cop_x`` and ``cop_y``."""
    def zmp(
        self, q: Any, qd: Any, qdd: Any, *, out: Float64 | None = None, threads: int | None = None
    ) -> Float64:
        """Zero-moment point of a robot that moves, m: positions, velocities (rad/s, m/s) and
        accelerations of one shape give ``(2,)`` or ``(n, 2)``."""

_Show: TypeAlias = Callable[[str, int, int | None], object] | None

@disjoint_base
class Log:
    """A posture log that can be read as often as needed."""
    @staticmethod
    def file(path: str, settings: str | None = None) -> Log:
        """The log at `path`."""
    @staticmethod
    def bytes(name: str, data: _Bytes, settings: str | None = None) -> Log:
        """The bytes of a log file of any format."""
    @staticmethod
    def table(name: str, columns: list[tuple[str, Any]], settings: str | None = None) -> Log:
        """Columns by name; the log keeps copies of its own."""
    @property
    def name(self) -> str: ...
    @property
    def size(self) -> tuple[int, int] | None: ...
    @property
    def sidecar_warnings(self) -> list[str]: ...
    @property
    def settings(self) -> str: ...
    def content(self) -> _Bytes | None:
        """The bytes of a file that was given by them."""
    def health(self, robot: Robot | None) -> list[tuple[str, str, str]]:
        """What is wrong with the data themselves: kind, target, sentence."""
    def columns(self) -> dict[str, Any] | None:
        """The columns of a table, by name; none of a file."""
    def write(self, path: str) -> str:
        """Write a simulated log with its sidecar, whose path is given back."""

@disjoint_base
class Part:
    """Sums of one log or of many, with the robot they are about."""
    @staticmethod
    def gather(robot: Robot, logs: list[Log], options: dict[str, Any], show: _Show = None) -> Part:
        """What logs contribute, gathered with the keywords of a fit."""
    @staticmethod
    def parse(data: _Bytes) -> Part:
        """The part that these bytes hold."""
    def to_bytes(self) -> _Bytes:
        """The bytes of a file of it."""
    def merged(self, other: Part) -> Part:
        """This part and another, together."""
    def about(self) -> str:
        """Robot, logs and options, and what is wrong with them, as JSON."""

@final
class FitReport:
    """What a fit found, with what is needed to make files of it."""
    @property
    def unusable(self) -> str | None:
        """What is wrong with data that cannot be used, as sentences."""
    @property
    def robot(self) -> tuple[str, str, bool]: ...
    def state(self) -> dict[str, Any]:
        """All that Python keeps of data that can be used."""
    def corrected(self, total_mass: float | None = None) -> str:
        """The corrected URDF."""
    def masses(self) -> list[float] | None:
        """Masses and first moments of the corrected URDF, as parts of the whole; none where no
        masses give the parameters."""
    def page(self) -> str:
        """The page of `sesc fit --report`."""

@final
class Unusable:
    """A column that holds neither numbers nor texts: it is in nobody's way until it is used."""

    def __new__(cls, rows: int, what: str) -> Self: ...

def arrow_columns(capsule: Any) -> list[tuple[str, Any]]: ...
def c_files(model: Model, folder: str, options: dict[str, Any]) -> list[str]: ...
def command(words: list[str]) -> int: ...
def compare_models(
    before: tuple[str | None, str, str], after: tuple[str | None, str, str], robot: Robot | None = None
) -> tuple[str, str, str]: ...
def correct_fit(
    robot: Robot,
    support: str,
    params: list[float],
    masses: list[float] | None,
    prior: str,
    total_mass: float | None = None,
) -> str: ...
def correct_urdf(
    robot: Robot, model_file: str, prior: str, total_mass: float | None = None
) -> tuple[str, list[str]]: ...
def diagnose_log(
    robot: Robot,
    log: Log,
    then: list[Log],
    healthy: list[Log],
    options: dict[str, Any],
    show: _Show = None,
) -> dict[str, Any]: ...
def draw_postures(robot: Robot, model: Model, q: Float64) -> list[str]: ...
def draw_robot(robot: Robot, model: Model) -> list[str]: ...
def effects_about() -> str: ...
def fit_logs(
    robot: Robot | None, logs: list[Log], parts: list[Part], options: dict[str, Any], show: _Show = None
) -> FitReport: ...

@final
class FleetFound:
    """All groups of a fleet, and what they say together."""
    @staticmethod
    def run(
        robot: Robot,
        options: str,
        groups: list[str],
        store: str | None = None,
        show: _Show = None,
        threads: int | None = None,
    ) -> FleetFound:
        """Work on all groups with the threads of this machine."""
    @staticmethod
    def gathered(robot: Robot, options: str, done: list[str]) -> FleetFound:
        """Put together what groups came to, in any order."""
    @staticmethod
    def unpacked(robot: Robot, options: str, packed: str) -> FleetFound:
        """The fleet of what `packed` gave."""
    def packed(self) -> str:
        """Everything that was found, for `unpacked`."""
    def rows(self) -> str:
        """The rows as JSON, a list of lists of values in the order of `FLEET_COLUMNS`."""
    def json(self) -> str:
        """What `sesc fleet --json` prints."""
    def text(self) -> str:
        """What `sesc fleet` prints."""
    def write(self, path: str) -> None:
        """Write the table, as Parquet or CSV."""
    def pages(self, file: str, robots: int | None = None) -> tuple[str, str, list[tuple[str, str]]]:
        """The page of the fleet for a file of this name, the folder beside it, and names and pages
        of robots for that: of so many robots, 2000 unless given, those to look at first before
        others."""
    def population(self) -> str:
        """The file of what is known of the next robot."""

def fleet_groups(
    data: list[str], table: list[tuple[str, dict[str, str]]], by: list[str]
) -> list[str]: ...
def fleet_work(
    robot: Robot, options: str, group: str, store: str | None = None, check: Callable[[], None] | None = None
) -> str: ...
def plan_postures(
    robot: Robot, model: Model, data: Log | None, options: dict[str, Any], show: _Show = None
) -> tuple[tuple[Any, Float64], dict[str, str]]: ...
def predict_log(
    robot: Robot,
    support: str | None,
    model: Model,
    log: Log,
    degrees: bool | None = None,
    moves: bool = True,
    show: _Show = None,
) -> tuple[Any, Float64, Float64]: ...
def rust_files(
    model: Model, folder: str, name: str | None, functions: list[str] | None
) -> list[str]: ...
def simulate_log(model: Model, options: dict[str, Any], show: _Show = None) -> Log: ...
def verify_model(
    robot: Robot, model: Model, samples: int | None, seed: int, show: _Show = None
) -> tuple[str, list[tuple[str, str]]]: ...
def write_bytes(path: str, data: _Bytes) -> None: ...
def write_postures(
    model: Model,
    q: Float64,
    poses: list[int],
    path: str,
    experiment: str | None,
    other_foot: str | None,
) -> str: ...
def write_text(path: str, text: str) -> None: ...
