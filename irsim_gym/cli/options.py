"""Arguments and options of the command line, each declared once."""

from pathlib import Path
from typing import Annotated

import typer

from irsim_gym.base.imports import import_modules
from irsim_gym.cli import completion as cli_completion
from irsim_gym.cli.tools import read_count

LAST_SEED = 2**32 - 1  # largest seed of NumPy's legacy generator, which Stable-Baselines3 seeds
LAST_LEVEL = 2**53 - 1  # largest level of an environment
MOST_LEVELS = 10**9

Scenario = Annotated[
    str,
    typer.Argument(
        help="Shipped name, environment id, or path of a YAML file.", autocompletion=cli_completion.scenarios
    ),
]
Scenarios = Annotated[
    list[str],
    typer.Argument(
        metavar="SCENARIO",
        help="Shipped name, environment id, or path of a YAML file: a scenario, or a mixture of them.",
        autocompletion=cli_completion.scenarios,
    ),
]
Mixture = Annotated[
    bool,
    typer.Option(
        "--mixture",
        help="Train one policy in several scenarios: SCENARIO[:share=WEIGHT][:PARAMETER=VALUE]... for each.",
    ),
]
Task = Annotated[
    str | None,
    typer.Option(help="Shipped task or a file, instead of the scenario's own.", autocompletion=cli_completion.tasks),
]
Levels = Annotated[int, typer.Option(min=1, max=MOST_LEVELS, help="Number of levels.")]
Split = Annotated[
    str, typer.Option(help="Split of the levels: train, dev or test.", autocompletion=cli_completion.splits)
]
Steps = Annotated[
    int | None,
    typer.Option(
        parser=read_count,
        metavar="STEPS",
        help="Training steps over all worlds, e.g. 500_000 or 1e6, instead of the file's; whole rollouts are finished.",
    ),
]
MoreSteps = Annotated[
    int | None,
    typer.Option(
        parser=read_count,
        metavar="STEPS",
        help="With --resume: let a finished run go on for so many steps. Schedules fall to 0 at the new end.",
    ),
]
Until = Annotated[
    float | None, typer.Option(max=100.0, help="End the run at a checkpoint with this success on dev levels [%].")
]
Changes = Annotated[
    list[str] | None,
    typer.Option(
        "--hp",
        metavar="KEY=VALUE",
        help="Change a hyper-parameter, e.g. learning_rate=1e-3 or policy_kwargs.net_arch=[64,64]; may be repeated.",
    ),
]
Seed = Annotated[int, typer.Option(min=0, max=LAST_SEED, help="Seed of networks, exploration and training levels.")]
Seeds = Annotated[
    int | None,
    typer.Option(
        min=1,
        help="Train this number of seeds, starting with --seed, with their runs in one folder, and summarize them.",
    ),
]
TestLevels = Annotated[int, typer.Option(min=1, help="Number of test levels for the summary of --seeds.")]
Reference = Annotated[
    str | None,
    typer.Argument(
        help="random, a behavior such as dash (the default), rvo, sfm or orca, a run's folder or a policy.zip.",
        autocompletion=cli_completion.policies,
    ),
]
Watched = Annotated[
    str | None,
    typer.Argument(
        help="Drives until you press x: a shipped policy, a run's folder, a policy.zip or a behavior.",
        autocompletion=cli_completion.policies,
    ),
]
Given = Annotated[
    list[str] | None,
    typer.Option(
        "--set", metavar="NAME=VALUE", help="Set a parameter of the scenario, e.g. n_robots=8; may be repeated."
    ),
]
Perturbed = Annotated[
    list[str] | None,
    typer.Option(
        "--perturb",
        metavar="NAME:KEY=VALUE",
        help="Disturb the learners, e.g. latency:time=0.2 or slip:ahead=0.05:turn=0.05; may be repeated.",
    ),
]
Team = Annotated[
    bool, typer.Option("--team", help="Let the policy drive all robots (or those that the task names) instead of one.")
]
Lenient = Annotated[bool, typer.Option("--lenient", help="Ignore unknown keys of the file, with a warning.")]
Imports = Annotated[
    list[str] | None,
    typer.Option(
        "--import",
        callback=import_modules,
        is_eager=True,
        metavar="MODULE|FILE.py",
        help="Import a module first, e.g. to register your own behaviours; may be repeated.",
    ),
]


def _lower(name: str | None) -> str | None:
    return None if name is None else name.lower()


Algorithm = Annotated[
    str | None,
    typer.Option(
        callback=_lower,
        help="ppo, sac, td3, tqc, dqn, a2c or gru_ppo; ppo or appo with --engine rllib (default: ppo, "
        "or that of --from).",
        autocompletion=cli_completion.algorithms,
    ),
]
RunFolder = Annotated[
    Path | None,
    typer.Option(
        help="Folder of the run (default: runs/SCENARIO-ALGORITHM[-TEAM]-SEED, plus settings that differ from the "
        "defaults)."
    ),
]
Hyperparameters = Annotated[
    Path | None, typer.Option(help="YAML file of hyper-parameters, laid over the shipped ones.")
]
Resume = Annotated[bool, typer.Option("--resume", help="Continue the run in the folder.")]
ReplaceFile = Annotated[bool, typer.Option("--overwrite", help="Replace an existing file.")]
BeginAnew = Annotated[bool, typer.Option("--overwrite", help="Replace the run in the folder.")]
Origin = Annotated[
    str | None,
    typer.Option(
        "--from",
        metavar="RUN",
        help="Start with the weights of a run's folder or policy.zip.",
        autocompletion=cli_completion.policies,
    ),
]
Device = Annotated[
    str | None, typer.Option(help="Device of the networks: auto, cpu, cuda, cuda:1, mps (default: the file's).")
]
DevLevels = Annotated[
    int, typer.Option(min=0, help="Number of dev levels to score each checkpoint on; 0 skips scoring.")
]
TeamMode = Annotated[
    str | None,
    typer.Option(
        help="Train one policy for all robots. When its episode ends, a robot waits (episode) or restarts (respawn)."
    ),
]

EngineName = Annotated[
    str | None,
    typer.Option("--engine", help="sb3 (Stable-Baselines3, the default) or rllib (Ray, in several processes)."),
]
Workers = Annotated[
    int | None, typer.Option(min=0, max=10_000, help="With --engine rllib: processes that sample (default: 2).")
]
WorldsPerWorker = Annotated[
    int | None,
    typer.Option(min=1, max=10**6, help="With --engine rllib: worlds of each worker (default: n_envs over all)."),
]
LearnerGpus = Annotated[
    int | None,
    typer.Option(min=0, max=1000, help="With --engine rllib: graphics cards with a learner each (default: 0)."),
]
Address = Annotated[
    str | None,
    typer.Option(help="Address of a Ray cluster, e.g. ray://head:10001 or auto (default: start Ray on this machine)."),
]
