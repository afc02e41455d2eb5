"""The world itself: load a file, step it, look at it, change it."""

from __future__ import annotations

import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from types import TracebackType
from typing import Any, Literal, Self

import numpy as np

from irsim_gym.engine import compile
from irsim_gym.errors import UnknownNameError
from irsim_gym.live import hints, moves
from irsim_gym.live.actions import Actions, Reference, pair_actions
from irsim_gym.live.camera import Camera, target
from irsim_gym.live.driven import ENDING_S, Driven
from irsim_gym.live.goals import Goals
from irsim_gym.live.roster import Roster
from irsim_gym.live.track import Track
from irsim_gym.scenario import Scenario, load_scenario

ScenarioSource = str | Path | Mapping[str, Any]


class World(Driven):
    """One world of a scenario, run by hand as IR-SIM's users know it.

    It is a batch of one of the same simulator that learners use, so a step, a collision or a scan is the same here.
    IR-SIM's names work; the error for one that does not says what to use. ``help`` lists them all. Where IR-SIM has
    columns, arrays are flat here.

    In a window (``render_mode="human"``) keys do: r reset, n next level, l reload, space pause and resume, F5 pause and
    then one step each, esc quit, x switch between keyboard and auto, v save a figure, y stop and resume drawing. With
    ``control_mode: keyboard`` they drive a robot: w and s ahead and back, a and d turn (an omnidirectional robot:
    sideways), q and e turn an ``omni_angular`` robot and for others change the greatest speed, as shift+z and shift+c
    do; z and c change the greatest turn rate; alt and a digit choose the robot. The wheel zooms about the cursor, the
    middle button shows all.

    Args:
        scenario: A shipped name such as ``cluttered_room``, the path of a YAML file, or the same as plain data. By
            default the YAML file beside the running script that is named as the script is.
        seed: Which level is drawn first; the one that ``irsim_gym.make`` begins with ``reset(seed=seed)``.
        render_mode: None or ``"rgb_array"``: ``render`` returns pictures. ``"human"``: it shows them in a window too.
        render_backend: Who draws frames: ``"matplotlib"`` or ``"raster"``; figures in files are matplotlib's.
        record: Keep a frame of the start and of each sample, for ``save_animation`` and its like.
        save_ani: IR-SIM's way: as ``record``, and ``end`` writes the film.
        **others: Values for the scenario's parameters, and IR-SIM's other arguments where they ask for what is so
            anyway; ``display=True`` is ``render_mode="human"``.

    Raises:
        ScenarioError: The file cannot be used; the error lists every problem with its line.
        UnknownNameError: Nothing is shipped under the name, or the scenario has no such parameter; another backend.
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
        render_backend: str = "matplotlib",
        record: bool = False,
        save_ani: bool = False,
        **others: Any,
    ) -> None:
        mode, self._parameters = hints.check_arguments(render_mode, others)
        self._source = _beside_the_script() if scenario is None else scenario
        self._record, self._save_at_end, self._unsaved = record or save_ani, save_ani, False
        self._seed, self._episode = _seed(0 if seed is None else seed), 0
        self._read()
        self._begin_driving(mode, self._loaded)
        self.track = Track()
        self._camera = Camera(self.simulation, self.track, render_backend)
        self._begin(self._loaded.world.status)

    def _read(self) -> None:
        self._loaded = load_scenario(self._source, self._parameters, may_pend=True)
        self._compile()

    def _compile(self) -> None:
        self.simulation = compile(self._loaded)
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
        self.close()

    def close(self) -> None:
        """Close the window and free the renderer. May be called twice; the world can still be used."""
        self._close_window()
        self._camera.close()

    def end(self, ending_time: float = ENDING_S, ani_name: str | Path | None = None) -> Path | None:
        """Write the film if the world was loaded with ``save_ani`` or a name is given, and close.

        Args:
            ending_time: How long a window stays open before [s]; a person may close it sooner.
            ani_name: The film's file, as for ``save_animation``.

        Returns:
            The film's path, None when none was written.

        Raises:
            ValueError: A film is asked for, but no frames were kept.
        """
        asked = ani_name is not None or (self._save_at_end and self._unsaved)
        film = self.save_animation(ani_name) if asked else None
        self._linger(ending_time)
        self.close()
        return film

    @property
    def scenario(self) -> Scenario:
        """What the file says, with the bodies that are here now."""
        return self.simulation.scenario

    @property
    def name(self) -> str:
        """Its name."""
        return self.scenario.name

    @property
    def time(self) -> float:
        """Elapsed time [s]: steps times ``step_time``, not rounded."""
        return float(self.simulation.state.time[0])

    @property
    def count(self) -> int:
        """Steps since the reset."""
        return int(self.simulation.state.step[0])

    @property
    def step_time(self) -> float:
        """Duration of a step [s]."""
        return self.scenario.world.step_time

    @property
    def sampling(self) -> bool:
        """The present moment is a sample: there is one every ``sample_time``, rounded to whole steps."""
        return self.count % self.scenario.world.steps_per_sample == 0

    @property
    def status(self) -> str:
        """How the world stands, as text.

        ``Arrived`` when all robots have arrived, else ``Collision`` when one collides, else ``Running``, or
        ``Running (keyboard)`` when keys drive. ``Pause`` lasts until ``resume``, ``Reset`` and ``Reload`` until the
        next step; at first it is what the file says. ``Pause (Debugging)`` after F5, ``Quit`` after esc.
        """
        return self._status

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
        bodies, commands = moves.commands(self.simulation, {**rows, **self._keys()})
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
        self._status = moves.status_of(self.simulation)

    def reset(self, random: bool = False) -> None:
        """Begin again.

        Args:
            random: False for the same level with the bodies that are here now: the same actions give the same run,
                noise included, and what was set without ``init`` is forgotten. True for the next draw of the level,
                with the file's bodies.
        """
        if not random:
            self.goals.bring_back(self.simulation)
            self.simulation.reset_to_start()
            self._begun("Reset")
            return
        self._episode += 1
        self._compile()
        self._camera.look_at(self.simulation)
        self._begin("Reset")

    def reload(self) -> None:
        """Read the file again and begin its first level."""
        self._episode = 0
        self._read()
        self._take_control_mode(self._loaded)
        self._camera.look_at(self.simulation)
        self._begin("Reload")

    def set_random_seed(self, seed: int) -> None:
        """Draw from another stream from now on; the next ``reset(random=True)`` begins with its first level.

        Raises:
            TypeError: The seed is no whole number.
            ValueError: It is negative.
        """
        self._seed, self._episode = _seed(seed), -1
        self.simulation.state.random[:] = self.simulation.streams(self._seed)

    def _shown_status(self) -> str:
        return "" if self._status == "None" else self._status

    def _is_sample(self) -> bool:
        return self.sampling

    def _keep_frame(self) -> None:
        if self._record and self.sampling:
            self._camera.keep(self._shown_status())
            self._unsaved = True

    def save_figure(self, path: str | Path | None = None) -> Path:
        """Write a picture to a file and return its path.

        Args:
            path: ``.png``, ``.pdf``, ``.svg`` and so on; without a suffix the scenario's
                ``plot.saved_figure.format`` is used, and without a path the world's name. Dots per inch are
                ``plot.saved_figure.dpi`` there, not an argument as in IR-SIM.

        Raises:
            ValueError: Another suffix.
        """
        return self._camera.save_figure(target(path, self.name), self._shown_status())

    def save_animation(self, path: str | Path | None = None, fps: float | None = None) -> Path:
        """Write the frames kept so far to a film, let go of them, and return its path.

        Args:
            path: ``.mp4`` or ``.gif``; without a suffix it becomes an mp4, and without a path the world's name is used.
            fps: Frames per second; by default as fast as the world's own time.

        Raises:
            ValueError: Another suffix, or no frames: a world keeps them when it is loaded with ``record=True``.
        """
        rate = 1.0 / (self.scenario.world.steps_per_sample * self.step_time) if fps is None else fps
        film = self._camera.save_film(target(path, self.name), rate)
        self._unsaved = False
        return film

    def save_html(self, path: str | Path | None = None) -> Path:
        """Write a page that plays all episodes since the world was loaded, in any browser; return its path.

        Args:
            path: ``.html``, also without the suffix; by default the world's name.

        Raises:
            ValueError: Another suffix, or nothing was kept: a world keeps it when it is loaded with ``record=True``.
        """
        return self._camera.save_html(target(path, self.name))

    def save_sheet(self, path: str | Path | None = None, moments: int = 12) -> Path:
        """Write one picture with moments, evenly spaced, of what ``save_animation`` writes or wrote; return its path.

        Args:
            path: ``.png`` or another picture of pixels; by default the world's name with ``-sheet``.
            moments: How many; the first and the last are among them.

        Raises:
            ValueError: Another suffix, nothing was kept, or fewer than two moments.
        """
        return self._camera.save_sheet(target(path, f"{self.name}-sheet"), moments)

    def save_strobe(self, path: str | Path | None = None) -> Path:
        """Write one picture with the ways of the robots in this episode, coloured by time; return its path.

        Args:
            path: ``.png``, ``.pdf``, ``.svg`` and so on; by default the world's name with ``-strobe``.

        Raises:
            ValueError: Another suffix, or nothing was kept.
        """
        return self._camera.save_strobe(target(path, f"{self.name}-strobe"))


def load(
    scenario: ScenarioSource | None = None,
    *,
    seed: int | None = None,
    render_mode: str | None = None,
    render_backend: str = "matplotlib",
    record: bool = False,
    save_ani: bool = False,
    **others: Any,
) -> World:
    """Load a scenario to run it by hand, without learning; arguments and errors are those of ``World``."""
    return World(
        scenario,
        seed=seed,
        render_mode=render_mode,
        render_backend=render_backend,
        record=record,
        save_ani=save_ani,
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
    """Return a seed as a plain number."""
    if isinstance(seed, bool) or not isinstance(seed, int | np.integer):
        raise TypeError(f"a seed is a whole number, got {seed!r}")
    if seed < 0:
        raise ValueError(f"a seed is 0 or more, got {seed}")
    return int(seed)
