"""What environments of one learner have beside the methods of Gymnasium."""

from irsim_gym.envs.described.description import Description
from irsim_gym.envs.described.moment import Bodies
from irsim_gym.envs.gymnasium.worlds import Worlds
from irsim_gym.envs.parts.mirror import Mirror


class Explained:
    """An environment around some worlds, which says what its numbers mean and what they would have been.

    Attributes:
        worlds: The worlds.
    """

    worlds: Worlds

    def describe(self) -> Description:
        """Return what observations, actions, rewards, endings and infos mean; it prints as tables."""
        return self.worlds.describe()

    def mirror(self) -> Mirror:
        """Return what exchanges left and right in observations and actions; an error says why it cannot be done."""
        return self.worlds.mirror()


class OneWorld:
    """An environment with one world, whose bodies can be read.

    Attributes:
        worlds: The world.
    """

    worlds: Worlds

    @property
    def robots(self) -> Bodies:
        """All robots of the level, by number or name; see ``BodyMoment``."""
        return self.worlds.moment().robots

    @property
    def bodies(self) -> Bodies:
        """All bodies of the level, robots first, by number or name; see ``BodyMoment``."""
        return self.worlds.moment().bodies

    @property
    def time(self) -> float:
        """Time since the start of the episode [s]."""
        return self.worlds.moment().time
