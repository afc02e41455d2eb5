"""Monitoring of a training: clock, progress bar, log, checkpoints, and a clean stop."""

import time
from collections.abc import Callable

from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn, TimeRemainingColumn
from stable_baselines3.common.callbacks import BaseCallback
from stable_baselines3.common.logger import Logger, TensorBoardOutputFormat

from irsim_gym.evaluation.requests.interruption import StopRequest
from irsim_gym.evaluation.saved_policies.checkpoint_files import RunProgress
from irsim_gym.training.settings.run import Run

LOG_ROWS = 200
"""Approximate number of rows in the training log."""


class StopLearningError(Exception):
    """Raised between two updates, after writing a checkpoint, to end the learning."""


class Clock:
    """Measures the wall-clock time and the processor time of training alone.

    Args:
        seconds: Wall-clock time so far [s].
        cpu_seconds: Processor time so far [s].
    """

    def __init__(self, seconds: float, cpu_seconds: float) -> None:
        self._before = (seconds, cpu_seconds)
        self._start: tuple[float, float] | None = None

    def start(self) -> None:
        """Start to measure."""
        self._start = (time.perf_counter(), time.process_time())

    def stop(self) -> None:
        """Stop measuring. Can be called twice."""
        self._before, self._start = self.read(), None

    def read(self) -> tuple[float, float]:
        """Return the wall-clock time and the processor time so far [s]."""
        if self._start is None:
            return self._before
        wall, cpu = time.perf_counter() - self._start[0], time.process_time() - self._start[1]
        return self._before[0] + wall, self._before[1] + cpu


def tensorboard_logger(run: Run) -> Logger:
    """Return the logger of a run, which writes files for TensorBoard."""
    return Logger(str(run.folder), [TensorBoardOutputFormat(str(run.folder / "tensorboard"))])


class TrainingBar:
    """Progress bar of a run.

    Args:
        total: Number of steps of the whole run.
    """

    def __init__(self, progress: RunProgress, total: int, console: Console) -> None:
        self._total, self._console = total, console
        self._begun = (progress.steps, progress.training_seconds)
        rates = TextColumn("{task.fields[speed]} steps/s  success {task.fields[success]}")
        parts = (TextColumn("{task.fields[steps]} steps"), BarColumn(), rates, TimeRemainingColumn())
        self._bar = Progress(*parts, console=console, disable=not console.is_terminal)
        self._line = self._bar.add_task(
            "training", total=total, completed=progress.steps, steps="0", speed="-", success="-"
        )

    def start(self) -> None:
        """Show the bar."""
        self._bar.start()

    def stop(self) -> None:
        """Close the progress bar. Can be called twice."""
        self._bar.stop()

    def show(self, progress: RunProgress, success: float | None) -> None:
        """Update the bar.

        Args:
            success: Share of recent episodes that succeeded; None if no episode has ended.
        """
        seconds = progress.training_seconds - self._begun[1]
        speed = (progress.steps - self._begun[0]) / seconds if seconds > 0.0 else 0.0
        won, done = "-" if success is None else f"{success:.0%}", f"{progress.steps:,}"
        self._bar.update(self._line, completed=progress.steps, steps=done, speed=f"{speed:,.0f}", success=won)

    def print_line(self, progress: RunProgress, success: float | None) -> None:
        """Print a line with the progress and the recent success, if the console is not a terminal."""
        if self._console.is_terminal:
            return
        recent = "" if success is None else f", success {success:.0%} of recent training episodes"
        line = f"{progress.steps:,} of {self._total:,} steps after {progress.training_seconds:,.0f} s{recent}"
        self._console.print(line, markup=False, highlight=False, soft_wrap=True)


class TrainingMonitor(BaseCallback):
    """The callback that monitors a run.

    Args:
        progress: Progress of the run, which the callback updates.
        total: Number of steps of the whole run.
        checkpoint_every: Number of steps between checkpoints.
        save: Function that writes a checkpoint.
        stop: Request to stop.
        console: Console for the progress bar; if it is not a terminal, for a line at each checkpoint.
    """

    def __init__(
        self,
        progress: RunProgress,
        total: int,
        checkpoint_every: int,
        save: Callable[[], object],
        stop: StopRequest,
        console: Console,
    ) -> None:
        super().__init__()
        self.progress, self.total, self.save_checkpoint, self.stop = progress, total, save, stop
        self.checkpoint_every = checkpoint_every
        self.next_checkpoint = (progress.steps // checkpoint_every + 1) * checkpoint_every
        self.clock = Clock(progress.training_seconds, progress.cpu_seconds)
        self.bar = TrainingBar(progress, total, console)

    def _on_training_start(self) -> None:
        self.bar.start()
        self.clock.start()

    def _on_rollout_start(self) -> None:
        """Update the progress, and save or stop if due. Between an update and the next rollout, the state is complete.

        Raises:
            StopLearningError: If a signal requests a stop. A checkpoint is written first.
        """
        self.update_progress()
        if self.stop.signal is not None:
            self._save()
            raise StopLearningError
        if self.progress.steps >= self.next_checkpoint and self.progress.steps < self.total:
            self._save()
            self.next_checkpoint += self.checkpoint_every

    def _on_step(self) -> bool:
        return True

    def update_progress(self) -> None:
        """Update the progress, the log and the bar."""
        progress, model = self.progress, self.model
        progress.steps = model.num_timesteps
        progress.training_seconds, progress.cpu_seconds = self.clock.read()
        logged = progress.history[-1]["steps"] if progress.history else 0
        if progress.steps - logged < self.total / LOG_ROWS:
            return
        row = {"steps": progress.steps, "training_seconds": progress.training_seconds}
        episodes, successes = model.ep_info_buffer, model.ep_success_buffer
        if episodes:
            row["episode_return"] = sum(float(episode["r"]) for episode in episodes) / len(episodes)
            row["episode_steps"] = sum(float(episode["l"]) for episode in episodes) / len(episodes)
        if successes:
            row["success"] = sum(successes) / len(successes)
        share = getattr(self.training_env.unwrapped, "idle_share", None)
        if share is not None:
            row["idle_share"] = share
        progress.history.append(row)
        self.bar.show(progress, row.get("success"))

    def print_line(self) -> None:
        """Print a line with the progress, see ``TrainingBar.print_line``."""
        successes = self.model.ep_success_buffer
        self.bar.print_line(self.progress, sum(successes) / len(successes) if successes else None)

    def finish(self) -> None:
        """Stop the clock, and close the progress bar. Can be called twice."""
        self.clock.stop()
        self.bar.stop()

    def _save(self) -> None:
        self.clock.stop()
        self.save_checkpoint()
        self.print_line()
        self.clock.start()
