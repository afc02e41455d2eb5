"""What a render mode asks for: pictures, lists of pictures, or a window."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import gymnasium
import numpy as np

from irsim_gym.base.arraytypes import Bytes, Flags, Ints
from irsim_gym.base.errors import IrsimGymError
from irsim_gym.scenario import Scenario
from irsim_gym.scenario.specs.plot_spec import trailing
from irsim_gym.simulator.engine import Simulation
from irsim_gym.simulator.readings.trails import Trails
from irsim_gym.tasks import Episodes, Outcome

if TYPE_CHECKING:
    from irsim_gym.rendering import Renderer
    from irsim_gym.rendering.windows.picture import PictureList
    from irsim_gym.rendering.windows.screen import Screen

RENDER_MODES = ("human", "rgb_array", "rgb_array_list")
MOST_SHOWN = 16
"""How many worlds a window shows at most: the first ones."""
MOST_SECONDS = 1.0
"""The longest time that ``show`` keeps a picture on the screen [s]."""
ROOM = (1600, 1200)
"""Width and height of a picture of several worlds at most [pixel]."""

Size = tuple[int, int] | None


class Pictures:
    """Draws worlds when their render mode asks for it. It only reads them.

    ``"rgb_array"``: a picture of the present moment on request. ``"rgb_array_list"``: a picture is kept at
    the beginning of an episode, at each sample (every ``sample_time``) and at its end; asking takes them all, a
    beginning drops those of the episode before. ``"human"``: at the same moments a window shows the worlds, the first
    sixteen of them side by side, not faster than in real time.

    Args:
        scenario: What is simulated.
        mode: One of these or None.

    Raises:
        ValueError: Another mode.

    Attributes:
        trails: Where bodies have been whose paths are drawn; None without a mode, as nothing is drawn then.
    """

    def __init__(self, scenario: Scenario, episodes: Episodes, mode: str | None) -> None:
        if mode not in (None, *RENDER_MODES):
            raise ValueError(f"render_mode must be None or one of {list(RENDER_MODES)}, got {mode!r}")
        self.mode = mode
        self._scenario, self._episodes = scenario, episodes
        self._n_worlds = n_worlds = episodes.n_worlds
        self._every = np.arange(n_worlds)
        self.trails: Trails | None = None
        if mode is not None:
            followed = trailing(scenario.bodies, episodes.simulation.agents.tolist())
            self.trails = Trails(np.array(followed, np.int64), n_worlds)
        self._renderers: dict[Size, Renderer] = {}
        self._kept: list[PictureList] | None = None
        self._screen: Screen | None = None
        self._panels: list[Bytes | None] = [None] * min(n_worlds, MOST_SHOWN)
        self._stale: Flags = np.zeros(n_worlds, np.bool_)
        self._over: Flags = np.zeros(n_worlds, np.bool_)
        self._begun: Flags = np.zeros(n_worlds, np.bool_)
        self._seconds = 0.0

    @property
    def fps(self) -> float:
        """Pictures per second in real time: one each step, or one each sample where that is when they are made."""
        world = self._scenario.world
        return 1.0 / (world.step_time * (world.steps_per_sample if self.mode in ("human", "rgb_array_list") else 1))

    def note_beginning(self, worlds: Ints, *, at_once: bool = True) -> None:
        """Take in that episodes begin; ``at_once=False`` leaves the window alone until the next step or ``refresh``."""
        if self.trails is None:
            return
        self.trails.clear(worlds)
        self._note_trails(worlds)
        self._over[worlds], self._begun[worlds] = False, True
        if self.mode == "rgb_array_list":
            for w in worlds.tolist():
                self._list(w).clear()
            self._keep(worlds)
        self._stale[worlds] = True
        if self.mode == "human" and at_once:
            self._seconds = self._seconds or self._scenario.world.step_time
            self.refresh()

    def note_step(self, worlds: Ints | None) -> None:
        """Take in that worlds, or all, have made a step."""
        if self.trails is None:
            return
        self._note_trails(worlds)
        self._seconds += self._scenario.world.step_time
        if self.mode == "rgb_array":
            return
        chosen = np.arange(self._n_worlds) if worlds is None else worlds
        state, world = self._episodes.simulation.state, self._scenario.world
        over = (self._episodes.view.infos["outcome"][chosen] != Outcome.RUNNING).all(axis=1)
        due = (state.step[chosen] % world.steps_per_sample == 0) | (over & ~self._over[chosen])
        self._over[chosen] = over
        if self.mode == "rgb_array_list":
            self._keep(chosen[due])
            return
        self._stale[chosen[due]] = True
        self.refresh()

    def _keep(self, worlds: Ints) -> None:
        """Add a picture to the lists of these worlds, each in memory of its own."""
        for w, picture in zip(worlds.tolist(), self.several(worlds.tolist()), strict=True):
            self._list(w).append(picture.copy() if len(worlds) > 1 else picture)

    def note_respawn(self, agents: Flags) -> None:
        """Take in that agents ``(n_worlds, n_agents)`` have come to another place."""
        if self.trails is not None:
            simulation = self._episodes.simulation
            moved = np.zeros(simulation.model.present.shape, np.bool_)
            moved[:, simulation.agents] = agents
            self.trails.forget(moved)
            self._note_trails(None)

    def _note_trails(self, worlds: Ints | None) -> None:
        assert self.trails is not None
        state = self._episodes.simulation.state
        if worlds is None:
            self.trails.record(self._every, state.step, state.pose)
        else:
            self.trails.record(worlds, state.step[worlds], state.pose[worlds])

    def of(self, w: int) -> Bytes | PictureList | None:
        """Return what ``render`` returns for one world in this mode; a returned list is cleared."""
        if self.mode == "rgb_array":
            return self.now(w)
        if self.mode == "rgb_array_list":
            taken = self._list(w)
            assert self._kept is not None
            self._kept[w] = type(taken)(fps=self.fps)
            return taken
        if self._screen is not None:
            self._screen.refresh()
        return None

    def each(self) -> tuple[Any, ...] | None:
        """Return what ``render`` of a batch returns in this mode: ``of`` each world, or None in a window."""
        if self.mode == "human":
            self.of(0)
            return None
        if self.mode == "rgb_array":
            return self.several(range(self._n_worlds))
        return tuple(self.of(w) for w in range(self._n_worlds))

    def now(self, w: int) -> Bytes:
        """Return a fresh picture ``(height, width, 3)`` of a world as it is."""
        from irsim_gym.rendering.windows.picture import NotebookPicture

        return self._renderer(None).frame(w, world_status(self._episodes, w)).view(NotebookPicture)

    def several(self, worlds: Sequence[int], size: Size = None) -> tuple[Bytes, ...]:
        """Return fresh pictures of several worlds as they are, of a width and height [pixel] or of their own."""
        from irsim_gym.rendering.windows.picture import NotebookPicture

        statuses = [world_status(self._episodes, w) for w in worlds]
        return tuple(frame.view(NotebookPicture) for frame in self._renderer(size).frames(worlds, statuses))

    def tiled(
        self, columns: int | None = None, worlds: Sequence[int] | None = None, room: tuple[int, int] = ROOM
    ) -> Bytes:
        """Return one fresh picture of several worlds side by side, see ``ManyWorlds.tiled``."""
        from irsim_gym.rendering.looks.tiles import grid
        from irsim_gym.rendering.windows.picture import NotebookPicture

        self._refuse_without_mode()
        chosen = list(range(self._n_worlds)) if worlds is None else [int(w) for w in worlds]
        if not chosen or not all(0 <= w < self._n_worlds for w in chosen):
            raise ValueError(f"worlds must be numbers from 0 to {self._n_worlds - 1}, at least one, got {chosen}")
        if columns is not None and columns < 1:
            raise ValueError(f"columns must be at least 1, got {columns}")
        in_a_row, size = self._tile(len(chosen), columns, room)
        return grid(self.several(chosen, size), in_a_row).view(NotebookPicture)

    def show(self) -> None:
        """Show all worlds as they are in a window, whatever the mode; the picture before is given a second at most."""
        self._refuse_without_mode()
        self._stale[:] = self._begun
        self._seconds = min(self._seconds, MOST_SECONDS)
        self.refresh()

    def refresh(self) -> None:
        """Draw worlds that have changed since they were shown, and show them."""
        from irsim_gym.rendering.looks.tiles import SCREEN, grid
        from irsim_gym.rendering.windows.screen import Screen

        if self._screen is None:
            self._screen = Screen(self._title())
        changed = np.flatnonzero(self._stale[: len(self._panels)]).tolist()
        if not self._screen.is_wanted:
            self._panels = [None] * len(self._panels)
        elif changed:
            columns, size = self._tile(len(self._panels), None, SCREEN)
            for w, panel in zip(changed, self.several(changed, size), strict=True):
                self._panels[w] = panel
            panels = [np.full_like(panel, 255) if one is None else one for one in self._panels]
            self._screen.show(panel if len(panels) == 1 else grid(panels, columns), self._seconds)
            self._seconds = 0.0
        self._stale[:] = False

    def close(self) -> None:
        """Close the window and free the renderers. May be called twice; kept pictures stay."""
        for renderer in self._renderers.values():
            renderer.close()
        self._renderers.clear()
        if self._screen is not None:
            self._screen.close()
        self._panels, self._stale = [None] * len(self._panels), self._begun.copy()

    def _refuse_without_mode(self) -> None:
        if self.mode is None:
            raise IrsimGymError("rendering needs a render mode: use render_mode='rgb_array'")

    def _title(self) -> str:
        shown = len(self._panels)
        which = "" if self._n_worlds == 1 else f": {shown} of {self._n_worlds} worlds"
        return f"{self._scenario.name}{which}"

    def _tile(self, count: int, columns: int | None, room: tuple[int, int]) -> tuple[int, Size]:
        """Return columns and size of a picture of several worlds side by side; None for the size of one picture."""
        from irsim_gym.rendering.looks.tiles import fitting

        layout = self._renderer(None).layout
        natural = layout.width, layout.height
        if count == 1:
            return 1, None
        best, size = fitting(count, natural, columns, room)
        return best, None if size == natural else size

    def _list(self, w: int) -> PictureList:
        if self._kept is None:
            from irsim_gym.rendering.windows.picture import PictureList

            self._kept = [PictureList(fps=self.fps) for _ in range(self._n_worlds)]
        return self._kept[w]

    def _renderer(self, size: Size) -> Renderer:
        if size not in self._renderers:
            if len(self._renderers) > 2:
                self._renderers.pop(list(self._renderers)[-1]).close()
            simulation = self._episodes.simulation
            shown: dict[str, Any] = {"size": size, "trails": self.trails, "share": simulation.shards.run}
            self._renderers[size] = make_renderer(simulation, **shown)
        return self._renderers[size]

    def __getstate__(self) -> dict[str, Any]:
        panels: list[Bytes | None] = [None] * len(self._panels)
        return {**self.__dict__, "_renderers": {}, "_panels": panels, "_stale": self._begun.copy()}


def make_renderer(simulation: Simulation, **options: Any) -> Renderer:
    """Return a renderer of a simulation's worlds that marks its learners; ``options`` are those of ``Renderer``."""
    from irsim_gym.rendering import Renderer

    parts = simulation.scenario, simulation.model, simulation.state, simulation.sensors
    options_here: dict[str, Any] = {"learners": simulation.agents.tolist(), "explored": simulation.explored}
    return Renderer(*parts, **(options_here | {"marks": simulation.marks} | options))


def render_warning(mode: str | None) -> None:
    """Warn of ``render`` without a render mode."""
    if mode is None:
        gymnasium.logger.warn("render() was called but no render_mode was given: use render_mode='rgb_array'")


def world_status(episodes: Episodes, w: int) -> str:
    """Return how the episode of a world stands: running, the outcome of all its agents, or how many arrived."""
    outcomes = episodes.view.infos["outcome"][w].tolist()
    if Outcome.RUNNING in outcomes or len(set(outcomes)) == 1:
        return Outcome.RUNNING.name.lower() if Outcome.RUNNING in outcomes else Outcome(outcomes[0]).name.lower()
    return f"{outcomes.count(Outcome.SUCCESS)} of {len(outcomes)} arrived"
