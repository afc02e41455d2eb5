"""Levels as data: drawn into files, imported from other collections, measured and shown."""

from typing import TYPE_CHECKING

from irsim_gym.faces import public

if TYPE_CHECKING:
    from irsim_gym.levels.face import *  # noqa: F403

__getattr__ = public(__name__)
