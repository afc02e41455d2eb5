"""The spec of an environment, which Gymnasium writes as JSON: what it was made with, as plain data."""

from collections.abc import Mapping
from copy import copy
from enum import Enum
from pathlib import Path
from typing import Any

import numpy as np
from gymnasium.envs.registration import EnvSpec

from irsim_gym.scenario import Scenario


def plain_spec(spec: EnvSpec) -> EnvSpec:
    """Return a spec whose arguments are plain data: paths and arrays become text and lists."""
    plain = copy(spec)
    plain.kwargs = _plain(spec.kwargs)
    return plain


def refuse_loaded(spec: EnvSpec) -> None:
    """Raise a TypeError for a spec with a loaded scenario, which JSON cannot hold."""
    scenario = spec.kwargs.get("scenario")
    if not isinstance(scenario, Scenario):
        return
    parameters = "".join(f", {name}={value!r}" for name, value in scenario.parameters.items())
    file = f"its file, scenario={scenario.file!r}{parameters}"
    source = file if scenario.file else "the mapping that it was read from"
    raise TypeError(
        f"the spec of '{spec.id}' holds the loaded scenario '{scenario.name}', which JSON cannot represent: "
        f"make the environment from {source}"
    )


def _plain(value: object) -> Any:
    if isinstance(value, Mapping):
        return {key: _plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(item) for item in value]
    if isinstance(value, np.ndarray | np.generic):
        return value.tolist()
    if isinstance(value, Enum):
        return value.value
    return str(value) if isinstance(value, Path) else value
