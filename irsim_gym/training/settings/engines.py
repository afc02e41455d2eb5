"""The engines of a training: Stable-Baselines3 in this process, or Ray RLlib in several, on one or more machines."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass, replace
from typing import Any

from irsim_gym.base.errors import IrsimGymError, suggestion

STABLE_BASELINES, RLLIB = "sb3", "rllib"
ENGINES = (STABLE_BASELINES, RLLIB)
WORKERS = 2
"""Default number of processes that sample."""


@dataclass(frozen=True)
class Engine:
    """Settings of Ray RLlib.

    Attributes:
        workers: Number of processes that sample; 0 samples in the learner's process. None for the default, 2.
        worlds_per_worker: Number of worlds of each process; None distributes ``n_envs`` of the hyper-parameters.
        learner_gpus: Number of GPUs, each with its own learner; 0 learns on the CPU. None for the default, 0.
    """

    workers: int | None = None
    worlds_per_worker: int | None = None
    learner_gpus: int | None = None

    def chosen(self, n_envs: int) -> Engine:
        """Return the engine with defaults in place of None.

        Args:
            n_envs: Number of worlds of the hyper-parameters.
        """
        workers = WORKERS if self.workers is None else self.workers
        worlds = self.worlds_per_worker or max(1, n_envs // max(1, workers))
        return Engine(workers, worlds, self.learner_gpus or 0)

    def or_of(self, other: Engine) -> Engine:
        """Return the engine with another one's values in place of None."""
        given = {name: value for name, value in asdict(self).items() if value is not None}
        return replace(other, **given)

    def to_plain(self) -> dict[str, Any]:
        """Return the engine as plain data."""
        return {"name": RLLIB, **asdict(self)}

    @classmethod
    def from_plain(cls, data: Mapping[str, Any] | None) -> Engine | None:
        """Make an engine from the data of ``to_plain``. None means Stable-Baselines3, and gives None."""
        return None if data is None else cls(**{name: value for name, value in data.items() if name != "name"})


def engine_of(
    name: str | None, workers: int | None, worlds_per_worker: int | None, learner_gpus: int | None, address: str | None
) -> Engine | None:
    """Return the engine of the command line's options; None for Stable-Baselines3.

    Raises:
        IrsimGymError: If there is no engine of this name, or an option belongs to another engine.
    """
    if name not in (None, *ENGINES):
        near = suggestion(str(name), ENGINES)
        raise IrsimGymError(f"no engine named '{name}'{near}; there are {', '.join(ENGINES)}")
    if name == RLLIB:
        return Engine(workers, worlds_per_worker, learner_gpus)
    given = {
        "--workers": workers,
        "--worlds-per-worker": worlds_per_worker,
        "--learner-gpus": learner_gpus,
        "--address": address,
    }
    wrong = [option for option, value in given.items() if value is not None]
    if wrong:
        raise IrsimGymError(f"{', '.join(wrong)}: only --engine {RLLIB} has workers, learners and a cluster")
    return None
