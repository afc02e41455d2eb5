"""What replays of episodes show of each agent."""

from typing import Any

from irsim_gym.simulator.engine.telemetry import telemetry
from irsim_gym.tasks import Episodes, Outcome


def agent_values(episodes: Episodes, world: int) -> list[dict[str, Any]]:
    """Return what a replay shows of each agent: outcome, action, rewards and the state of its episode."""
    simulation, view = episodes.simulation, episodes.view
    begun = bool(simulation.state.step[world])
    agents = []
    for a, numbers in enumerate(telemetry(simulation, world, simulation.agents)):
        size = int(episodes.action_sizes[a])
        agents.append(
            {
                **numbers,
                "outcome": Outcome(int(view.infos["outcome"][world, a])).name.lower(),
                "action": episodes.state.action[world, a, :size].tolist() if begun else None,
                "reward": float(view.reward[world, a]),
                "terms": dict(zip(episodes.reward_names, view.reward_terms[world, a].tolist(), strict=True)),
            }
        )
    return agents
