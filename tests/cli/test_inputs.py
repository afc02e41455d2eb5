"""Wrong arguments of commands: what is told, all of it at once, and before anything is played or written."""

from __future__ import annotations

import pickle
from pathlib import Path

import pytest
from command_line import run

from irsim_gym.base.errors import report_together
from irsim_gym.errors import IrsimGymError, SeveralProblemsError
from irsim_gym.evaluation.saved_policies.policy_places import cure_of, missing_policy, runs_below

SCENARIO = "no scenario named 'cluttered_rom' (did you mean 'cluttered_room'?)"
TASK = "no task named 'navigaton' (did you mean 'navigation'?)"
POLICY = "no policy named 'dsah' (did you mean 'dash'?)"
SPLIT = "no split named 'tets' (did you mean 'test'?)"
NOWHERE = "no policy at runs/nowhere: no such file or folder"
WORLD = ("--task", "navigaton", "--split", "tets")


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The working directory of a reader who has trained twice."""
    monkeypatch.chdir(tmp_path)
    for folder in ("runs/cluttered_room-ppo-0", "runs/five/seed_1", "runs/empty"):
        (tmp_path / folder).mkdir(parents=True)
    for folder in ("runs/cluttered_room-ppo-0", "runs/five/seed_1"):
        (tmp_path / folder / "policy.zip").write_text("nothing")
    (tmp_path / "file.txt").write_text("nothing")
    (tmp_path / "broken.npz").write_text("nothing")
    (tmp_path / "broken.yaml").write_text("world: [")
    return tmp_path


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (("evaluate", "cluttered_rom", "dsah", "runs/nowhere", *WORLD), (SCENARIO, TASK, POLICY, NOWHERE, SPLIT)),
        (("evaluate", "cluttered_rom", "dash", "--out", "file.txt"), (SCENARIO, "file.txt is a file")),
        (("evaluate", "cluttered_room", "--task", "broken.yaml", "mine=dash,dsah"), ("not valid YAML", POLICY)),
        (
            ("record", "cluttered_rom", "dsah", *WORLD, "--out", "film.avi"),
            (SCENARIO, TASK, POLICY, SPLIT, "a film's name ends in .mp4 or .gif, got 'film.avi'"),
        ),
        (("record", "cluttered_rom", "dash", "--html", "--out", "film.mp4"), (SCENARIO, "ends in .html")),
        (("record", "cluttered_rom", "file.txt", "broken.npz"), (SCENARIO, "file.txt is not a", "broken.npz is no")),
        (
            ("play", "cluttered_rom", "dsah", *WORLD, "--record", "file.txt"),
            (SCENARIO, TASK, SPLIT, POLICY, "must be .npz files"),
        ),
        (
            ("arena", "cluttered_rom", "dsah", "dash", *WORLD, "--out", "file.txt"),
            (SCENARIO, TASK, POLICY, SPLIT, "file.txt is a file"),
        ),
        (
            ("draw", "cluttered_rom", *WORLD, "--out", "file.txt"),
            (SCENARIO, TASK, SPLIT, "must be a .png, .pdf or .svg file"),
        ),
        (("describe", "cluttered_rom", "--task", "navigaton"), (SCENARIO, TASK)),
        (("run", "cluttered_rom", "--film", "film.avi"), (SCENARIO, "a film's name ends in")),
        (("warmup", "cluttered_rom", "circle_swp"), (SCENARIO, "(did you mean 'circle_swap'?)")),
        (
            ("levels", "draw", "cluttered_rom", "--out", "file.txt", "--task", "navigaton", "--split", "tets,dve"),
            (SCENARIO, TASK, SPLIT, "(did you mean 'dev'?)", "a file of levels ends in .npz"),
        ),
        (("levels", "certify", "cluttered_rom", "dsah", *WORLD), (SCENARIO, TASK, POLICY, SPLIT)),
        (("suite", "run", "coer", "dsah", "--split", "tets"), ("did you mean 'core'", POLICY, SPLIT)),
        (
            ("policies", "export", "runs/nowhere", "my name", "--results", "none.json", "--out", "file.txt"),
            (NOWHERE, "got 'my name'", "no file none.json", "file.txt is a file"),
        ),
        (("policies", "show", "none.npz"), ("no file none.npz; `irsim-gym policies list` names",)),
        (("policies", "show", "broken.npz"), ("`irsim-gym policies export` writes broken.json",)),
    ],
    ids=lambda value: " ".join(value) if isinstance(value, tuple) else None,
)
@pytest.mark.usefixtures("here")
def test_all_problems_are_told_at_once(
    arguments: tuple[str, ...],
    said: tuple[str, ...],
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    before = sorted(Path().rglob("*"))
    assert run(monkeypatch, *arguments) == 1
    told = capsys.readouterr()
    assert [text for text in said if text not in told.err] == []
    assert told.out == ""
    assert sorted(Path().rglob("*")) == before


@pytest.mark.usefixtures("here")
def test_all_problems_of_a_training_are_told_at_once(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    wrong = {
        "--task": ("navigaton", TASK),
        "--algorithm": ("pop", "no algorithm named 'pop' (did you mean 'ppo'?)"),
        "--hyperparameters": ("none.yaml", "no such file"),
        "--device": ("cudda", "got 'cudda' (did you mean 'cuda'?)"),
        "--team": ("epsode", "(did you mean 'episode'?)"),
        "--from": ("runs/nowhere", NOWHERE),
        "--out": ("file.txt", "file.txt is a file"),
    }
    given = [word for option, (value, _) in wrong.items() for word in (option, value)]
    assert run(monkeypatch, "train", "cluttered_rom", *given) == 1
    told = capsys.readouterr().err
    assert [text for text in (SCENARIO, *(text for _, text in wrong.values())) if text not in told] == []
    assert run(monkeypatch, "train", "cluttered_room", "--from", "dash") == 1
    assert "dash is a behavior, which has no weights: name the folder of a run" in capsys.readouterr().err
    assert run(monkeypatch, "train", "cluttered_room", "--hyperparameters", "broken.yaml", "--from", "runs/empty") == 1
    told = capsys.readouterr().err
    assert "not valid YAML" in told
    assert "the folder holds neither policy.zip nor a checkpoint" in told


@pytest.mark.usefixtures("here")
def test_a_run_that_is_not_there_is_answered_with_those_that_are() -> None:
    assert missing_policy("runs/cluttered_room-pp-0") == (
        "no policy at runs/cluttered_room-pp-0: no such file or folder (did you mean 'runs/cluttered_room-ppo-0'?)"
    )
    assert missing_policy("cluttered_room-ppo-0") == (
        "no policy named 'cluttered_room-ppo-0' (did you mean 'runs/cluttered_room-ppo-0'?)"
    )
    assert "did you mean 'runs/five/seed_1/policy.zip'" in missing_policy("runs/five/seed_2/policy.zip")
    assert [str(run) for run in runs_below()] == ["runs/cluttered_room-ppo-0", "runs/five/seed_1"]
    cure = cure_of(["runs/nowhere"])
    assert cure.startswith("  runs here: runs/cluttered_room-ppo-0, runs/five/seed_1\n")
    assert "circle_swap" not in cure  # names of scenarios and shipped policies do not help there
    assert cure_of(["runs/five"]).startswith("  runs here: runs/five/seed_1\n")


def test_without_a_run_the_command_that_makes_one_is_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    assert cure_of(["runs/nowhere"]).startswith("  no run is here yet: irsim-gym train makes one\n")
    for number in range(9):
        (tmp_path / f"runs/run_{number}").mkdir(parents=True)
        (tmp_path / f"runs/run_{number}/policy.zip").touch()
    assert "runs/run_5 and 3 more" in cure_of(["runs/nowhere"])


def test_unknown_and_wrong_parameters_are_told_together(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(monkeypatch, "describe", "circle_swap", "--set", "n_robot=8", "--set", "jitter=9") == 1
    told = capsys.readouterr().err
    assert (
        "circle_swap has no parameter 'n_robot' (did you mean 'n_robots'?); 'jitter' must be a number from 0 to 0.5"
        in told
    )
    assert "keyword argument" not in told


def test_problems_are_kept_apart() -> None:
    def refuse(text: str) -> None:
        raise IrsimGymError(text)

    with pytest.raises(IrsimGymError, match=r"^one$") as alone:
        report_together(lambda: refuse("one"), lambda: refuse("one"), lambda: None)
    assert type(alone.value) is IrsimGymError
    with pytest.raises(SeveralProblemsError) as both:
        report_together(lambda: report_together(lambda: refuse("one"), lambda: refuse("two")), lambda: refuse("three"))
    again = pickle.loads(pickle.dumps(both.value))
    assert str(again) == "one\ntwo\nthree"
    assert [str(problem) for problem in again.problems] == ["one", "two", "three"]
