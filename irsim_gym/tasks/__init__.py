"""What is learned: actions, observations, rewards and endings on top of the simulator.

No kind of body, and nothing that knows Gymnasium.
"""

from irsim_gym.base.families import SECTIONS
from irsim_gym.tasks import actions, endings, observations, rewards
from irsim_gym.tasks.definition.task import Task, TaskOptions, load_task
from irsim_gym.tasks.episodes.episodes import Episodes
from irsim_gym.tasks.episodes.transition import Transition
from irsim_gym.tasks.terms.outcome import HitKind, Outcome

SECTIONS.register("task", TaskOptions)

__all__ = ["Episodes", "HitKind", "Outcome", "Task", "Transition", "actions", "endings", "load_task", "observations"]
__all__ += ["rewards"]
