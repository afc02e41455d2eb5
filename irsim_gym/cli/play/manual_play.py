"""The command ``irsim-gym play``: a person drives the robot of a task in a window, in real time."""

import sys
import time
from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from irsim_gym.base.arraytypes import Bytes
from irsim_gym.base.errors import IrsimGymError, UnknownNameError, suggestion
from irsim_gym.base.families import BEHAVIORS
from irsim_gym.envs.gymnasium.registration import make
from irsim_gym.envs.gymnasium.single import WorldEnv
from irsim_gym.envs.parts.pictures import make_renderer, world_status
from irsim_gym.evaluation.comparison.recorder import RecordedStep, Recorder, check_demonstrations
from irsim_gym.evaluation.policies.behavior_policies import BehaviorPolicy
from irsim_gym.evaluation.policies.drive_actions import to_actions
from irsim_gym.evaluation.policies.perception import Perceives, Perception, perceived_task
from irsim_gym.evaluation.protocol.tables import write_bytes
from irsim_gym.evaluation.requests.inputs import check_inputs
from irsim_gym.evaluation.requests.interruption import StopRequest
from irsim_gym.evaluation.requests.scenario_request import ScenarioRequest
from irsim_gym.evaluation.saved_policies.policies import load_policy
from irsim_gym.rendering.controls import Driver
from irsim_gym.scenario.reading.load import load_scenario
from irsim_gym.scenario.specs.spec import Scenario
from irsim_gym.tasks import Outcome, load_task

RESULT_S = 1.2
"""Time for which the end of an episode is shown before the next level begins [s]."""
MAX_WAIT_S = 0.02
"""Longest time between two checks of the keys [s]."""
KEYS = """\
w, s     ahead, back (omni: along x)         q, e     slower, faster (omni_angular: turn)
a, d     turn (omni: along y, sideways)      z, c     turn slower, faster (with shift: ahead)
space    pause          F5   one step        r, n     this level again, the next level
x        by itself      v    picture         alt 0-9  another robot
l        file again     y    stop drawing    wheel    zoom          esc  leave
"""


@dataclass(frozen=True)
class PlaySettings:
    """Settings of a manual session.

    Attributes:
        scenario: Shipped name, environment id, or path of a scenario file.
        task: Shipped name or path of a task; None for the scenario's own.
        robot: Name or number of the driven robot; None for the learner of the task.
        level: First level.
        split: Split of the levels: ``train``, ``dev`` or ``test``.
        parameters: Values for the scenario's parameters.
        record: File for demonstrations, ``.npz``; None to record nothing.
        speed: Speed of the simulation relative to real time.
        policy: Policy that drives until the person takes over, as ``load_policy`` accepts it; None for the person.
        strict: Whether unused keys are an error; False ignores them.
    """

    scenario: str
    task: str | None = None
    robot: str | None = None
    level: int = 0
    split: str = "train"
    parameters: Mapping[str, Any] = field(default_factory=dict)
    record: Path | None = None
    speed: float = 1.0
    policy: str | None = None
    strict: bool = True


@dataclass(frozen=True)
class PlayResult:
    """Result of a manual session.

    Attributes:
        outcomes: Number of episodes by outcome.
        record: File of the demonstrations; None if nothing was recorded.
        recorded: Number of episodes in this file.
    """

    outcomes: Counter[str]
    record: Path | None
    recorded: int


