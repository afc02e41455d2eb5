"""Training, evaluation and recording: the commands ``train``, ``evaluate``, ``record`` and ``demo``."""

from typing import TYPE_CHECKING

from irsim_gym.faces import public

if TYPE_CHECKING:
    from irsim_gym.training.face import *  # noqa: F403

__getattr__ = public(__name__)
