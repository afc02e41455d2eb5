"""What a robot's drive still does after a decision: the commands under way, and how slowly it follows them."""

from dataclasses import dataclass

from irsim_gym.base.arraytypes import Floats, Ints
from irsim_gym.base.kernels import kernel
from irsim_gym.base.kernels.structs import Struct


@dataclass(repr=False)
class Response(Struct):
    """What is known of how some bodies respond to commands; disturbances of commands write it (``Foreseen``).

    Attributes:
        place: Number of each body among these, -1 for others, shape ``(n_bodies,)``.
        pending: Commands under way in drive coordinates [m/s or rad/s], the next one first, shape
            ``(n_worlds, n, most, 3)``.
        n_pending: How many of them there are, shape ``(n_worlds, n)``.
        share: Share of the way to its command that a velocity makes in a step, shape ``(n_worlds, n)``.
        dead_band: Smaller numbers of a command count as 0 [m/s or rad/s], shape ``(n_worlds, n)``.
    """

    place: Ints
    pending: Floats
    n_pending: Ints
    share: Floats
    dead_band: Floats


@kernel
def respond_at_once(worlds: Ints, response: Response, acted: Ints) -> None:
    """Write the response of drives that nothing disturbs, and that no shield has acted yet.

    Writes: response (dead_band, n_pending, share), acted.
    """
    for w in worlds:
        for k in range(response.share.shape[1]):
            response.n_pending[w, k], response.share[w, k], response.dead_band[w, k] = 0, 1.0, 0.0
            acted[w, k] = 0