class Player:
    """A manual session: plays level after level until the person quits.

    The keys are those of ``irsim_gym.load``: r restarts the level and discards its recording, n begins the next level,
    l reloads the file, x switches to the policy, or without one to the robot's behaviour, and back, alt and a digit
    select another robot.

    Raises:
        NoWindowError: If there is no display, or no working GUI toolkit.
        IrsimGymError: If the scenario or the task is invalid, there is no such robot or policy, the policy cannot drive
            the robot, or the file for demonstrations belongs to another environment.
    """

    def __init__(self, settings: PlaySettings) -> None:
        self._settings, self._level, self._one = settings, settings.level, np.zeros(1, np.int64)
        self._policy = None if settings.policy is None else load_policy(settings.policy)
        self._read(settings.robot)
        self._recorder = None if settings.record is None else Recorder(self._env, settings.record)
        self._outcomes: Counter[str] = Counter()
        self._paused = self._single_step = self._quit = self._hidden = False
        self._auto = self._policy
        self._begin()
        keys, title = self._scenario.gui.keyboard, f"{self._scenario.label} - irsim-gym play"
        first = self._picture(keys.key_lv_max, keys.key_ang_max)
        self._driver = Driver(title, first, self._scenario.gui, lambda: self._renderer.seen())
        self._driver.keyboard.key_id = self._number

    def _read(self, robot: str | None) -> None:
        """Read the scenario and its task, and make the environment; None for ``robot`` means the task's learner."""
        name, parameters = self._settings.scenario, self._settings.parameters
        strict = self._settings.strict
        self._scenario = load_scenario(name, parameters, strict=strict)
        task: Any = self._settings.task if robot is None else _task_of(self._scenario, self._settings.task, robot)
        if isinstance(self._policy, Perceives) and self._policy.perception is not None:
            task = perceived(self._scenario, task, self._policy.perception)
        env: Any = make(name, task=task, disable_env_checker=True, strict=strict, **parameters)
        assert isinstance(env.unwrapped, WorldEnv)
        self._env, self._worlds = env, env.unwrapped.worlds
        self._body = int(self._worlds.simulation.agents[0])
        self._number = self._scenario.robots.index(self._body)
        self._renderer = make_renderer(self._worlds.simulation)

    def _begin(self) -> None:
        """Begin the current level."""
        self._seen, _ = self._env.reset(options={"split": self._settings.split, "level": self._level})
        if self._auto is not None:
            self._auto.begin(self._worlds.episodes, self._one, np.array([self._level]))
        if self._recorder is not None:
            self._recorder.discard()
            self._recorder.begin(self._seen, self._level)
        self._return, self._steps, self._ended_at = 0.0, 0, 0.0
        self._renderer.clear()

    def run(self) -> PlayResult:
        """Play until the person quits with esc, Ctrl-C or by closing the window; then write the demonstrations."""
        # Ctrl-C ends the loop between two steps: an exception amid Tk's drawing would be another one there.
        try:
            with StopRequest().listening() as stop:
                while not self._quit and stop.signal is None:
                    due = time.perf_counter() + self._scenario.world.step_time / self._settings.speed
                    self._one_step()
                    self._show()
                    self._pause_until(due)
        finally:
            self.close()
        recorded = 0 if self._recorder is None else self._recorder.n_episodes
        return PlayResult(self._outcomes, None if self._recorder is None else self._recorder.path, recorded)

    def close(self) -> None:
        """Write the demonstrations, and close the window and the environment."""
        if self._recorder is not None:
            self._recorder.save()
        self._driver.close()
        self._env.close()

    def _one_step(self) -> None:
        if self._ended_at:
            if time.perf_counter() - self._ended_at > RESULT_S:
                self._next()
        elif self._single_step or not self._paused:
            self._single_step = False
            self._step()

    def _step(self) -> None:
        episodes = self._worlds.episodes
        if self._auto is None:
            command = self._driver.keyboard.command(self._scenario.bodies[self._body].kinematics.command_names)
            action = to_actions(episodes, self._one, command[None, None])[0, 0]
        else:
            action = self._auto.act(episodes, self._one)[0]
        self._seen, reward, terminated, truncated, info = self._env.step(action)
        self._return, self._steps = self._return + float(reward), self._steps + 1
        if self._recorder is not None:
            ends = terminated, truncated, info["outcome"]
            self._recorder.add(RecordedStep(action, self._seen, float(reward), *ends, by_hand=self._auto is None))
        if terminated or truncated:
            self._ended_at = time.perf_counter()
            self._outcomes[Outcome(info["outcome"]).name.lower()] += 1

    def _pause_until(self, due: float) -> None:
        """Wait for the next step, and handle keys in the meantime."""
        while True:
            turns = len(self._scenario.bodies[self._body].kinematics.command_names) == 3
            self._driver.execute(self._handle, self._renderer.look_at, drives=True, turns=turns)
            if self._driver.keyboard.key_id != self._number:
                self._choose(self._driver.keyboard.key_id)
            left = due - time.perf_counter()
            if left <= 0.0 or self._quit:
                return
            self._driver.wait(min(left, MAX_WAIT_S))

    def _handle(self, command: str) -> None:
        """Execute the command of a key, one of the values of ``rendering.controls.keyboard.COMMANDS``."""
        match command:
            case "reset":
                self._begin()
            case "next":
                self._next()
            case "reload":
                self._reload()
            case "pause":
                self._paused, self._single_step = not self._paused, False
            case "step":
                self._single_step, self._paused = self._paused, True
            case "switch":
                self._switch()
            case "figure":
                self._save_figure()
            case "display":
                self._hidden = not self._hidden
            case "quit":
                self._quit = True

    def _next(self) -> None:
        self._level += 1
        self._begin()

    def _switch(self) -> None:
        """Switch between the person and the policy, without one the robot's own behaviour."""
        if self._auto is not None:
            self._auto = None
            return
        policy = BehaviorPolicy(self._behavior()) if self._policy is None else self._policy
        try:
            policy.begin(self._worlds.episodes, self._one, np.array([self._level]))
        except IrsimGymError as error:
            self._say(str(error))
        else:
            self._auto = policy

    def _behavior(self) -> str:
        """Return the name of the robot's own behaviour, dash if it has none."""
        behavior = self._scenario.bodies[self._body].behavior
        return "dash" if behavior is None else BEHAVIORS.name_of(type(behavior))

    def _reload(self) -> None:
        if self._recorder is not None:
            self._say("the file is not reloaded while demonstrations are recorded")
            return
        self._level = self._settings.level
        self._change(self._scenario.bodies[self._body].name)

    def _choose(self, number: int) -> None:
        """Select another robot, and restart the level."""
        robots = self._scenario.robots
        self._driver.keyboard.key_id = self._number
        if self._recorder is not None:
            self._say("only one robot is recorded: choose it with --robot")
        elif number >= len(robots):
            self._say(f"there is no robot {number}: there are {len(robots)}, from 0 on")
        else:
            self._change(self._scenario.bodies[robots[number]].name)
            self._driver.keyboard.key_id = self._number

    def _change(self, robot: str) -> None:
        """Reload the file with the given driven robot, and restart the level."""
        before = self._env
        try:
            self._read(robot)
        except IrsimGymError as error:
            self._say(str(error).splitlines()[0])
            return
        before.close()
        self._auto = None
        self._begin()

    def _save_figure(self) -> None:
        import io

        from matplotlib.image import imsave

        path = Path(f"{self._scenario.name}_{self._level}_{self._steps:04d}.png")
        content = io.BytesIO()
        imsave(content, self._renderer.frame(0, world_status(self._worlds.episodes, 0)), format="png")
        write_bytes(path, content.getvalue())
        self._say(f"saved {path}")

    def _show(self) -> None:
        keys = self._driver.keyboard
        picture = self._driver.picture if self._hidden else self._picture(keys.key_lv_max, keys.key_ang_max)
        self._driver.show(picture)

    def _picture(self, speed: float, turn_rate: float) -> Bytes:
        """Return the contents of the window, with the maximum speeds of the keys [m/s, rad/s]."""
        if self._ended_at:
            return self._renderer.frame(0, world_status(self._worlds.episodes, 0))
        policy = Path(self._settings.policy or self._behavior()).name
        driver = policy if self._auto is not None else self._speeds(speed, turn_rate)
        told = [self._scenario.bodies[self._body].name, driver, f"level {self._level}", f"return {self._return:.2f}"]
        if self._recorder is not None:
            told.append(f"recorded {self._recorder.n_episodes}")
        return self._renderer.frame(0, ", ".join([*told, *(["paused"] if self._paused else [])]))

    def _speeds(self, speed: float, turn_rate: float) -> str:
        """Return the maximum speeds of the keys as text, limited to those of the robot."""
        names = self._scenario.bodies[self._body].kinematics.command_names
        fastest = self._worlds.simulation.model.velocity_max[0, self._body]
        linear, turning = f"{min(speed, fastest[0]):g} m/s", min(turn_rate, fastest[len(names) - 1])
        return linear if names == ("x", "y") else f"{linear}, {turning:g} rad/s"

    def _say(self, message: str) -> None:
        """Print a message to the terminal, below the keys."""
        print(message, file=sys.stderr)


