"""The spec of an environment, which Gymnasium writes as JSON: what it was made with, as plain data."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import fields
from enum import Enum
from pathlib import Path
from typing import Any

import numpy as np
from gymnasium.envs.registration import EnvSpec

from irsim_gym.scenario import Scenario


class LoadedSpec(EnvSpec):
    """The spec of an environment that was made from a loaded scenario, which JSON cannot hold."""

    def to_json(self) -> str:
        """Raise a TypeError that says what to make the environment from."""
        scenario: Scenario = self.kwargs["scenario"]
        parameters = "".join(f", {name}={value!r}" for name, value in scenario.parameters.items())
        file = f"its file, scenario={scenario.file!r}{parameters}"
        source = file if scenario.file else "the mapping that it was read from"
        raise TypeError(
            f"the spec of '{self.id}' holds the loaded scenario '{scenario.name}', an object that JSON cannot hold: "
            f"make the environment from {source}"
        )


def plain_spec(spec: EnvSpec | None) -> EnvSpec | None:
    """Return a spec whose arguments are plain data: paths and arrays become text and lists.

    Args:
        spec: As Gymnasium made it; of a loaded scenario it becomes a ``LoadedSpec``.
    """
    if spec is None:
        return None
    values: dict[str, Any] = {field.name: getattr(spec, field.name) for field in fields(spec) if field.init}
    values["kwargs"] = _plain(spec.kwargs)
    return (LoadedSpec if isinstance(spec.kwargs.get("scenario"), Scenario) else EnvSpec)(**values)


def _plain(value: Any) -> Any:
    if isinstance(value, Mapping):
        return {key: _plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(item) for item in value]
    if isinstance(value, np.ndarray | np.generic):
        return value.tolist()
    if isinstance(value, Enum):
        return value.value
    return str(value) if isinstance(value, Path) else value
