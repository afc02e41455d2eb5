"""What an agent does.

One file for each action, named as in YAML, and what becomes of actions.
"""

from irsim_gym.base.families import ACTIONS
from irsim_gym.tasks.actions.discrete import DiscreteAction
from irsim_gym.tasks.actions.velocity import VelocityAction

ACTIONS.register("velocity", VelocityAction)
ACTIONS.register("discrete", DiscreteAction)
