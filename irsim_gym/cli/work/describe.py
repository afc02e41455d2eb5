"""The command ``irsim-gym describe``: print what an environment observes."""

import json
from collections.abc import Iterator

from irsim_gym.envs.described.description import Description
from irsim_gym.envs.described.description_text import show
from irsim_gym.envs.gymnasium.worlds import Worlds
from irsim_gym.evaluation.requests.inputs import check_inputs
from irsim_gym.evaluation.requests.scenario_request import ScenarioRequest


def describe_scenario(request: ScenarioRequest, *, as_json: bool) -> None:
    """Print the description of an environment.

    Robots of a team that observe and act alike are described once.

    Args:
        as_json: Print JSON: an object, or a list of objects for a team.
    """
    check_inputs(request)
    worlds = Worlds(**vars(request))
    descriptions = list(_each(worlds, request.team))
    if as_json:
        plain = [description.as_dict() for description in descriptions]
        print(json.dumps(plain if request.team else plain[0], indent=2))
        return
    for k, description in enumerate(descriptions):
        print(end="\n" if k else "")
        show(description)


def _each(worlds: Worlds, team: bool) -> Iterator[Description]:
    """Yield a description for each kind of learner."""
    names: set[str] = set()
    for name in worlds.agent_names:
        if name not in names:
            description = worlds.describe(name, of_agent=team)
            names |= {name, *description.same_for}
            yield description
