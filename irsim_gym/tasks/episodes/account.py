"""The bookkeeping of episodes: path, clearance, outcome and the sum of the reward."""

import numpy as np

from irsim_gym.simulator.step.arrival import goal_gap
from irsim_gym.simulator.world.model import STATE
from irsim_gym.simulator.world.names import Flags, Ints
from irsim_gym.tasks.terms import EpisodeState, Model, State, kernel, row_of
from irsim_gym.tasks.terms.outcome import MISPLACED, RUNNING, SUCCESS, TIMEOUT


@kernel
def begin_episodes(worlds: Ints, agents: Ints, state: State, episode: EpisodeState) -> None:
    """Begin an episode for the agents that ``began`` flags.

    Reads: state (goal_distance, pose), episode (began, clearance).
    Writes: episode (arrival, deadlocked, extra, goal_distance, hit, hit_kind, min_clearance, outcome, over,
        path_length, position, reward, reward_term, stalled, steps, success, terminated, truncated).

    Args:
        worlds: The worlds to treat.
        agents: Body of each agent, ``(n_agents,)``.
    """
    for w in worlds:
        for a in range(agents.shape[0]):
            b = agents[a]
            if not episode.began[w, a]:
                continue
            episode.position[w, a, 0], episode.position[w, a, 1] = state.pose[w, b, 0], state.pose[w, b, 1]
            episode.min_clearance[w, a], episode.path_length[w, a] = episode.clearance[w, a], 0.0
            episode.goal_distance[w, a] = state.goal_distance[w, b]
            episode.stalled[w, a], episode.deadlocked[w, a], episode.arrival[w, a] = 0.0, False, 0
            episode.steps[w, a], episode.hit[w, a], episode.hit_kind[w, a], episode.outcome[w, a] = 0, -1, 0, RUNNING
            episode.success[w, a], episode.over[w, a] = False, False
            episode.terminated[w, a], episode.truncated[w, a] = False, False
            for k in range(episode.reward_term.shape[2]):
                episode.reward_term[w, a, k] = 0.0
            for k in range(episode.extra.shape[2]):
                episode.extra[w, a, k] = 0
            episode.reward[w, a] = 0.0


@kernel
def mark(worlds: Ints, value: bool, flags: Flags) -> None:
    """Set the flags ``(n_worlds, n_agents)`` of some worlds."""
    for i in range(worlds.shape[0]):
        flags[worlds[i], :] = value


@kernel
def note_ended(worlds: Ints, episode: EpisodeState) -> None:
    """Flag the agents whose episode has ended.

    Reads: episode (terminated, truncated).
    Writes: episode (over).
    """
    for w in worlds:
        for a in range(episode.over.shape[1]):
            episode.over[w, a] = episode.terminated[w, a] or episode.truncated[w, a]


@kernel
def limit_clearance(worlds: Ints, minded: float, episode: EpisodeState) -> None:
    """Write the distance up to which clearances must be exact [m]: for terms, and for a new minimum.

    Reads: episode (min_clearance).
    Writes: episode (clearance).
    """
    for w in worlds:
        for a in range(episode.clearance.shape[1]):
            episode.clearance[w, a] = max(episode.min_clearance[w, a], minded)


@kernel
def count_shielded(worlds: Ints, acted: Ints, column: int, episode: EpisodeState) -> None:
    """Count the steps in which the shield has changed the command of an agent whose episode is running.

    Reads: episode (extra, outcome).
    Writes: episode (extra).

    Args:
        worlds: The worlds to treat.
        acted: Whether it has, 0 or 1, ``(n_worlds, n_agents)``.
        column: Where its count stands.
    """
    for w in worlds:
        for a in range(acted.shape[1]):
            episode.extra[w, a, column] += acted[w, a] if episode.outcome[w, a] == RUNNING else 0


@kernel
def note_cost(worlds: Ints, near: float, column: int, episode: EpisodeState) -> None:
    """Write the cost of a step, 1 with a contact or a clearance below ``near`` [m]; 0 for an episode that had ended.

    Reads: episode (clearance, hit, over).
    Writes: episode (extra).
    """
    for w in worlds:
        for a in range(episode.over.shape[1]):
            costs = episode.hit[w, a] >= 0 or episode.clearance[w, a] < near
            episode.extra[w, a, column] = 1 if costs and not episode.over[w, a] else 0


