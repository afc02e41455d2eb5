"""Environments for learning libraries: thin adapters over ``tasks.Episodes``."""

from typing import TYPE_CHECKING

from irsim_gym.faces import public

if TYPE_CHECKING:
    from irsim_gym.envs.face import *  # noqa: F403

__getattr__ = public(__name__)
