"""The books of an episode: path, clearance, outcome and the sum of the reward."""

from __future__ import annotations

import numpy as np

from irsim_gym.arraytypes import Flags, Floats, Ints
from irsim_gym.jit import kernel
from irsim_gym.tasks.outcome import RUNNING, SUCCESS, TIMEOUT


@kernel
def open_books(
    worlds: Ints,
    agents: Ints,
    pose: Floats,
    bodies_goal_distance: Floats,
    clearance: Floats,
    began: Flags,
    position: Floats,
    min_clearance: Floats,
    path_length: Floats,
    goal_distance: Floats,
    steps: Ints,
    stalled: Floats,
    deadlocked: Flags,
    hit: Ints,
    hit_kind: Ints,
    outcome: Ints,
    success: Flags,
    over: Flags,
    terminated: Flags,
    truncated: Flags,
    reward_term: Floats,
    reward: Floats,
) -> None:
    """Begin an episode for the agents of the worlds that ``began`` names.

    Args:
        worlds: The worlds to treat.
        agents: Body of each agent, ``(n_agents,)``.
        pose: ``(n_worlds, n_bodies, 3)`` [m, m, rad].
        bodies_goal_distance: ``(n_worlds, n_bodies)`` [m].
        clearance: ``(n_worlds, n_agents)`` [m].
        began: Whose episode begins, ``(n_worlds, n_agents)``.
        position: Written, as are all that follow; see ``EpisodeState``.
        min_clearance: [m].
        path_length: [m].
        goal_distance: [m].
        steps: Counted from 0.
        stalled: 0 [s].
        deadlocked: False.
        hit: -1.
        hit_kind: NOTHING.
        outcome: RUNNING.
        success: False.
        over: False.
        terminated: False.
        truncated: False.
        reward_term: 0.
        reward: 0.
    """
    for i in range(worlds.shape[0]):
        w = worlds[i]
        for a in range(agents.shape[0]):
            b = agents[a]
            if not began[w, a]:
                continue
            position[w, a, 0], position[w, a, 1] = pose[w, b, 0], pose[w, b, 1]
            min_clearance[w, a], path_length[w, a] = clearance[w, a], 0.0
            goal_distance[w, a] = bodies_goal_distance[w, b]
            stalled[w, a], deadlocked[w, a] = 0.0, False
            steps[w, a], hit[w, a], hit_kind[w, a], outcome[w, a] = 0, -1, 0, RUNNING
            success[w, a], over[w, a], terminated[w, a], truncated[w, a] = False, False, False, False
            for k in range(reward_term.shape[2]):
                reward_term[w, a, k] = 0.0
            reward[w, a] = 0.0


@kernel
def mark(worlds: Ints, value: bool, flags: Flags) -> None:
    """Set the flags ``(n_worlds, n_agents)`` of some worlds."""
    for i in range(worlds.shape[0]):
        flags[worlds[i], :] = value


@kernel
def note_ended(worlds: Ints, terminated: Flags, truncated: Flags, over: Flags) -> None:
    """Write whose episode has ended."""
    for i in range(worlds.shape[0]):
        w = worlds[i]
        for a in range(over.shape[1]):
            over[w, a] = terminated[w, a] or truncated[w, a]


@kernel
def limit_clearance(worlds: Ints, minded: float, min_clearance: Floats, clearance: Floats) -> None:
    """Write up to where clearances matter [m]: to the terms that mind them, and as a new minimum."""
    for i in range(worlds.shape[0]):
        w = worlds[i]
        for a in range(clearance.shape[1]):
            clearance[w, a] = max(min_clearance[w, a], minded)


@kernel
def keep_books(
    worlds: Ints,
    agents: Ints,
    pose: Floats,
    bodies_goal_distance: Floats,
    bodies_hit: Ints,
    kinds: Ints,
    clearance: Floats,
    outcome: Ints,
    position: Floats,
    min_clearance: Floats,
    path_length: Floats,
    goal_distance: Floats,
    steps: Ints,
    hit: Ints,
    hit_kind: Ints,
    over: Flags,
) -> None:
    """Add a step to the books of the agents whose episode is under way.

    Args:
        worlds: The worlds to treat.
        agents: Body of each agent, ``(n_agents,)``.
        pose: ``(n_worlds, n_bodies, 3)`` [m, m, rad].
        bodies_goal_distance: ``(n_worlds, n_bodies)`` [m].
        bodies_hit: ``(n_worlds, n_bodies)``.
        kinds: HitKind of each body, ``(n_bodies,)``.
        clearance: ``(n_worlds, n_agents)`` [m].
        outcome: ``(n_worlds, n_agents)``, of the step before.
        position: Written, as are all that follow; see ``EpisodeState``.
        min_clearance: [m].
        path_length: [m].
        goal_distance: [m].
        steps: Counted from 0.
        hit: Body that is touched, -1 for none.
        hit_kind: What that is, a HitKind.
        over: The episode had ended before this step.
    """
    for i in range(worlds.shape[0]):
        w = worlds[i]
        for a in range(agents.shape[0]):
            b = agents[a]
            over[w, a] = outcome[w, a] != RUNNING
            if over[w, a]:
                continue
            dx, dy = pose[w, b, 0] - position[w, a, 0], pose[w, b, 1] - position[w, a, 1]
            path_length[w, a] += np.sqrt(dx * dx + dy * dy)
            position[w, a, 0], position[w, a, 1] = pose[w, b, 0], pose[w, b, 1]
            min_clearance[w, a] = min(min_clearance[w, a], clearance[w, a])
            goal_distance[w, a], hit[w, a] = bodies_goal_distance[w, b], bodies_hit[w, b]
            hit_kind[w, a] = kinds[hit[w, a]] if hit[w, a] >= 0 else 0
            steps[w, a] += 1


