"""Keywords of Stable-Baselines3's own ``make_vec_env``: what they mean for worlds that are stepped together."""

from typing import Any

from irsim_gym.base.errors import IrsimGymError

SINGLES = "stable_baselines3.common.env_util.make_vec_env(id, ...) takes it and steps single environments"
FOR_SINGLES = {
    "wrapper_class": f"wraps single environments, which a batch does not have: {SINGLES}; around a batch goes a "
    "VecEnvWrapper, such as VecFrameStack",
    "wrapper_kwargs": f"is for a wrapper of single environments, which a batch does not have: {SINGLES}",
    "vec_env_cls": f"puts single environments together, and a batch is a VecEnv itself, with num_threads: {SINGLES}",
    "vec_env_kwargs": f"is for a VecEnv of single environments, and a batch is one itself, with num_threads: {SINGLES}",
}
FILES = (
    "is for files of single environments; stable_baselines3.common.vec_env.VecMonitor(env, FILE) writes one of a batch"
)
ELSEWHERE = {
    **FOR_SINGLES,
    **dict.fromkeys(("monitor_dir", "monitor_kwargs", "start_index"), FILES),
    "env_kwargs": "holds keywords of this function: pass them directly",
}
"""What is said of keywords that this function does not take."""


def refuse_for_singles(parameters: dict[str, Any]) -> None:
    """Take what is for single environments out of keywords that are left over, where nothing is asked for.

    Raises:
        IrsimGymError: Something is; the message says who does it.
    """
    for name, reason in ELSEWHERE.items():
        if parameters.pop(name, None):
            raise IrsimGymError(f"{name} {reason}")
