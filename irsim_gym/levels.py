"""Levels as data, and certificates."""

from irsim_gym.evaluation.levels.certificate import Certificate, read_certificate
from irsim_gym.scenario.specs.level_set import LevelSet

__all__ = ["Certificate", "LevelSet", "read_certificate"]
