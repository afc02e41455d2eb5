"""How good a policy is: protocols, measures, levels, the suite, the arena.

Nothing that trains.
"""

from typing import TYPE_CHECKING

from irsim_gym.base.faces import public

if TYPE_CHECKING:
    from irsim_gym.evaluation.face import *  # noqa: F403

__getattr__ = public(__name__)
