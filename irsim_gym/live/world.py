"""The world itself: load a file, step it, look at it, change it."""

from __future__ import annotations

import sys
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from types import TracebackType
from typing import Any, Literal, Self

import numpy as np

from irsim_gym.engine import compile
from irsim_gym.engine.checks import find_blocked_starts
from irsim_gym.engine.given import LEVELS
from irsim_gym.errors import UnknownNameError
from irsim_gym.live import moves
from irsim_gym.live.actions import Actions, Reference, pair_actions
from irsim_gym.live.arguments import read_arguments
from irsim_gym.live.camera import Camera
from irsim_gym.live.drawing import Drawing
from irsim_gym.live.filmed import Filmed
from irsim_gym.live.goals import Goals
from irsim_gym.live.roster import Roster
from irsim_gym.live.track import Track
from irsim_gym.scenario import load_scenario, notes
from irsim_gym.scenario.parameters import given_as_keywords

ScenarioSource = str | Path | Mapping[str, Any]


class World(Filmed):
    """One world of a scenario, run by hand as IR-SIM's users know it.

    It is a batch of one of the same simulator that learners use, so a step, a collision or a scan is the same here.
    IR-SIM's names work; the error for one that does not says what to use. ``help`` lists them all. Where IR-SIM has
    columns, arrays are flat here, or columns too with ``columns=True``. ``draw`` draws over it.

    In a window (``render_mode="human"``) keys do: r reset, n next level, l reload, space pause and resume, F5 pause and
    then one step each, esc quit, x switch between keyboard and auto, v save a figure, y stop and resume drawing. With
    ``control_mode: keyboard`` they drive a robot: w and s ahead and back, a and d turn (an omnidirectional robot:
    sideways), q and e turn an ``omni_angular`` robot and for others change the greatest speed, as shift+z and shift+c
    do; z and c change the greatest turn rate; alt and a digit choose the robot. The wheel zooms about the cursor, the
    middle button shows all.

    Args:
        scenario: A shipped name such as ``cluttered_room``, an id, the path of a YAML file, or the same as plain data.
            By default the YAML file beside the running script that is named as the script is.
        seed: Which level is drawn first; the one that ``irsim_gym.make`` begins with ``reset(seed=seed)``.
        render_mode: None or ``"rgb_array"``: ``render`` returns pictures. ``"human"``: it shows them in a window too.
        record: Keep a frame of the start and of each sample, for ``save_animation`` and its like.
        save_ani: IR-SIM's way: as ``record``, and ``end`` writes the film.
        strict: A key of the file that nobody reads is an error; False: it is ignored, with an ``IgnoredKeyWarning``.
        columns: Give away states, velocities, goals and their like as IR-SIM does, as columns ``(n, 1)``, and corners
            as ``(2, n)``. Without it they are flat, and NumPy refuses to combine a flat one with a column.
        **others: Values for the scenario's parameters, and IR-SIM's other arguments: ``display=True`` is
            ``render_mode="human"``, ``step_mode`` replaces the file's, ``log_level`` is that of ``logger``,
            ``ani_kwargs`` are defaults of ``end``, ``world_name`` is the file; the rest may ask for what is so anyway.

    Raises:
        ScenarioError: The file cannot be used; the error lists every problem with its line.
        UnknownNameError: Nothing is shipped under the name, or registered under the id.
        UnknownKeywordError: The scenario has no such parameter.
        ValueError: Another render mode, or a negative seed.
        TypeError: The seed is no whole number, an argument means nothing here, or no file was given and none is beside
            the script.
    """

    def __init__(
        self,
        scenario: ScenarioSource | None = None,
        *,
        seed: int | None = None,
        render_mode: str | None = None,
        record: bool = False,
        save_ani: bool = False,
        strict: bool = True,
        columns: bool = False,
        **others: Any,
    ) -> None:
        self.columns, self._strict = columns, strict
        self._asked = asked = read_arguments(render_mode, others)
        named = asked.file if scenario is None else scenario
        self._source: ScenarioSource = _beside_the_script() if named is None else named
        self._film = asked.film
        self._record, self._save_at_end, self._unsaved = record or save_ani, save_ani, False
        self._seed, self._episode = _seed(0 if seed is None else seed), 0
        self._read()
        self._begin_driving(asked.render_mode, self._loaded)
        if asked.log_level is not None:
            self.logger.setLevel(asked.log_level)
        self.track, self.draw = Track(), Drawing()
        self._camera = Camera(self.simulation, self.track, self.draw)
        self._begin(self._loaded.world.status)

    def _read(self) -> None:
        with given_as_keywords():
            loaded = load_scenario(self._source, self._asked.parameters, strict=self._strict, may_pend=True)
        if self._asked.step_mode is not None:
            loaded = replace(loaded, world=replace(loaded.world, step_mode=self._asked.step_mode))
        self._loaded = loaded
        self._compile()
        simulation = self.simulation
        found = find_blocked_starts(self._loaded, simulation.parts, simulation.model, simulation.state)
        notes.warn_of_starts(self._loaded, found)

    def _compile(self) -> None:
        self.simulation = compile(self._loaded, check_starts=False)
        self.roster, self.goals = Roster(self.simulation), Goals()

    def _begin(self, status: str) -> None:
        """Draw a level and begin it."""
        self.simulation.reset(self._seed, episode=self._episode)
        self._begun(status)

    def _begun(self, status: str) -> None:
        self._paused = self._loaded.world.status == "Pause"
        self._status = "Pause" if self._paused else status
        self._camera.clear()
        self.track.begin(self.simulation)
        self._keep_frame()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._free() if error is not None else self.close()

    def done(self, mode: Literal["all", "any"] = "all") -> bool:
        """Return whether all robots, or any, have arrived or are held in place by a collision.

        A world without robots is never done. One that a person quit (``quit_flag``) always is.

        Raises:
            ValueError: Another mode.
        """
        if mode not in ("all", "any"):
            raise ValueError(f"mode must be 'all' or 'any', got {mode!r}")
        state, robots = self.simulation.state, moves.robots(self.simulation)
        over = state.arrived[0, robots] | state.stopped[0, robots]
        return self.quit_flag or (bool(len(over)) and bool(over.all() if mode == "all" else over.any()))

    def step(self, action: Actions | None = None, action_id: Reference | Sequence[Reference] | None = None) -> None:
        """Advance by one step; nothing happens while the world is paused.

        An action is a command in the coordinates of the body's drive [m/s, rad/s] and overrides what the body would
        do by itself, in this step alone; keys that drive (``control_mode``) override both. Limits, stopping at
        collisions and all else hold as ever; a body that never moves ignores it.

        Args:
            action: None, one action, a list of actions, or a mapping from names to actions. A None among them leaves
                the body to itself.
            action_id: Whom they are for: a number, a name, or a list of them. One action goes to the first body by
                default; a list of actions goes to the bodies from the given one on, or to the list.

        Raises:
            ValueError: There is no such body, an action has a wrong length, or there are more actions than bodies: an
                action that reaches nobody is a mistake, and in a loop a warning is easily missed. Or ``step_mode`` is
                ``external``.
        """
        if not self._may_step():
            return
        rows = (
            {} if action is None else pair_actions(action, action_id, self._index_of, len(self.simulation.parts.names))
        )
        if rows and self.simulation.parts.external:
            raise ValueError("step_mode is external: set_state moves the bodies, actions have no effect")
        if not self._has_told:
            self._tell_of_unknown_groups()
        bodies, commands = moves.commands(self.simulation, {**rows, **self._keys()})
        self._camera.leave()
        if len(bodies):
            self.simulation.step(commands, bodies)
        else:
            self.simulation.step()
        self._status = self._told(moves.status_of(self.simulation))
        self.track.note(self.simulation)
        self._keep_frame()

    def _index_of(self, reference: Reference) -> int:
        try:
            return self.roster.index(reference)
        except UnknownNameError as error:
            raise ValueError(str(error)) from None

    def refresh(self) -> None:
        """Bring outlines, flags, scans and status up to date after bodies were moved by hand, without a step."""
        self.simulation.refresh()
        self._status = self._with_driver(moves.status_of(self.simulation))

    def reset(self, random: bool = False) -> None:
        """Begin again.

        Args:
            random: False for the same level with the bodies that are here now: the same actions give the same run,
                noise included, and what was set without ``init`` is forgotten. True for the next draw of the level,
                with the file's bodies.
        """
        self._camera.leave()
        if not random:
            self.goals.bring_back(self.simulation)
            self.simulation.reset_to_start()
            self._begun("Reset")
            return
        self._episode += 1
        self._compile()
        self._camera.look_at(self.simulation)
        self._begin("Reset")

    def reload(self, world_name: ScenarioSource | None = None) -> None:
        """Read the file again, or another one, and begin its first level.

        Args:
            world_name: The other file, which is reloaded from then on.

        Raises:
            ScenarioError: The file cannot be used; then the world stays as it is.
        """
        self._camera.leave()
        before = self._source
        self._source = before if world_name is None else world_name
        try:
            self._read()
        except Exception:
            self._source = before
            raise
        self._episode = 0
        self._take_control_mode(self._loaded)
        self._camera.look_at(self.simulation)
        self._begin("Reload")

    def set_random_seed(self, seed: int, reload: bool = False) -> None:
        """Draw from another stream from now on; the next ``reset(random=True)`` begins with its first level.

        Args:
            seed: Which one.
            reload: Read the file again and begin that level at once.

        Raises:
            TypeError: The seed is no whole number.
            ValueError: It is negative.
        """
        self._seed, self._episode = _seed(seed), -1
        self.simulation.state.random[:] = self.simulation.streams(self._seed)
        if reload:
            self.reload()


def load(
    scenario: ScenarioSource | None = None,
    *,
    seed: int | None = None,
    render_mode: str | None = None,
    record: bool = False,
    save_ani: bool = False,
    strict: bool = True,
    columns: bool = False,
    **others: Any,
) -> World:
    """Load a scenario to run it by hand, without learning; arguments and errors are those of ``World``."""
    return World(
        scenario,
        seed=seed,
        render_mode=render_mode,
        record=record,
        save_ani=save_ani,
        strict=strict,
        columns=columns,
        **others,
    )


def _beside_the_script() -> Path:
    """Return the YAML file that is named as the running script is."""
    script = Path(sys.argv[0] or "script.py")
    for file in (script.with_suffix(".yaml"), Path(script.stem + ".yaml")):
        if file.is_file():
            return file
    raise TypeError(f"no file was given, and no {script.stem}.yaml stands beside the script: load('my_world.yaml')")


def _seed(seed: Any) -> int:
    """Return the level that a seed stands for, as in environments."""
    if isinstance(seed, bool) or not isinstance(seed, int | np.integer):
        raise TypeError(f"a seed is a whole number, got {seed!r}")
    if seed < 0:
        raise ValueError(f"a seed is 0 or more, got {seed}")
    return int(seed) % LEVELS
