"""The episodes that an arena's page can replay, and their recordings."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from irsim_gym.base.arraytypes import Ints
from irsim_gym.envs.gymnasium.replays import agent_values
from irsim_gym.envs.parts.pictures import make_renderer, world_status
from irsim_gym.evaluation.arena.board import Board
from irsim_gym.evaluation.policies.perception import Perceived
from irsim_gym.evaluation.policies.policy import Policy
from irsim_gym.evaluation.protocol.protocol import drive
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


class EpisodeLog:
    """Records all episodes that are played: a `Watcher`.

    Attributes:
        policy: Name of the policy that plays.
    """

    def __init__(self, episodes: Episodes, split: str) -> None:
        self._renderer = make_renderer(episodes.simulation)
        self._split, self.policy = split, ""
        self._recordings: dict[int, Recording] = {}

    def began(self, episodes: Episodes, worlds: Ints, indices: Ints) -> None:
        """Begin recordings."""
        from irsim_gym.rendering.replay.replay_data import Recording

        levels = episodes.view.infos["level"][worlds, 0].tolist()
        for world, level in zip(worlds.tolist(), levels, strict=True):
            self._renderer.clear(world)
            details = {"policy": self.policy, "level": f"{level} ({self._split})"}
            self._recordings[world] = Recording(episodes.simulation.scenario, episodes.agent_names, details)
        self.stepped(episodes, worlds)

    def stepped(self, episodes: Episodes, worlds: Ints) -> None:
        """Record the present moment."""
        state = episodes.simulation.state
        for world in worlds.tolist():
            scene = self._renderer.scene(world, world_status(episodes, world))
            self._recordings[world].note(scene, state.pose[world], agent_values(episodes, world))
        self._renderer.trails.record(worlds, state.step[worlds], state.pose[worlds])

    def ended(self, episodes: Episodes, worlds: Ints, indices: Ints) -> None:
        """Name the recordings."""
        levels = episodes.view.infos["level"][worlds, 0].tolist()
        for world, level in zip(worlds.tolist(), levels, strict=True):
            status, time = world_status(episodes, world), float(episodes.simulation.state.time[world])
            self._recordings[world].name = f"{self.policy}, level {level}: {status.replace('_', ' ')}, {time:.1f} s"

    def take(self, world: int) -> Recording:
        """Return the recording of an episode that has ended, and remove it from the log."""
        return self._recordings.pop(world)

    def close(self) -> None:
        """Close the renderer."""
        self._renderer.close()


def record_episodes(
    board: Board, policies: Sequence[Policy], worlds: Perceived, split: str, chosen: Sequence[ShownEpisode]
) -> Iterator[tuple[ShownEpisode, Recording | None]]:
    """Play episodes again and yield their recordings; None for an episode that ended differently this time.

    Args:
        policies: The policies, in the order of the board.
    """
    log = EpisodeLog(worlds.episodes, split)
    for policy in sorted({shown.policy for shown in chosen}):
        mine = [shown for shown in chosen if shown.policy == policy]
        log.policy = board.policies[policy]
        levels = board.levels[[shown.level for shown in mine]].tolist()
        episodes = worlds.of(policies[policy])
        for indices, ended, _ in drive(policies[policy], episodes, levels, split, log):
            for index, world in zip(indices, ended, strict=True):
                recording = log.take(world)
                yield mine[index], recording if _ended_alike(board, episodes, world, mine[index]) else None
    log.close()


def _ended_alike(board: Board, episodes: Episodes, world: int, shown: ShownEpisode) -> bool:
    """Return whether an episode ended as on the board; it may not if its policy acts at random."""
    infos = episodes.view.infos
    arrived = int((infos["outcome"][world] == Outcome.SUCCESS).sum())
    same = arrived == board.arrived[shown.policy, shown.level]
    return bool(same and infos["steps"][world].max() == board.steps[shown.policy, shown.level])
