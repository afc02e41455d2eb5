"""The episodes that an arena's page can replay, and their recordings."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from irsim_gym.envs.parts.pictures import make_renderer
from irsim_gym.evaluation.arena.board import Board
from irsim_gym.evaluation.comparison.players import Players
from irsim_gym.evaluation.comparison.record import recorded_episode
from irsim_gym.evaluation.policies.perception import Perceived
from irsim_gym.evaluation.policies.policy import Policy
from irsim_gym.tasks import Episodes, Outcome

if TYPE_CHECKING:
    from irsim_gym.rendering.replay.replay_data import Recording


@dataclass(frozen=True)
class ShownEpisode:
    """An episode that is recorded for the page.

    Attributes:
        policy: Index of the policy on the board.
        level: Index of the level on the board.
    """

    policy: int
    level: int


def choose_episodes(board: Board, most: int) -> list[ShownEpisode]:
    """Return failed episodes, each with the fastest successful episode of the same level, if there is one.

    The policies take turns. Each policy's failures are ordered by duration, those on levels that another policy solved
    first. Returns at most ``most`` episodes, sorted by level.
    """
    queues = [_failures(board, policy) for policy in range(len(board.policies))]
    chosen: dict[ShownEpisode, None] = {}
    while any(queues):
        for policy, queue in enumerate(queues):
            if queue:
                level = queue.pop(0)
                pair = [ShownEpisode(policy, level), *_solution(board, level)]
                if len({*chosen, *pair}) > most:
                    return _by_level(chosen)
                chosen |= dict.fromkeys(pair)
    return _by_level(chosen)


def count_failures(board: Board) -> int:
    """Return the number of failed episodes."""
    return int((~board.success).sum())


def _failures(board: Board, policy: int) -> list[int]:
    """Return the levels that a policy failed, in the order in which they are shown."""
    failed = np.flatnonzero(~board.success[policy])
    unsolved = ~board.success[:, failed].any(axis=0)
    order = np.lexsort((failed, board.steps[policy, failed], unsolved))
    return [int(level) for level in failed[order]]


def _solution(board: Board, level: int) -> list[ShownEpisode]:
    solvers = np.flatnonzero(board.success[:, level])
    if not len(solvers):
        return []
    return [ShownEpisode(int(solvers[np.argmin(board.steps[solvers, level])]), level)]


def _by_level(chosen: Mapping[ShownEpisode, None]) -> list[ShownEpisode]:
    return sorted(chosen, key=lambda episode: (episode.level, episode.policy))


def record_episodes(
    board: Board, policies: Sequence[Policy], worlds: Perceived, split: str, chosen: Sequence[ShownEpisode]
) -> Iterator[tuple[ShownEpisode, Recording | None]]:
    """Play episodes again and yield their recordings; None for an episode that ended differently this time.

    Args:
        policies: The policies, in the order of the board.
    """
    renderer = make_renderer(worlds.episodes.simulation)
    for shown in chosen:
        policy = policies[shown.policy]
        player = Players([worlds.of(policy)], [policy], [board.policies[shown.policy]], renderer, split)
        recording = recorded_episode(player, 0, int(board.levels[shown.level]))
        yield shown, recording if _ended_alike(board, player.episodes[0], shown) else None
    renderer.close()


def _ended_alike(board: Board, episodes: Episodes, shown: ShownEpisode) -> bool:
    """Return whether the episode of the first world ended as on the board; it may not if its policy acts at random."""
    infos = episodes.view.infos
    arrived = int((infos["outcome"][0] == Outcome.SUCCESS).sum())
    same = arrived == board.arrived[shown.policy, shown.level]
    return bool(same and infos["steps"][0].max() == board.steps[shown.policy, shown.level])
