"""Tasks: actions, observations, rewards and endings on top of the simulator."""

from irsim_gym.families import SECTIONS
from irsim_gym.tasks import actions, endings, observations, rewards
from irsim_gym.tasks.episodes import Episodes
from irsim_gym.tasks.outcome import HitKind, Outcome
from irsim_gym.tasks.task import Task, TaskOptions, load_task
from irsim_gym.tasks.transition import Transition

SECTIONS.register("task", TaskOptions)

__all__ = ["Episodes", "HitKind", "Outcome", "Task", "Transition", "actions", "endings", "load_task", "observations"]
__all__ += ["rewards"]
