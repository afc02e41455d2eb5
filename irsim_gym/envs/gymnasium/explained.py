"""What environments have in common beside the methods of Gymnasium, PettingZoo and Stable-Baselines3."""

from collections.abc import Sequence

from irsim_gym.base.arraytypes import Bytes, Ints
from irsim_gym.envs.described.description import Description
from irsim_gym.envs.described.moment import Bodies, WorldMoment
from irsim_gym.envs.gymnasium.worlds import Worlds
from irsim_gym.envs.parts.mirror import Mirror
from irsim_gym.envs.parts.pictures import ROOM, render_warning


class Explained:
    """An environment around some worlds, which says what its numbers mean and what they would have been.

    Attributes:
        worlds: The worlds.
    """

    worlds: Worlds

    def __repr__(self) -> str:
        return f"<{type(self).__name__} {self.worlds.summary}>"

    def describe(self) -> Description:
        """Return what observations, actions, rewards, endings and infos mean; it prints as tables."""
        return self.worlds.describe()

    def mirror(self) -> Mirror:
        """Return what exchanges left and right in observations and actions; an error says why it cannot be done."""
        return self.worlds.mirror()


class ReadableWorld(Explained):
    """One of the worlds, whose present moment can be read."""

    _index = 0
    """Which one."""

    @property
    def robots(self) -> Bodies:
        """All robots of the level, by number or name; see ``BodyMoment``."""
        return self.worlds.moment(self._index).robots

    @property
    def bodies(self) -> Bodies:
        """All bodies of the level, robots first, by number or name; see ``BodyMoment``."""
        return self.worlds.moment(self._index).bodies

    @property
    def time(self) -> float:
        """Time since the start of the episode [s]."""
        return self.worlds.moment(self._index).time


class OneWorld(ReadableWorld):
    """An environment of one world."""

    def close(self) -> None:
        """Close the window and free the renderer. May be called twice."""
        self.worlds.close()


class ManyWorlds(Explained):
    """An environment of many worlds, which are shown side by side."""

    def choose_levels(self, levels: Sequence[int] | Ints) -> None:
        """Choose the level that each world begins next, within the split that it plays.

        A choice counts once, and a reset of the world with a seed or options forgets it.

        Args:
            levels: Level of each world, as in the infos; -1 for the next one of its chain. Shape ``(num_envs,)``.
        """
        self.worlds.choose_levels(levels)

    def render(self) -> tuple[Bytes | list[Bytes] | None, ...] | None:
        """Return what the render mode asks for: for each world what ``WorldEnv.render`` returns.

        With ``"human"`` that is None: ``reset`` and ``step`` show the worlds, sixteen at most, in one window. Pictures
        have the shape ``(height, width, 3)``.
        """
        render_warning(self.worlds.render_mode)
        return self.worlds.pictures.each()

    def tiled(
        self, columns: int | None = None, worlds: Sequence[int] | None = None, room: tuple[int, int] = ROOM
    ) -> Bytes:
        """Return one fresh picture of several worlds side by side that fits into the room, ``(height, width, 3)``.

        Args:
            columns: Worlds in a row; None for as many as show them large and leave few places empty.
            worlds: Which; None for all.
            room: Most columns and rows of pixels.

        Raises:
            IrsimGymError: The environment was made without a render mode.
            ValueError: No world, or one that is not there, or no columns.
        """
        return self.worlds.pictures.tiled(columns, worlds, room)

    def moment(self, world: int) -> WorldMoment:
        """Return one of the worlds as it is now, to be read: ``robot``, ``robots``, ``bodies``, ``time``."""
        return self.worlds.moment(world)
