"""How a policy learns: settings, runs, curves, searches, export.

No command: these are in ``cli``.
"""

from typing import TYPE_CHECKING

from irsim_gym.base.faces import public

if TYPE_CHECKING:
    from irsim_gym.training.face import *  # noqa: F403

__getattr__ = public(__name__)
