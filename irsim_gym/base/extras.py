"""What parts of the package need that it does not install by itself."""

from importlib.util import find_spec

from irsim_gym.base.errors import MissingExtraError

LEARNING = ("torch", "stable_baselines3", "tensorboard")
MORE = {"train": (), "contrib": ("sb3_contrib",), "tune": ("optuna",), "rllib": ("ray",)}
EXTRAS = {extra: (*LEARNING, *more) for extra, more in MORE.items()}
EXTRAS |= {"robot": ("onnx", "onnxruntime", "rosbags"), "ompl": ("ompl",)}
"""The modules that each extra brings and that this package imports."""


def missing(extra: str) -> tuple[str, ...]:
    """Return the modules of an extra that are not installed."""
    return tuple(module for module in EXTRAS[extra] if find_spec(module) is None)


def pip_command(extra: str) -> str:
    """Return the command that installs an extra."""
    return f'pip install "irsim_gym[{extra}]"'


def require(extra: str, what: str) -> None:
    """Make sure that an extra is installed.

    Args:
        extra: One of ``EXTRAS``.
        what: What needs it, as the message begins.

    Raises:
        MissingExtraError: It is not; the message names the extra, what is missing and the command that installs it.
    """
    absent = missing(extra)
    if absent:
        raise MissingExtraError(
            f"{what} needs the extra '{extra}' ({', '.join(absent)} not found): {pip_command(extra)}"
        )
