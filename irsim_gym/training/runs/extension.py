"""Longer training of a finished run."""

from dataclasses import replace

from irsim_gym.base.errors import IrsimGymError
from irsim_gym.evaluation.saved_policies.checkpoint_files import OFF_POLICY, load_progress, newest_checkpoint
from irsim_gym.training.settings.run import Run


def extend(run: Run, steps: int, until: float | None) -> str:
    """Let a finished run go on for more steps when it is resumed, and return a sentence about its schedules.

    Args:
        steps: Number of steps after those that it has taken.
        until: Success on ``dev`` levels [%] at which a checkpoint ends it again; None to take all steps.

    Raises:
        IrsimGymError: The run is not finished, or what it needs to go on is not on disk.
    """
    settings, newest = run.settings(), newest_checkpoint(run.checkpoints)
    hyper = settings.hyperparameters
    if not run.finished():
        raise IrsimGymError(f"--more-steps is for finished runs, and {run.folder} is not: go on with --resume alone")
    if newest is None or settings.algorithm in OFF_POLICY:
        why = "its replay buffer is not kept" if settings.algorithm in OFF_POLICY else "there is no state to go on from"
        raise IrsimGymError(f"{run.folder} cannot go on: {why}; --from {run.folder} starts a new run with its policy")
    before = load_progress(newest).steps
    total = before + steps
    run.change(replace(settings, hyperparameters=replace(hyper, n_timesteps=total, until=until)))
    run.policy.unlink()
    falling = [key for key, value in hyper.arguments.items() if isinstance(value, str) and value.startswith("lin_")]
    schedules = f"; {', '.join(falling)} goes on at {1 - before / total:.0%} of its start, to 0" if falling else ""
    return f"going on from {before:,} to {total:,} steps{schedules}"
