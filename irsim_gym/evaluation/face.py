"""Evaluations and what they return, policies on disk, and the parts for an evaluation of one's own."""

from irsim_gym.arenas.contest import Arena
from irsim_gym.arenas.standings import Standings
from irsim_gym.evaluation.behavior_policies import BehaviorPolicy
from irsim_gym.evaluation.drive_actions import to_actions
from irsim_gym.evaluation.metrics import EpisodeRow, Rate, Summary
from irsim_gym.evaluation.perception import Perceived
from irsim_gym.evaluation.policy import Policy, by_agent
from irsim_gym.evaluation.protocol import evaluate as play_levels
from irsim_gym.evaluation.reference_policies import ALWAYS_SHOWN, reference_policy
from irsim_gym.evaluation.tables import plain, write_json, write_text
from irsim_gym.evaluation.team_metrics import AgentRow, TeamRow, TeamSummary
from irsim_gym.evaluation.teams import top_speed
from irsim_gym.evaluation.worst_levels import worst_shares
from irsim_gym.training.cards import (
    CardAction,
    CardNetwork,
    CardPart,
    CardResult,
    CardScenario,
    CardShare,
    CardTerm,
    CardTraining,
    PolicyCard,
)
from irsim_gym.training.demonstrations import Demonstrations
from irsim_gym.training.episode_setup import conditions, make_episodes
from irsim_gym.training.evaluate import Evaluation, TeamEvaluation
from irsim_gym.training.machine import machine
from irsim_gym.training.policies import SavedPolicy
from irsim_gym.training.policies import load_policy as as_policy
from irsim_gym.training.shelf import ShelfPolicy

__all__ = ["ALWAYS_SHOWN", "AgentRow", "Arena", "BehaviorPolicy", "CardAction", "CardNetwork", "CardPart"]
__all__ += ["CardResult", "CardScenario", "CardShare", "CardTerm", "CardTraining", "Demonstrations", "EpisodeRow"]
__all__ += ["Evaluation", "Perceived", "Policy", "PolicyCard", "Rate", "SavedPolicy", "ShelfPolicy", "Standings"]
__all__ += ["Summary", "TeamEvaluation", "TeamRow", "TeamSummary", "as_policy", "by_agent", "conditions", "machine"]
__all__ += ["make_episodes", "plain", "play_levels", "reference_policy", "to_actions", "top_speed", "worst_shares"]
__all__ += ["write_json", "write_text"]
