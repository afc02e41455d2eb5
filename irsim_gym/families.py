"""The registries of all families. A family's package fills its own when it is imported."""

from __future__ import annotations

from irsim_gym.registry import Registry

KINEMATICS = Registry("kinematics")
BEHAVIORS = Registry("behavior")
GROUP_BEHAVIORS = Registry("group behavior")
FOOTPRINTS = Registry("shape")
PLACEMENTS = Registry("distribution")
SENSORS = Registry("sensor")
ACTIONS = Registry("action")
OBSERVATIONS = Registry("observation")
REWARDS = Registry("reward")
ENDINGS = Registry("ending")