@kernel
def record_step(worlds: Ints, agents: Ints, state: State, episode: EpisodeState, kinds: Ints) -> None:
    """Record a step for agents whose episode is running.

    Reads: state (goal_distance, hit, pose), episode (arrival, clearance, hit, min_clearance, outcome, over,
        path_length, position, steps).
    Writes: episode (goal_distance, hit, hit_kind, min_clearance, over, path_length, position, steps).

    Args:
        worlds: The worlds to treat.
        agents: Body of each agent, ``(n_agents,)``.
        kinds: HitKind of each body, ``(n_bodies,)``.
    """
    for w in worlds:
        for a in range(agents.shape[0]):
            b = agents[a]
            # The outcome is still that of the step before.
            episode.over[w, a] = episode.outcome[w, a] != RUNNING
            if episode.over[w, a]:
                continue
            dx, dy = state.pose[w, b, 0] - episode.position[w, a, 0], state.pose[w, b, 1] - episode.position[w, a, 1]
            if episode.arrival[w, a] == 0:
                episode.path_length[w, a] += np.sqrt(dx * dx + dy * dy)
            episode.position[w, a, 0], episode.position[w, a, 1] = state.pose[w, b, 0], state.pose[w, b, 1]
            if episode.arrival[w, a] == 0:
                episode.min_clearance[w, a] = min(episode.min_clearance[w, a], episode.clearance[w, a])
            episode.goal_distance[w, a], episode.hit[w, a] = state.goal_distance[w, b], state.hit[w, b]
            episode.hit_kind[w, a] = kinds[episode.hit[w, a]] if episode.hit[w, a] >= 0 else 0
            episode.steps[w, a] += 1


@kernel
def measure_standstill(
    worlds: Ints, agents: Ints, model: Model, state: State, episode: EpisodeState, slow: float, patience: float
) -> None:
    """Measure the time for which agents have stood still away from their goals.

    Reads: model (has_goal, step_time), state (arrived, stopped, twist), episode (arrival, outcome, stalled).
    Writes: episode (deadlocked, stalled).

    Args:
        worlds: The worlds to treat.
        agents: Body of each agent, ``(n_agents,)``.
        slow: Speed below which an agent counts as standing still [m/s].
        patience: Time after which it is deadlocked [s].
    """
    for w in worlds:
        for a in range(agents.shape[0]):
            b = agents[a]
            if episode.outcome[w, a] != RUNNING:
                continue
            vx, vy = state.twist[w, b, 0], state.twist[w, b, 1]
            is_slow = state.stopped[w, b] or vx * vx + vy * vy < slow * slow
            has_goal = model.has_goal[b] and not state.arrived[w, b] and episode.arrival[w, a] == 0
            stands = is_slow and has_goal
            episode.stalled[w, a] = episode.stalled[w, a] + model.step_time[0] if stands else 0.0
            # Half a step of tolerance, because a sum of step times may end up just below ``patience``.
            episode.deadlocked[w, a] = stands and episode.stalled[w, a] > patience - 0.5 * model.step_time[0]


@kernel
def decide_outcomes(worlds: Ints, outcomes: Ints, max_steps: int, episode: EpisodeState) -> None:
    """Determine the outcome of each episode: the first ending that applies, and the time limit last.

    Reads: episode (ending, over, steps, truncated).
    Writes: episode (outcome, success, terminated, truncated).

    Args:
        worlds: The worlds to treat.
        outcomes: Outcome of each ending, in order of precedence, ``(n_endings,)``.
        max_steps: The time limit.
    """
    for w in worlds:
        for a in range(episode.outcome.shape[1]):
            if episode.over[w, a]:
                continue
            outcome = RUNNING
            for k in range(outcomes.shape[0]):
                # Endings come in order of precedence: the first one that applies counts.
                if episode.ending[w, a, k] and outcome == RUNNING:
                    outcome = outcomes[k]
            episode.terminated[w, a] = outcome != RUNNING
            episode.truncated[w, a] = outcome == RUNNING and episode.steps[w, a] >= max_steps
            episode.outcome[w, a] = TIMEOUT if episode.truncated[w, a] else outcome
            episode.success[w, a] = outcome == SUCCESS


