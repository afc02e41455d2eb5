"""The command ``irsim-gym describe``: print what an environment observes."""

import json
from collections.abc import Iterator

from irsim_gym.envs.described.description import Description
from irsim_gym.envs.described.description_text import show
from irsim_gym.envs.gymnasium.worlds import Worlds
from irsim_gym.evaluation.requests.inputs import check_inputs
from irsim_gym.evaluation.requests.scenario_request import ScenarioRequest


def describe_scenario(asked: ScenarioRequest, *, as_json: bool) -> None:
    """Print the description of an environment.

    Robots of a team that observe and act alike are described once.

    Args:
        as_json: Print JSON: an object, or a list of objects for a team.
    """
    check_inputs(asked)
    worlds = Worlds(**vars(asked))
    found = list(_each(worlds, asked.team))
    if as_json:
        plain = [description.as_dict() for description in found]
        print(json.dumps(plain if asked.team else plain[0], indent=2))
        return
    for k, description in enumerate(found):
        print(end="\n" if k else "")
        show(description)


def _each(worlds: Worlds, team: bool) -> Iterator[Description]:
    """Yield a description for each kind of learner."""
    known: set[str] = set()
    for name in worlds.agent_names:
        if name not in known:
            description = worlds.describe(name, own=team)
            known |= {name, *description.same_for}
            yield description
