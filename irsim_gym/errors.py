"""The errors and warnings that users meet."""

from irsim_gym.base.errors import *  # noqa: F403
from irsim_gym.base.errors import __all__ as __all__
