"""Resolves ids of environments, such as ``irsim_gym/corridor-v0``, wherever a scenario is named.

An id is ``[module:]namespace/name-vN``, as in Gymnasium; the module is imported first. ``load_scenario`` uses this
module, so that the same ids work in all functions that take a scenario.
"""

import re
from collections.abc import Mapping
from importlib import import_module
from pathlib import Path
from typing import Any

from irsim_gym.base.errors import IrsimGymError, MissingScenarioError, UnknownNameError, nearest

NAMESPACE = "irsim_gym"
ANY = f"{NAMESPACE}/World-v0"
MOST_LISTED = 8
SOURCES = "a shipped name such as 'corridor', a file such as 'my_world.yaml', or plain data"

_ID = re.compile(r"(?:([A-Za-z_][\w.]*):)?((?:([\w-]+)/)?[\w-]+?(?:-v(\d+))?)")


class Ids:
    """Looks ids up in registries, which ``envs.gymnasium.registration`` provides."""

    def __init__(self) -> None:
        self._registries: list[Mapping[str, Any]] = []

    def look_in(self, registry: Mapping[str, object]) -> None:
        """Add a registry: a mapping from ids to objects with ``kwargs``, the arguments that make the environment."""
        if not any(registry is known for known in self._registries):
            self._registries.append(registry)

    def find(self, name: Any) -> str | None:
        """Return the registered id in a name, without its module; None for a name or path that is not an id.

        Raises:
            UnknownNameError: If the name is written as an id but is not registered, or its module does not exist.
        """
        match = _ID.fullmatch(name) if isinstance(name, str) else None
        if match is None:
            return None
        module, env_id, namespace, version = match.groups()
        if namespace is None and version is None:
            return None
        if module is not None:
            _import(module, name)
        if self._spec(env_id) is not None:
            return env_id
        is_meant = module is not None or namespace == NAMESPACE or (namespace is not None and version is not None)
        if is_meant and not Path(name).exists():
            raise UnknownNameError(f"no environment '{name}'{self._advice(env_id, namespace)}")
        return None

    def scenario(self, name: object) -> Any:
        """Return the scenario of an id; return anything else unchanged.

        Raises:
            UnknownNameError: If the name is written as an id but is not registered, or is no scenario of irsim_gym.
            MissingScenarioError: If the id stands for any scenario (``irsim_gym/World-v0``).
            IrsimGymError: If the id is registered with further arguments, e.g. a task, which only Gymnasium passes on.
        """
        env_id = self.find(name)
        if env_id is None:
            return name
        if env_id == ANY:
            raise MissingScenarioError(f"'{name}' is a placeholder for any scenario: name the scenario, {SOURCES}")
        kwargs = dict(self._spec(env_id).kwargs)
        scenario = kwargs.pop("scenario", None)
        if scenario is None:
            raise UnknownNameError(f"'{name}' is registered, but is not a scenario of irsim_gym")
        if kwargs:
            others = ", ".join(kwargs)
            raise IrsimGymError(
                f"'{name}' was registered with {others} as well, which gymnasium.make alone reads: "
                f"name the scenario in place of the id, and give {others} yourself"
            )
        return scenario

    def _spec(self, env_id: str) -> Any:
        return next((registry[env_id] for registry in self._registries if env_id in registry), None)

    def _advice(self, env_id: str, namespace: str | None) -> str:
        """Return advice about an id that is not registered."""
        ids = [other for registry in self._registries for other in registry if other.startswith(f"{namespace}/")]
        if not ids:
            return (
                f": nothing is registered as '{namespace}/...' in this process. Ids of register_scenarios are known "
                "where it was called: call it in each worker process too, on the command line in a module that "
                "--import names; or name the file, with its suffix"
            )
        names = {_name(other): other for other in ids}
        if _name(env_id) in names:
            return f": there is '{names[_name(env_id)]}'"
        near = nearest(_name(env_id), names)
        if near is not None:
            return f" (did you mean '{names[near]}'?)"
        if namespace == NAMESPACE:
            return "; `irsim-gym list` shows the shipped scenarios"
        return f"; there are {', '.join(ids[:MOST_LISTED])}{' ...' if len(ids) > MOST_LISTED else ''}"


IDS = Ids()


def scenario_name(scenario: str) -> str:
    """Return the shipped name or the path of a scenario, which may be given by an environment id.

    Raises:
        IrsimGymError: If the id stands for plain data, from which a run could not be resumed.
    """
    scenario_or_path = IDS.scenario(scenario)
    if not isinstance(scenario_or_path, str | Path):
        raise IrsimGymError(f"'{scenario}' is plain data: save it to a file and name the file")
    return str(scenario_or_path)


def _import(module: str, name: str) -> None:
    try:
        import_module(module)
    except ModuleNotFoundError as error:
        if error.name is None or not f"{module}.".startswith(f"{error.name}."):
            raise  # the module is there, but something that it imports is not
        raise UnknownNameError(f"no environment '{name}': cannot import module '{module}'") from None


def _name(env_id: str) -> str:
    """Return the name in an id, without namespace and version."""
    return re.sub(r"-v\d+$", "", env_id.rpartition("/")[2])
