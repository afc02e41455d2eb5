"""What a batch shows of one of its worlds: names that a single environment has."""

from typing import Any, Self

import numpy as np

from irsim_gym.base.arraytypes import Flags
from irsim_gym.base.errors import suggestion
from irsim_gym.envs.described.moment import BodyMoment
from irsim_gym.envs.gymnasium.explained import ReadableWorld
from irsim_gym.envs.gymnasium.worlds import Worlds
from irsim_gym.envs.parts.limits import ScenarioSpec
from irsim_gym.envs.parts.pictures import RENDER_MODES
from irsim_gym.tasks.episodes.levels import CHAIN


class WorldView(ReadableWorld):
    """One world, or one agent of a world: what ``get_attr``, ``set_attr``, ``call`` and ``env_method`` reach.

    What is one for all worlds of a batch can be read, not set. Other names may be set and belong to this world alone.

    Args:
        index: Which world.
        agent: Which of its agents.
        spec: What a single environment like this one is made from; None for none.
    """

    def __init__(self, worlds: Worlds, index: int, agent: int = 0, spec: ScenarioSpec | None = None) -> None:
        self.worlds = worlds
        self._index = index
        self.agent = agent
        self._spec = spec

    @property
    def spec(self) -> ScenarioSpec | None:
        """What ``gymnasium.make`` makes a single environment like this one from."""
        if self._spec is not None:
            self._spec.keep(self.max_steps, self.max_steps)
        return self._spec

    @property
    def max_steps(self) -> int:
        """Time limit [steps]."""
        return self.worlds.task.max_steps

    @property
    def render_mode(self) -> str | None:
        """``"rgb_array"``, ``"rgb_array_list"``, ``"human"`` or None."""
        return self.worlds.render_mode

    @property
    def metadata(self) -> dict[str, Any]:
        """Render modes, and the frames per second at which a film runs in real time."""
        return {"render_modes": list(RENDER_MODES), "render_fps": self.worlds.render_fps}

    @property
    def observation_space(self) -> Any:
        """The space of an agent's observations."""
        return self.worlds.observation_space

    @property
    def action_space(self) -> Any:
        """The space of an agent's actions."""
        return self.worlds.action_space

    @property
    def unwrapped(self) -> Self:
        """Itself."""
        return self

    @property
    def robot(self) -> BodyMoment:
        """The robot that learns here, as it is now, to be read."""
        simulation = self.worlds.simulation
        return BodyMoment(simulation, int(simulation.agents[self.agent]), self._index)

    def choose_level(self, level: int | None) -> None:
        """Choose the level that its world begins next, within its split; None for the next one of its chain."""
        self.worlds.choose_levels([CHAIN if level is None else level], [self._index])

    def action_masks(self) -> Flags:
        """Return which choices are worth trying, ``(n_choices,)``: what ``MaskablePPO`` of sb3-contrib asks for."""
        return np.asarray(self.worlds.action_masks()[self._index, self.agent])

    def info(self) -> dict[str, Any]:
        """Return what is known about the agent now."""
        return self.worlds.info_of(self._index, self.agent)

    def render(self) -> Any:
        """Return a fresh picture of the world; None without a render mode, or with a window."""
        return self.worlds.pictures.of(self._index)

    def has_wrapper_attr(self, name: str) -> bool:
        """Say whether there is such an attribute."""
        return hasattr(self, name)

    def get_wrapper_attr(self, name: str) -> Any:
        """Return an attribute.

        Raises:
            AttributeError: There is none; the message says what there is in place of one that a single world has.
        """
        if hasattr(self, name):
            return getattr(self, name)
        if name in ("reset", "step", "close"):
            raise AttributeError(f"worlds of a batch {name} together: call {name}() of the batch")
        names = [known for known in (*dir(type(self)), *self.__dict__) if not known.startswith("_")]
        raise AttributeError(f"a world of a batch has no attribute {name!r}{suggestion(name, names)}")

    def set_wrapper_attr(self, name: str, value: object, *, force: bool = True) -> bool:
        """Set an attribute of this world alone.

        Args:
            force: Also where there is none yet.

        Returns:
            Whether it was set.

        Raises:
            AttributeError: It is one for the whole batch.
        """
        if hasattr(type(self), name) or name in ("worlds", "agent"):
            raise AttributeError(f"{name!r} is shared by all worlds of a batch and cannot be set for one")
        if not force and not hasattr(self, name):
            return False
        setattr(self, name, value)
        return True


def common_limit(values: list[Any], n_worlds: int) -> int:
    """Return the time limit that all worlds of a batch are given; ValueError where they would differ."""
    if len(values) != n_worlds or any(value != values[0] for value in values):
        raise ValueError(f"all {n_worlds} worlds of a batch have one max_steps, set it for all of them alike: {values}")
    limit: int = values[0]
    return limit