@kernel
def watch_standstill(
    worlds: Ints,
    agents: Ints,
    step_time: Floats,
    slow: float,
    patience: float,
    has_goal: Flags,
    arrived: Flags,
    stopped: Flags,
    twist: Floats,
    outcome: Ints,
    stalled: Floats,
    deadlocked: Flags,
) -> None:
    """Measure for how long agents have hardly moved away from their goals.

    Args:
        worlds: The worlds to treat.
        agents: Body of each agent, ``(n_agents,)``.
        step_time: Duration of a step [s], ``(1,)``.
        slow: Speed below which an agent stands still [m/s].
        patience: Time after which it is deadlocked [s].
        has_goal: Bodies with a goal.
        arrived: Bodies at their goal, ``(n_worlds, n_bodies)``.
        stopped: Bodies that are held in place.
        twist: Velocities in the world frame [m/s].
        outcome: ``(n_worlds, n_agents)``, of the step before.
        stalled: Written [s], ``(n_worlds, n_agents)``.
        deadlocked: Written, the same shape.
    """
    for i in range(worlds.shape[0]):
        w = worlds[i]
        for a in range(agents.shape[0]):
            b = agents[a]
            if outcome[w, a] != RUNNING:
                continue
            vx, vy = twist[w, b, 0], twist[w, b, 1]
            is_slow = stopped[w, b] or vx * vx + vy * vy < slow * slow
            stands = is_slow and has_goal[b] and not arrived[w, b]
            stalled[w, a] = stalled[w, a] + step_time[0] if stands else 0.0
            deadlocked[w, a] = stands and stalled[w, a] > patience - 0.5 * step_time[0]


@kernel
def settle(
    worlds: Ints,
    outcomes: Ints,
    max_steps: int,
    ending: Flags,
    over: Flags,
    steps: Ints,
    outcome: Ints,
    success: Flags,
    terminated: Flags,
    truncated: Flags,
) -> None:
    """Decide whether the episodes have ended, and how; the first ending that applies wins, the time limit is last.

    Args:
        worlds: The worlds to treat.
        outcomes: Outcome of each ending, in order of precedence, ``(n_endings,)``.
        max_steps: The time limit.
        ending: Which endings apply, ``(n_worlds, n_agents, n_endings)``.
        over: Agents whose episode had ended before keep everything, ``(n_worlds, n_agents)``.
        steps: Steps taken.
        outcome: Written, ``(n_worlds, n_agents)``, as are all that follow.
        success: The outcome is SUCCESS.
        terminated: The task has ended.
        truncated: The time limit alone has ended the episode.
    """
    for i in range(worlds.shape[0]):
        w = worlds[i]
        for a in range(outcome.shape[1]):
            if over[w, a]:
                continue
            found = RUNNING
            for k in range(outcomes.shape[0]):
                if ending[w, a, k] and found == RUNNING:
                    found = outcomes[k]
            terminated[w, a] = found != RUNNING
            truncated[w, a] = found == RUNNING and steps[w, a] >= max_steps
            outcome[w, a] = TIMEOUT if truncated[w, a] else found
            success[w, a] = found == SUCCESS


@kernel
def add_up(worlds: Ints, over: Flags, reward_term: Floats, reward: Floats) -> None:
    """Sum the reward terms in their order; nothing is paid to an agent whose episode had ended before."""
    for i in range(worlds.shape[0]):
        w = worlds[i]
        for a in range(reward.shape[1]):
            total = 0.0
            for k in range(reward_term.shape[2]):
                if over[w, a]:
                    reward_term[w, a, k] = 0.0
                total += reward_term[w, a, k]
            reward[w, a] = total


@kernel
def share_rewards(worlds: Ints, share: float, over: Flags, reward_term: Floats) -> None:
    """Replace the part ``share`` of each agent's terms by the mean over all agents of its world.

    An agent whose episode had ended before counts with 0 in the mean.
    """
    for i in range(worlds.shape[0]):
        w = worlds[i]
        n_agents = reward_term.shape[1]
        for k in range(reward_term.shape[2]):
            total = 0.0
            for a in range(n_agents):
                total += 0.0 if over[w, a] else reward_term[w, a, k]
            for a in range(n_agents):
                reward_term[w, a, k] = (1.0 - share) * reward_term[w, a, k] + share * (total / n_agents)
