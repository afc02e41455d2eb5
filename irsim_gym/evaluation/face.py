"""Evaluations and what they return, policies on disk, and the parts for an evaluation of one's own."""

from irsim_gym.evaluation.arena.contest import Arena
from irsim_gym.evaluation.arena.standings import Standings
from irsim_gym.evaluation.comparison.demonstrations import Demonstrations
from irsim_gym.evaluation.comparison.evaluate import Evaluation, TeamEvaluation
from irsim_gym.evaluation.curves.robustness import Robustness, StrengthRow, robustness
from irsim_gym.evaluation.measures.metrics import EpisodeRow, Rate, Summary
from irsim_gym.evaluation.measures.team_metrics import AgentRow, TeamRow, TeamSummary
from irsim_gym.evaluation.measures.worst_levels import worst_shares
from irsim_gym.evaluation.policies.behavior_policies import BehaviorPolicy
from irsim_gym.evaluation.policies.drive_actions import to_actions
from irsim_gym.evaluation.policies.perception import Perceived
from irsim_gym.evaluation.policies.policy import Policy, by_agent
from irsim_gym.evaluation.policies.reference_policies import ALWAYS_SHOWN, reference_policy
from irsim_gym.evaluation.protocol.protocol import evaluate as play_levels
from irsim_gym.evaluation.protocol.tables import plain, write_json, write_text
from irsim_gym.evaluation.protocol.teams import top_speed
from irsim_gym.evaluation.requests.episode_setup import conditions, make_episodes
from irsim_gym.evaluation.requests.machine import machine
from irsim_gym.evaluation.saved_policies.cards import (
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
from irsim_gym.evaluation.saved_policies.policies import SavedPolicy
from irsim_gym.evaluation.saved_policies.policies import load_policy as as_policy
from irsim_gym.evaluation.saved_policies.shelf import ShelfPolicy

__all__ = ["ALWAYS_SHOWN", "AgentRow", "Arena", "BehaviorPolicy", "CardAction", "CardNetwork", "CardPart"]
__all__ += ["CardResult", "CardScenario", "CardShare", "CardTerm", "CardTraining", "Demonstrations", "EpisodeRow"]
__all__ += ["Evaluation", "Perceived", "Policy", "PolicyCard", "Rate", "Robustness", "SavedPolicy", "ShelfPolicy"]
__all__ += ["Standings", "StrengthRow", "Summary", "TeamEvaluation", "TeamRow", "TeamSummary", "as_policy"]
__all__ += ["by_agent", "conditions", "machine", "make_episodes", "plain", "play_levels", "reference_policy"]
__all__ += ["robustness", "to_actions", "top_speed", "worst_shares", "write_json", "write_text"]
