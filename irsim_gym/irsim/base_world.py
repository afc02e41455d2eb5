"""IR-SIM's world as a class."""

from typing import Any

from irsim_gym.live.session.level_source import ScenarioSource
from irsim_gym.live.world import World


class EnvBase(World):
    """A world as ``irsim.make`` returns it: like ``irsim_gym.load`` with ``columns=True``. It may be derived from.

    Args:
        world_name: The file; by default the YAML file beside the running script that is named as the script is.
        **options: As for ``irsim_gym.load``. A window opens with ``display=True`` only.
    """

    def __init__(self, world_name: ScenarioSource | None = None, **options: Any) -> None:
        super().__init__(world_name, **{"columns": True, **options})
