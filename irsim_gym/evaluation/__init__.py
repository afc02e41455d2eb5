"""Evaluation of policies."""

from typing import TYPE_CHECKING

from irsim_gym.faces import public

if TYPE_CHECKING:
    from irsim_gym.evaluation.face import *  # noqa: F403

__getattr__ = public(__name__)
