"""The arguments of ``irsim-gym train``, and the settings and the folder of the run that follow from them."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Self

from irsim_gym.base.errors import IrsimGymError
from irsim_gym.base.families import ACTIONS
from irsim_gym.evaluation.policies.perception import perception_differences
from irsim_gym.evaluation.saved_policies.algorithms import MASKED, find_algorithm
from irsim_gym.evaluation.saved_policies.policies import policy_names
from irsim_gym.evaluation.saved_policies.run_folder import lasting
from irsim_gym.evaluation.saved_policies.snapshot import listed
from irsim_gym.scenario.reading.load import load_scenario
from irsim_gym.scenario.specs.ids import scenario_name
from irsim_gym.tasks import load_task
from irsim_gym.tasks.terms.term import IsImage
from irsim_gym.training.settings.folders import default_folder, existing_folders, free_folder, setting_differences
from irsim_gym.training.settings.hyperparameter_files import change_hyperparameters
from irsim_gym.training.settings.hyperparameters import Hyperparameters, load_hyperparameters
from irsim_gym.training.settings.mixture import Mixture, MixturePart
from irsim_gym.training.settings.run import Run, Settings, environment_id

Parameters = Mapping[str, object] | None


@dataclass(frozen=True)
class TrainingRequest:
    """The arguments of ``irsim-gym train``.

    Attributes:
        scenario: Shipped name, environment id, or path of a scenario file.
        algorithm: Name of the algorithm; None for that of ``origin``, or PPO without one.
        seed: Seed of networks, exploration and levels.
        steps: Number of training steps; None for that of the hyper-parameter file.
        task: Shipped name or path of a task; None for the scenario's own.
        hyperparameters: Path of a hyper-parameter file, which is laid over the shipped one; None for none.
        team: Team mode, ``"episode"`` or ``"respawn"``; None for that of the hyper-parameter file.
        parameters: Values for the scenario's parameters.
        strict: Whether unused keys of the scenario are an error; False ignores them.
        device: Device of the networks; None for that of the hyper-parameter file.
        origin: Policy to start from: a run's folder or a ``policy.zip``.
        mixture: Scenarios that are trained together. ``scenario`` is the first of them.
        mixture_name: Name of the file that lists them; None without one.
        changes: Single changes of hyper-parameters by key, text as YAML; ``policy_kwargs.net_arch`` is in a mapping.
        until: Success on ``dev`` levels [%] at which a checkpoint ends the run; None for that of the hyper-parameters.
    """

    scenario: str
    algorithm: str | None = None
    seed: int = 0
    steps: int | None = None
    task: str | None = None
    hyperparameters: Path | None = None
    team: str | None = None
    parameters: Parameters = None
    strict: bool = True
    device: str | None = None
    origin: str | None = None
    mixture: tuple[MixturePart, ...] = ()
    mixture_name: str | None = None
    changes: Mapping[str, object] | None = None
    until: float | None = None

    def with_mixture(self, mixture: Mixture) -> Self:
        """Return a request to train a mixture. What this one states replaces what the mixture's file states."""
        task, algorithm = self.task or mixture.task, self.algorithm or mixture.algorithm
        parts: dict[str, Any] = {"mixture": mixture.parts, "mixture_name": mixture.name, "algorithm": algorithm}
        parts |= {"task": task, "hyperparameters": self.hyperparameters or mixture.hyperparameters}
        return replace(self, scenario=mixture.parts[0].scenario, **parts)

    @property
    def overrides(self) -> dict[str, Any]:
        """Hyper-parameters that have an option of their own."""
        options = {"n_timesteps": self.steps, "team": self.team, "device": self.device, "until": self.until}
        return {name: value for name, value in options.items() if value is not None}

    def settings(self) -> Settings:
        """Return the settings of the run, with the hyper-parameters of the file.

        Raises:
            IrsimGymError: If an argument is invalid, or arguments contradict each other.
        """
        if self.origin is None:
            return self._settings(self.algorithm or "ppo")
        from irsim_gym.training.runs.fine_tuning import algorithm_of, inherit_settings, load_origin

        file, policy = load_origin(self.origin)
        return inherit_settings(self._settings(self.algorithm or algorithm_of(policy)), file, policy)

    def _settings(self, algorithm: str) -> Settings:
        """Return the settings of a run that starts with random weights."""
        if not self.mixture:
            return self._scenario_settings(algorithm)
        if self.parameters:
            raise IrsimGymError("--set is for one scenario: with --mixture write SCENARIO:NAME=VALUE")
        settings = [
            replace(self, scenario=part.scenario, parameters=part.parameters, mixture=())._scenario_settings(algorithm)
            for part in self.mixture
        ]
        mixed_up = perception_differences({part.scenario: part.perception() for part in settings})
        if mixed_up:
            raise IrsimGymError(f"one policy needs one perception, but {listed(mixed_up)}; --task lets all see alike")
        pairs = zip(self.mixture, settings, strict=True)
        mixed = tuple(MixturePart(one.scenario, one.parameters, part.share) for part, one in pairs)
        return replace(settings[0], mixture=mixed)

    def _scenario_settings(self, algorithm: str) -> Settings:
        """Return the settings for a single scenario."""
        named = lasting(scenario_name(self.scenario))
        chosen = find_algorithm(algorithm)
        loaded = load_scenario(named, self.parameters, strict=self.strict, warn=False)
        learned = load_task(loaded, self.task)
        chosen.check_action(learned.action, ACTIONS.name_of(type(learned.action)))
        names = algorithm, environment_id(self.scenario)
        chosen_file: dict[str, Any] = {"task": self.task_name, "file": self.hyperparameters, "changes": self.changes}
        chosen_file["images"] = any(isinstance(term, IsImage) for term in learned.observations)
        hyperparameters = load_hyperparameters(*names, **chosen_file, overrides=self.overrides)
        task = None if self.task is None else lasting(self.task)
        settings = Settings(named, algorithm, self.seed, task, hyperparameters, loaded.parameters, self.strict)
        if hyperparameters.team == "episode" and algorithm not in MASKED:
            ways = f"--team respawn, where none waits, or {', '.join(MASKED)}"
            raise IrsimGymError(f"{algorithm} learns from robots that wait as if they acted: take {ways}")
        if settings.is_team:  # its robots have to fit each other, too
            settings.load_task()
        return settings

    def folder(self, settings: Settings) -> Path:
        """Return the default folder of a run. Its name contains the settings that differ from the defaults."""
        task = self.task_name
        marks = [] if task is None else [task]
        file = self.hyperparameters
        marks += [] if file is None or file.stem == settings.algorithm else [file.stem]
        marks += [] if self.steps is None else [f"steps={self.steps}"]
        marks += [f"{name}={value}" for name, value in (self.changes or {}).items()]
        marks += [] if self.until is None else [f"until={self.until:g}"]
        marks += [] if self.origin is None else [f"from={policy_names([self.origin])[0]}"]
        mode = settings.hyperparameters.team
        if self.mixture:
            parts = [replace(part, scenario=scenario_name(part.scenario)) for part in self.mixture]
            named = self.mixture_name or "+".join(part.label for part in parts)
            return default_folder(f"{named}.yaml", settings.algorithm, self.seed, None, mode, marks=marks)
        return default_folder(self.scenario, settings.algorithm, self.seed, self.parameters, mode, marks=marks)

    @property
    def task_name(self) -> str | None:
        """Name of the task; None for the scenario's own."""
        return None if self.task is None else Path(self.task).stem

    def resumed_settings(self, run: Run, settings: Settings) -> Settings:
        """Return the settings that a run was started with. Later changes of the shipped files do not affect them.

        Raises:
            IrsimGymError: If the run was started with other settings.
        """
        begun = run.settings()
        requested = replace(
            settings,
            origin=begun.origin if self.origin is None else settings.origin,
            algorithm=begun.algorithm if self.algorithm is None else settings.algorithm,
            hyperparameters=self._hyperparameters_of(begun, settings),
        )
        other = setting_differences(begun, requested)
        if other:
            raise IrsimGymError(
                f"{run.folder} holds a run with {listed(other)}: its schedule cannot change during a run; choose "
                f"another folder with --out, or start from its policy with other settings with --from {run.folder}"
            )
        return begun

    def _hyperparameters_of(self, begun: Settings, settings: Settings) -> Hyperparameters:
        """Return the hyper-parameters of a run, with those that the user sets."""
        if self.hyperparameters is not None:
            return replace(settings.hyperparameters, device=begun.hyperparameters.device)
        changes = {name: value for name, value in self.overrides.items() if name != "device"}
        values = begun.hyperparameters.to_plain()
        if self.changes:
            values = change_hyperparameters(values, self.changes, find_algorithm(begun.algorithm))
        return replace(Hyperparameters.from_plain(values), **changes)

    def choose_folder(self, settings: Settings, resume: bool, overwrite: bool) -> tuple[Path, str]:
        """Choose the folder of a run if the user names none, and return it with a remark, which may be empty.

        Args:
            resume: Choose the newest run of the default name with these settings; unfinished runs take precedence.
            overwrite: Choose the default folder, even if it holds a run.
        """
        first = self.folder(settings)
        if overwrite:
            return first, ""
        if not resume:
            return free_folder(first, settings, settings.snapshot())
        begun = existing_folders(first)
        fitting = [folder for folder in begun if self._fits(Run(folder), settings)]
        unfinished = [folder for folder in fitting if not Run(folder).finished()]
        return (unfinished or fitting or begun or [first])[-1], ""

    def _fits(self, run: Run, settings: Settings) -> bool:
        try:
            self.resumed_settings(run, settings)
        except IrsimGymError:
            return False
        return True
