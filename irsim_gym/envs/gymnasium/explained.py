"""What environments of one learner have beside the methods of Gymnasium."""

from irsim_gym.envs.described.description import Description
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
