"""The benchmark suite: its scenarios and levels, and the tables that compare policies on them."""

from typing import TYPE_CHECKING

from irsim_gym.faces import public

if TYPE_CHECKING:
    from irsim_gym.suite.face import *  # noqa: F403

__getattr__ = public(__name__)