@kernel
def find_misplaced(worlds: Ints, agents: Ints, model: Model, state: State, told: State, episode: EpisodeState) -> None:
    """Let the episodes of agents fail that believe to have arrived, and are elsewhere by more than their tolerance.

    What counts is how far the true pose is from the believed one: a robot that stops as soon as it believes to be
    within the tolerance is beyond it in truth half of the time, however small its error is.

    Reads: model (arrive_mode, goal_threshold), state (pose), told (pose), episode (outcome, over).
    Writes: episode (outcome, success).

    Args:
        worlds: The worlds to treat.
        agents: Body of each agent, ``(n_agents,)``.
        told: The state with the believed poses.
    """
    for w in worlds:
        threshold = model.goal_threshold[row_of(model.goal_threshold, w)]
        for a in range(agents.shape[0]):
            b = agents[a]
            error = goal_gap(state.pose[w, b], told.pose[w, b], model.arrive_mode[b] == STATE)
            if episode.outcome[w, a] == SUCCESS and not episode.over[w, a] and error > threshold[b]:
                episode.outcome[w, a], episode.success[w, a] = MISPLACED, False


@kernel
def hold_arrivals(worlds: Ints, episode: EpisodeState) -> None:
    """Note arrivals, and let agents that have arrived go on for as long as others of their world are on their way.

    At the time limit no agent is on its way any more, since all agents of a world began together.

    Reads: episode (arrival, outcome, over, steps).
    Writes: episode (arrival, outcome, success, terminated, truncated).
    """
    for w in worlds:
        is_on_its_way = False
        for a in range(episode.outcome.shape[1]):
            if episode.outcome[w, a] == SUCCESS and episode.arrival[w, a] == 0:
                episode.arrival[w, a] = episode.steps[w, a]
            is_on_its_way |= episode.outcome[w, a] == RUNNING and episode.arrival[w, a] == 0
        for a in range(episode.outcome.shape[1]):
            outcome = episode.outcome[w, a]
            fails = outcome != RUNNING and outcome != SUCCESS and outcome != TIMEOUT
            if episode.over[w, a] or episode.arrival[w, a] == 0 or fails:
                continue
            episode.outcome[w, a] = RUNNING if is_on_its_way else SUCCESS
            episode.success[w, a] = episode.terminated[w, a] = not is_on_its_way
            episode.truncated[w, a] = False


@kernel
def settle_arrivals(worlds: Ints, on_the_way: Flags, episode: EpisodeState) -> None:
    """Let agents that have arrived and drive on succeed however their episodes end, and clear what the way costs.

    Reads: episode (arrival, outcome, over, steps).
    Writes: episode (outcome, reward_term, success).

    Args:
        worlds: The worlds to treat.
        on_the_way: Whether a reward term is paid on the way only, ``(n_rewards,)``.
    """
    for w in worlds:
        for a in range(episode.outcome.shape[1]):
            if episode.over[w, a] or episode.arrival[w, a] == 0:
                continue
            if episode.outcome[w, a] != RUNNING:
                episode.outcome[w, a], episode.success[w, a] = SUCCESS, True
            if episode.arrival[w, a] < episode.steps[w, a]:
                for k in range(on_the_way.shape[0]):
                    if on_the_way[k]:
                        episode.reward_term[w, a, k] = 0.0


@kernel
def sum_rewards(worlds: Ints, episode: EpisodeState) -> None:
    """Sum the reward terms in order; the reward is 0 for an agent whose episode had ended before.

    Reads: episode (over, reward_term).
    Writes: episode (reward, reward_term).
    """
    for w in worlds:
        for a in range(episode.reward.shape[1]):
            total = 0.0
            for k in range(episode.reward_term.shape[2]):
                if episode.over[w, a]:
                    episode.reward_term[w, a, k] = 0.0
                total += episode.reward_term[w, a, k]
            episode.reward[w, a] = total


@kernel
def share_rewards(worlds: Ints, share: float, episode: EpisodeState) -> None:
    """Replace a share of each agent's terms by the mean over all agents of its world.

    An agent whose episode had ended before counts as 0 in the mean.

    Reads: episode (over, reward_term).
    Writes: episode (reward_term).
    """
    for w in worlds:
        n_agents = episode.reward_term.shape[1]
        for k in range(episode.reward_term.shape[2]):
            total = 0.0
            for a in range(n_agents):
                total += 0.0 if episode.over[w, a] else episode.reward_term[w, a, k]
            for a in range(n_agents):
                episode.reward_term[w, a, k] = (1.0 - share) * episode.reward_term[w, a, k] + share * (total / n_agents)
