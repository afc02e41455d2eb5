"""What runs a training: Stable-Baselines3 in this process, or Ray RLlib in several, on one machine or on many."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass, replace
from typing import Any

from irsim_gym.errors import IrsimGymError, suggestion

STABLE_BASELINES, RLLIB = "sb3", "rllib"
ENGINES = (STABLE_BASELINES, RLLIB)
WORKERS = 2
"""Processes that sample, where nothing else is asked for."""


@dataclass(frozen=True)
class Engine:
    """How Ray RLlib runs a training.

    Attributes:
        workers: Processes that sample; 0 samples in the process of the learner. None for two.
        worlds_per_worker: Worlds of each; None shares out ``n_envs`` of the hyper-parameters.
        learner_gpus: Graphics cards, each of which has a learner; 0 learns on the processor. None for 0.
    """

    workers: int | None = None
    worlds_per_worker: int | None = None
    learner_gpus: int | None = None

    def chosen(self, n_envs: int) -> Engine:
        """Return it with numbers in place of None.

        Args:
            n_envs: Worlds of the hyper-parameters.
        """
        workers = WORKERS if self.workers is None else self.workers
        worlds = self.worlds_per_worker or max(1, n_envs // max(1, workers))
        return Engine(workers, worlds, self.learner_gpus or 0)

    def or_of(self, other: Engine) -> Engine:
        """Return it with the other's numbers in place of None."""
        given = {name: value for name, value in asdict(self).items() if value is not None}
        return replace(other, **given)

    def to_plain(self) -> dict[str, Any]:
        """Return it as plain data."""
        return {"name": RLLIB, **asdict(self)}

    @classmethod
    def from_plain(cls, data: Mapping[str, Any] | None) -> Engine | None:
        """Make it from what ``to_plain`` returned; None, which is Stable-Baselines3, from None."""
        return None if data is None else cls(**{name: value for name, value in data.items() if name != "name"})


def engine_of(
    name: str | None, workers: int | None, worlds_per_worker: int | None, learner_gpus: int | None, address: str | None
) -> Engine | None:
    """Return the engine that the command line asks for; None for Stable-Baselines3.

    Raises:
        IrsimGymError: There is none of that name, or an option belongs to the other one.
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