def play(settings: PlaySettings) -> PlayResult:
    """Open a window, and let a person drive; see ``Player``."""
    record = settings.record
    request = ScenarioRequest(settings.scenario, settings.task, parameters=settings.parameters, strict=settings.strict)
    outputs = [] if record is None else [partial(check_demonstrations, record)]
    policies = [] if settings.policy is None else [settings.policy]
    check_inputs(request, *outputs, policies=policies, split=settings.split)
    player = Player(settings)
    print(KEYS, file=sys.stderr)
    return player.run()


def perceived(scenario: Scenario, task: Any, perception: Perception) -> dict[str, Any]:
    """Return a task with the observations and the action of a policy.

    Raises:
        UnfitPerceptionError: If the robot lacks what they need.
    """
    perceived_task(scenario, load_task(scenario, task), perception)
    return {**_mapping_of(scenario, task), **perception.to_plain()}


def _task_of(scenario: Scenario, task: str | None, robot: str) -> dict[str, Any]:
    """Return the task with a robot, given by name or number, as its agent.

    Raises:
        UnknownNameError: If there is no such robot.
    """
    names = [scenario.bodies[b].name for b in scenario.robots]
    if robot.isdecimal() and int(robot) < len(names):
        robot = names[int(robot)]
    if robot not in names:
        listed = ", ".join(names) or "none"
        raise UnknownNameError(f"no robot '{robot}'{suggestion(robot, names)}; there are: {listed}")
    return {**_mapping_of(scenario, task), "agents": robot}


def _mapping_of(scenario: Scenario, task: Any) -> Mapping[str, Any]:
    """Return a task as a mapping; it is given by name, as a mapping, or as None for the scenario's own."""
    return scenario.task if task is None else {"name": task} if isinstance(task, str) else task
