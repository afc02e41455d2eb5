"""Which interfaces there are: thin adapters over ``tasks.Episodes``.

Each folder knows one library.
"""

from typing import TYPE_CHECKING

from irsim_gym.base.faces import public

if TYPE_CHECKING:
    from irsim_gym.envs.face import *  # noqa: F403

__getattr__ = public(__name__)
