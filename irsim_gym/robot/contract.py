"""The contract of an exported policy: what it needs, what it was tested with, and how its graph is run."""

import hashlib
from pathlib import Path
from typing import Any, Literal

from pydantic import BaseModel, ConfigDict, Field

from irsim_gym.base.outside_files import json_object, reading
from irsim_gym.evaluation.saved_policies.cards import CardCurve
from irsim_gym.tasks.terms.term import Needs

FORMAT = 1
Span = tuple[float, float]


class _Fixed(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid")


class Hashes(_Fixed):
    """SHA-256 of what belongs together; policy.onnx holds those of the scenario and the policy, too."""

    scenario: str = Field(description="Scenario and task, without image files.")
    policy: str = Field(description="The file that was exported.")
    onnx: str = Field(description="policy.onnx.")
    check: str = Field(description="check.npz.")


class ScenarioForm(_Fixed):
    """What the policy was played in."""

    name: str = Field(description="Shipped name, or path of a file.")
    task: str | None = Field(description="Shipped name or path; None for the scenario's own.")
    team: bool
    parameters: dict[str, Any]


class Tested(_Fixed):
    """Scanners that the policy was played with: least and greatest values. The driver refuses others."""

    beams: tuple[int, int]
    range_max: Span = Field(description="[m]")
    field_of_view: Span = Field(description="Angle between the first and the last beam [rad].")


class Scanner(_Fixed):
    """The scan that the graph takes; the driver maps others to it by their angles."""

    beams: int
    first: float = Field(description="Angle of the first beam in the frame of the scanner, 0 ahead [rad].")
    step: float = Field(description="Angle from one beam to the next, counter-clockwise [rad]; 0 for a single one.")
    range_min: float = Field(description="[m]")
    range_max: float = Field(description="[m]")
    mount: tuple[float, float, float] = Field(description="Pose of the scanner on the robot [m, m, rad].")
    mounts: tuple[Span, Span, Span] = Field(description="Mounts that it was played with; the driver was told them.")
    no_return: Literal["inf", "zero"] = Field(description="What the scanner reports where nothing is in range.")
    tested: Tested


class SeenMapForm(_Fixed):
    """The map that perceive.py keeps of the robot's own scans, for policies with a way on it."""

    origin: tuple[float, float] = Field(
        description="Its lower left corner, in the frame of the goal [m]; robot and goals have to lie on it."
    )
    cell: float = Field(description="Side of a cell [m].")
    rows: int
    columns: int
    inflation: float = Field(description="Distance of the robot's origin that ways keep from obstacles [m].")
    every: int = Field(description="Commands from one scan that is added to the next.")
    frees: bool = Field(description="Beams free what they pass, as where others moved in the training.")


class BodiesForm(_Fixed):
    """The other bodies, which the robot's own tracker gives: discs in the frame of the odometry."""

    source: Literal["tracked"]
    most: int = Field(description="Greatest number that it was tested with.")
    moving: bool = Field(description="Bodies that stay where they are do not belong to them.")


class RobotLimits(_Fixed):
    """The robot of the training."""

    drive: str = Field(description="Kind of kinematics.")
    steers: bool = Field(description="The last component of a command is a steering angle.")
    wheelbase: float | None = Field(description="Distance of the axles of a car [m].")
    radius: float = Field(description="Of the disc around the robot's origin that encloses it [m].")
    radii: Span = Field(description="Least and greatest radius that the policy was played with [m].")
    low: tuple[float, ...] = Field(description="Least command, in the units of the output.")
    high: tuple[float, ...] = Field(description="Greatest command.")
    acceleration: tuple[float | None, ...] = Field(description="Greatest change of each per second; None without one.")


class GoalForm(_Fixed):
    """The goal."""

    frame: Literal["odom", "map"] = Field(description="'map' where the policy knows its place in a fixed frame.")
    heading: bool = Field(description="The heading counts.")
    tolerance: float = Field(description="Where the robot has arrived [m, with 1 rad like 1 m where heading counts].")


class TensorForm(_Fixed):
    """An input of the graph."""

    shape: tuple[int | str, ...]
    dtype: str


class StateForm(_Fixed):
    """A state: the graph takes NAME, and returns NAME_next."""

    shape: tuple[int, ...] = Field(description="Without the axis of the batch.")
    dtype: str
    start: Any = Field(description="Before the first step; one number (also 'nan', 'inf') or numbers of that shape.")


class Stops(_Fixed):
    """When the driver stops."""

    scan_age: float = Field(description="[s]")
    odometry_age: float = Field(description="[s]")
    bodies_age: float | None = Field(description="[s]; None for policies that need no other bodies.")
    lost_beams: float = Field(description="A share.")


class ShieldForm(_Fixed):
    """The shield of shield.py, which the driver applies to each command; results are those without it."""

    name: Literal["stop_in_time"]
    margin: float = Field(description="Distance that is kept, where the robot is not nearer yet [m].")
    latency: float = Field(description="Time from measuring until a new command acts [s].")
    lag: float = Field(description="Time constant with which the drive follows its commands [s].")


class Results(_Fixed):
    """Success on levels of the simulator, with its 95 % Wilson interval."""

    success: float
    low: float
    high: float
    levels: int
    split: str


class RobotContract(_Fixed):
    """The content of contract.json."""

    format: Literal[1] = 1
    policy: str
    irsim_gym: str = Field(description="Version that wrote the file.")
    hashes: Hashes
    scenario: ScenarioForm
    needs: Needs
    scan: Scanner | None
    seen_map: SeenMapForm | None = Field(description="None for policies without one: these are one file.")
    bodies: BodiesForm | None = Field(description="None for policies that need no other bodies.")
    robot: RobotLimits
    period: float = Field(description="Time from one command to the next [s].")
    periods: Span = Field(description="Least and greatest period that the policy was played with [s].")
    predict: float = Field(description="Time from measuring until a new command acts, which the graph bridges [s].")
    goal: GoalForm
    inputs: dict[str, TensorForm]
    states: dict[str, StateForm]
    outputs: dict[str, tuple[str, ...]]
    stop: Stops
    results: Results
    shield: ShieldForm | None = Field(None, description="None for drivers without one.")
    robustness: dict[str, CardCurve] = Field(
        default={}, description="Strengths of disturbances by factor of `irsim-gym robustness`, without `predict`."
    )


def read_export(folder: Path) -> tuple[RobotContract, bytes]:
    """Return the contract of an export, and the content of its policy.onnx.

    Raises:
        UnreadableFileError: A file is missing or broken, or they do not belong together.
    """
    from irsim_gym.robot.drive import Driver

    file, model, check = (folder / name for name in ("contract.json", "policy.onnx", "check.npz"))
    with reading(file, "contract of an exported policy"):
        contract = RobotContract.model_validate(json_object(file))
    with reading(model, f"graph of {file}"):
        Driver(file)  # compares hashes
    with reading(check, f"check of {file}"):
        if hashlib.sha256(check.read_bytes()).hexdigest() != contract.hashes.check:
            raise ValueError("its hash is not that in the contract")
    return contract, model.read_bytes()
