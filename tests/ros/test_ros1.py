"""A package of ROS 1, built by catkin and launched, drives a simulated robot: the same outcomes as in the package."""

from __future__ import annotations

import shlex
import subprocess
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import pytest
from ros_processes import Robot, end, running

from irsim_gym.evaluation.policies.perception import Perceived
from irsim_gym.evaluation.protocol.protocol import evaluate
from irsim_gym.evaluation.requests.scenario_request import ScenarioRequest
from irsim_gym.evaluation.saved_policies.policies import SavedPolicy
from irsim_gym.evaluation.saved_policies.shelf import read_policy, shelf_file
from irsim_gym.robot.export import export_for_robot
from irsim_gym.robot.inputs import measured, scanner_of
from irsim_gym.tasks import Outcome

PERIOD, N_LEVELS = 0.1, 100
FREE = [np.inf] * 180


@dataclass
class Node:
    """What a launched node writes."""

    log: Path
    process: subprocess.Popen[str] = field(repr=False)

    def text(self) -> str:
        return self.log.read_text(encoding="utf-8")


@pytest.fixture(scope="module")
def install(variables: dict[str, str], tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return where catkin has installed an exported package."""
    folder = tmp_path_factory.mktemp("package")
    export_for_robot("cluttered_room", folder / "source", levels=5, node="ros1")
    source, build, place = (shlex.quote(str(folder / name)) for name in ("source", "build", "install"))
    make = f"cmake -S {source} -B {build} -DCMAKE_INSTALL_PREFIX={place} && make -C {build} install"
    log = folder / "log"
    with log.open("w") as file, running(make, variables, stdout=file, stderr=file) as process:
        assert process.wait(300.0) == 0, log.read_text()
    return folder / "install"


@contextmanager
def launched(install: Path, variables: dict[str, str], robot: Robot, *arguments: str) -> Iterator[Node]:
    """Launch the node, and wait until it has connected."""
    launch = f"roslaunch cluttered_room_driver drive.launch goal:=goal_pose {shlex.join(arguments)}"
    log = install.with_name(f"log{''.join(arguments)}")
    with (
        log.open("w") as file,
        running(f". {install / 'setup.sh'} && exec {launch}", variables, stdout=file, stderr=file) as process,
    ):
        assert robot.ask("wait", 60.0), log.read_text()
        yield Node(log, process)


@pytest.fixture(scope="module")
def node(install: Path, variables: dict[str, str], robot: Robot) -> Iterator[Node]:
    with launched(install, variables, robot, "on_scan:=true") as node:
        yield node


@dataclass
class Course:
    """Drives levels of ``cluttered_room`` one after another, in lock-step with the node.

    The time of all levels goes on. Between two of them the goal is where the robot is, so that it stands.
    """

    robot: Robot
    now: float = 10.0
    pause: float = 0.0

    def __post_init__(self) -> None:
        self.played = ScenarioRequest("cluttered_room").episodes(1)
        scanner = scanner_of(self.played)
        assert scanner is not None
        angles = scanner[2]
        self.angles = float(angles[0]), float(angles[1] - angles[0])

    def tick(self) -> list[float]:
        """Return what the node commands for what the robot measures."""
        values = measured(self.played)
        self.now += PERIOD
        place = [*values["pose"][0].tolist(), *values["velocity"][0].tolist()]
        ranges = np.where(values["ranges"][0] >= 6.0, np.inf, values["ranges"][0]).tolist()
        command: list[float] = self.robot.ask("step", self.now, ranges, *self.angles, place, self.pause)
        assert command, "the node is silent"
        return command

    def stand(self) -> None:
        """Stop the robot by a goal where it is."""
        self.robot.ask("goal", *measured(self.played)["pose"][0, :2].tolist(), "odom")
        self.robot.ask("pause", 0.05)
        assert self.tick() == [0.0, 0.0]

    def drive(self, level: int, frame: str = "odom", goal: tuple[float, float] | None = None) -> str:
        """Return the outcome of a level; the goal is in the frame of the odometry unless another one is told."""
        self.played.begin(np.zeros(1, np.int64), np.array([level]), "test")
        self.robot.ask("goal", *(goal or measured(self.played)["goal"][0, :2].tolist()), frame)
        self.robot.ask("pause", 0.05)
        while self.outcome() == Outcome.RUNNING:
            v, w = self.tick()
            self.played.step(np.array([[[2.0 * v - 1.0, w / 1.5]]]))
        ended = self.outcome()
        self.stand()
        return Outcome(ended).name.lower()

    def outcome(self) -> int:
        return int(self.played.view.infos["outcome"][0, 0])


def standing(robot: Robot, now: float = 10.0, pause: float = 0.0) -> Course:
    """Return a course whose node is at work: its first commands may be those of one that waits."""
    course = Course(robot, now, pause)
    course.played.begin(np.zeros(1, np.int64), np.zeros(1, np.int64), "test")
    for _ in range(3):
        course.stand()
        robot.ask("pause", 0.2)
    return course


@pytest.fixture(scope="module")
def course(robot: Robot, node: Node) -> Course:
    return standing(robot)


def test_the_node_drives_100_levels_to_the_same_outcomes(course: Course) -> None:
    policy = read_policy(shelf_file("cluttered_room"))
    played = Perceived(ScenarioRequest("cluttered_room").episodes(20)).of(SavedPolicy(policy))
    expected = [row.outcome for row in evaluate(SavedPolicy(policy), played, N_LEVELS, "test")]
    assert [course.drive(level) for level in range(N_LEVELS)] == expected


def test_a_goal_of_the_map_is_moved_to_the_odometry_by_tf(course: Course) -> None:
    """The odometry lies at (3, -2), turned by 1 rad, in the map."""
    course.robot.ask("lies", "map", "odom", 3.0, -2.0, 1.0)
    course.played.begin(np.zeros(1, np.int64), np.array([3]), "test")
    x, y = measured(course.played)["goal"][0, :2]
    there = complex(3.0, -2.0) + complex(x, y) * np.exp(1j)
    assert course.drive(3, "map", (there.real, there.imag)) == course.drive(3)


def test_the_node_stops_within_three_periods_and_says_why_once(course: Course, node: Node) -> None:
    course.played.begin(np.zeros(1, np.int64), np.array([5]), "test")
    course.robot.ask("goal", *measured(course.played)["goal"][0, :2].tolist(), "odom")
    course.robot.ask("pause", 0.05)
    assert course.tick() != [0.0, 0.0]
    sent = []
    for _ in range(12):
        course.now += 0.5 * PERIOD
        sent.append(course.robot.ask("silent", course.now))
    commands = [command for some in sent for command in some]
    assert commands[-1] == [0.0, 0.0]
    stopped = next(k for k, some in enumerate(sent) if [0.0, 0.0] in some)
    assert (stopped + 1) * 0.5 * PERIOD <= 4.0 * PERIOD + 1e-9  # the first missing scan was due after one
    assert node.text().count("stands: the scan is") == 1
    stands = [course.tick() == [0.0, 0.0] for _ in range(5)]  # until three good scans have come
    assert stands[:2] == [True, True]
    assert not stands[-1]


def test_the_node_stands_when_the_clock_jumps_back_and_goes_on(course: Course, node: Node) -> None:
    course.played.begin(np.zeros(1, np.int64), np.array([6]), "test")
    course.robot.ask("goal", *measured(course.played)["goal"][0, :2].tolist(), "odom")
    course.robot.ask("pause", 0.05)
    assert course.tick() != [0.0, 0.0]
    course.now -= 5.0
    stands = [course.tick() == [0.0, 0.0] for _ in range(6)]
    assert stands[:2] == [True, True]
    assert not stands[-1]
    assert node.text().count("stands: the clock jumps back") == 1


def test_a_goal_of_an_unknown_frame_is_named(course: Course, node: Node) -> None:
    course.robot.ask("goal", 1.0, 1.0, "moon")
    course.robot.ask("pause", 0.05)
    assert course.tick() == [0.0, 0.0]
    assert "stands: the goal is in frame 'moon', the odometry in 'odom'" in node.text()


def test_the_robot_stands_when_the_node_ends(course: Course, node: Node) -> None:
    course.played.begin(np.zeros(1, np.int64), np.array([7]), "test")
    course.robot.ask("goal", *measured(course.played)["goal"][0, :2].tolist(), "odom")
    course.robot.ask("pause", 0.05)
    assert course.tick() != [0.0, 0.0]
    end(node.process)
    time.sleep(0.2)
    assert course.robot.ask("heard") == [[0.0, 0.0]]


def test_a_timer_drives_as_well(install: Path, variables: dict[str, str], robot: Robot) -> None:
    """The clock moves when scan and odometry have had time to arrive."""
    with launched(install, variables, robot, "period:=0.09"):
        course = standing(robot, 5000.0, pause=0.02)
        assert [course.drive(level) for level in range(5)] == ["success"] * 5


def test_the_manifest_of_ros_2_is_one_for_the_tools_of_ros(variables: dict[str, str], tmp_path: Path) -> None:
    export_for_robot("cluttered_room", tmp_path / "package", levels=1, node="ros2")
    read = "import sys; from catkin_pkg.package import parse_package as p; found = p(sys.argv[1])"
    code = f"{read}; print(found.name, found.get_build_type())"
    command = shlex.join(["python3", "-c", code, str(tmp_path / "package")])
    with running(command, variables, stdout=subprocess.PIPE) as process:
        said = process.communicate(timeout=60.0)[0]
    assert said == "cluttered_room_driver ament_python\n"
