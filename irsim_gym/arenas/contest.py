"""The arena: policies on the same levels, and one page with all that tells them apart."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.progress import Progress
from rich.table import Table

from irsim_gym import __version__
from irsim_gym.arenas.arena_page import write_page
from irsim_gym.arenas.archive import PAGE, TABLE, Archive, holds_arena
from irsim_gym.arenas.board import Board, Row
from irsim_gym.arenas.crossplay import Arrangement, Meeting, arrangements, meetings, mixed
from irsim_gym.arenas.entrants import Entrant, check_entrants, load_entrants
from irsim_gym.arenas.standings import Standings, compare
from irsim_gym.envs.worlds import ScenarioSource, TaskSource
from irsim_gym.errors import IrsimGymError
from irsim_gym.evaluation.metrics import Summary, summarize
from irsim_gym.evaluation.optimum import Optima
from irsim_gym.evaluation.policy import Policy
from irsim_gym.evaluation.protocol import evaluate
from irsim_gym.evaluation.tables import summary_table, table_text, write_text
from irsim_gym.evaluation.team_metrics import TeamSummary, summarize_teams
from irsim_gym.evaluation.team_tables import compared_table, team_table
from irsim_gym.evaluation.teams import evaluate_team
from irsim_gym.tasks import Episodes
from irsim_gym.tasks.levels import check_split
from irsim_gym.training.episode_setup import conditions, make_episodes, team_conditions
from irsim_gym.training.policies import Source
from irsim_gym.training.run import machine
from irsim_gym.training.snapshot import snapshot_of

WORLDS = 128
REPLAYS = 200
