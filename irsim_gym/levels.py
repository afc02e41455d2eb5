"""Levels as data: collections of others, and certificates."""

from irsim_gym.evaluation.levels.barn import import_barn
from irsim_gym.evaluation.levels.certificate import Certificate, read_certificate
from irsim_gym.evaluation.levels.jaxnav import import_jaxnav
from irsim_gym.scenario.specs.level_set import LevelSet

__all__ = ["Certificate", "LevelSet", "import_barn", "import_jaxnav", "read_certificate"]
