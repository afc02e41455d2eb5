import json
import os
import re
import runpy
import signal
import subprocess
import sys
from pathlib import Path

import pytest
from command_line import run

import irsim_gym
from irsim_gym.base import families
from irsim_gym.cli.options import LAST_LEVEL
from irsim_gym.envs.parts.level_options import read_options
from irsim_gym.evaluation.suite.members import shipped_suite
from irsim_gym.scenario.reference.summary import FileSummary, summarize_file
from irsim_gym.scenario.specs.spec import Scenario

BROKEN = "world: {height: 10, step_tme: 0.1}\nrobot: {shape: {name: circle, radius: -1}}\n"
PAIR = """\
robot:
  number: 2
  kinematics: {name: diff}
  distribution: {name: circle, radius: 3, center: [5, 5]}
task:
  team_reward: 0.6
"""


def test_the_module_is_the_command(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    monkeypatch.setattr(sys, "argv", ["irsim_gym", "--version"])
    monkeypatch.delitem(sys.modules, "irsim_gym.__main__", raising=False)  # another test may have imported it
    with pytest.raises(SystemExit) as end:
        runpy.run_module("irsim_gym", run_name="__main__")
    assert end.value.code == 0
    assert capsys.readouterr().out == f"irsim_gym {irsim_gym.__version__}\n"


def test_ctrl_c_while_packages_are_loaded_is_no_traceback(tmp_path: Path) -> None:
    """A package that is loaded in its first moments sends it to its own process."""
    (tmp_path / "gymnasium.py").write_text("import os, signal\nos.kill(os.getpid(), signal.SIGINT)\n")
    places = os.pathsep.join([str(tmp_path), str(Path(irsim_gym.__file__).parents[1])])
    done = subprocess.run(
        [sys.executable, "-m", "irsim_gym", "list"],
        env={**os.environ, "PYTHONPATH": places},
        capture_output=True,
        text=True,
        check=False,
    )
    assert (done.returncode, done.stdout, done.stderr) == (-signal.SIGINT, "", "")


@pytest.mark.parametrize(
    ("name", "kinds", "line"),
    [
        ("reward", "rewards", "collision      Penalty"),
        ("behaviours", "behavior", "dash          Drive straight at the goal"),
        ("obstacle_map", "obstacle map", "maze      Corridors between walls"),
        ("sensors", "sensor", "lidar2d       A scanner with"),
    ],
)
def test_a_family_is_listed_with_a_line_for_each_kind(
    name: str, kinds: str, line: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(monkeypatch, "options", name) == 0
    lines = capsys.readouterr().out.splitlines()
    (family,) = (one for one in families.every() if one.family == kinds.removesuffix("s"))
    assert [one.split()[0] for one in lines] == list(family.names())
    assert any(one.startswith(line) for one in lines)
    assert run(monkeypatch, "options", kinds) == 0
    assert capsys.readouterr().out.splitlines() == lines


def test_list(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(monkeypatch, "list") == 0
    said = capsys.readouterr().out.splitlines()
    assert any("irsim_gym/NAME-v0" in line for line in said)
    rows = {line.split()[0]: line.split(maxsplit=1)[1] for line in said if line.startswith("  ")}
    assert rows["cluttered_room"] == "A closed room with eight to ten random obstacles"
    assert rows["circle_swap"].startswith("4 robots   Robots on a circle change sides")
    assert rows["social_forces"].startswith("7 robots ")  # 4 and 3
    assert rows["team_navigation"].startswith("Robots that learn together")
    place = said.index(next(line for line in said if line.startswith("  circle_swap ")))
    assert said[place + 1].strip() == "--set n_robots=4 --set jitter=0.4"
    assert all(len(line) <= 100 for line in said if not line.startswith(("scenarios in", "tasks in")))


def test_a_file_without_a_comment_is_listed_too(tmp_path: Path) -> None:
    file = tmp_path / "bare.yaml"
    file.write_text("world: {width: 3}\nrobot: {number: 2}\n# late\n")
    assert summarize_file(file) == FileSummary("", 2, {})
    file.write_text("# About\n# this; and more.\n# Not this\nobstacle: [1]\n")
    assert summarize_file(file) == FileSummary("About this", 0, {})


def test_check_tells_every_problem_and_goes_on(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    (tmp_path / "broken.yaml").write_text(BROKEN)
    assert run(monkeypatch, "check", tmp_path / "broken.yaml", tmp_path / "none.yaml", "cluttered_room") == 1
    said = capsys.readouterr()
    assert "did you mean 'step_time'" in said.err
    assert "radius" in said.err
    assert "none.yaml" in said.err
    assert "cluttered_room: fine (robots: 1" in said.out


def test_check_tells_what_a_team_would_be_refused_for(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    file = tmp_path / "pair.yaml"
    file.write_text(PAIR)
    assert run(monkeypatch, "check", file) == 0
    said = capsys.readouterr()
    assert f"{file}: fine for one learner (robots: 2" in said.out
    assert "where all robots learn together it is refused" in said.out
    assert f"{file}:6   task.team_reward: an episode that ends as 'collided' costs 2.8" in said.out
    assert run(monkeypatch, "check", "--team", file) == 1
    assert f"{file}:6   task.team_reward: an episode" in capsys.readouterr().err
    # Whom the task names learns in either case.
    file.write_text(PAIR + "  agents: robot_1\n")
    assert run(monkeypatch, "check", file) == 0
    assert f"{file}: fine (robots: 2" in capsys.readouterr().out


def test_check_counts_wandering_bodies_that_stand(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    # Two that overlap at the start never part; the third has nobody to touch.
    file = tmp_path / "stuck.yaml"
    poses = "[[2, 2, 0], [2.1, 2, 0], [8, 8, 0]]"
    wander = "behavior: {name: dash, wander: true, range_low: [7, 7, -3], range_high: [9, 9, 3]}"
    file.write_text(f"obstacle:\n  - {{number: 3, kinematics: {{name: omni}}, state: {poses}, {wander}}}\n")
    assert run(monkeypatch, "check", file) == 0
    told = f"{file}:2   obstacle_0: 2 of 3 wandering bodies stand after 60 s, since they touch: wander_goals"
    assert told in capsys.readouterr().out


def test_check_takes_a_file_that_is_made_to_be_run_but_not_one_whose_task_does_not_fit(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    file = tmp_path / "aimless.yaml"
    file.write_text("robot: {kinematics: {name: diff}}\n")
    assert run(monkeypatch, "check", file) == 0
    said = capsys.readouterr().out
    assert f"{file}: fine to run (robots: 1, obstacles: 0, no robot that can learn)" in said
    assert f"{file}:1   robot_0: has no goal" in said
    assert run(monkeypatch, "check", "--team", file) == 1
    capsys.readouterr()
    file.write_text("robot: {kinematics: {name: diff}}\ntask: {max_steps: 5}\n")
    assert run(monkeypatch, "check", file) == 1
    assert capsys.readouterr().err.count("robot_0: has no goal") == 1  # in reading and in playing alike
    blocked = "robot: {kinematics: {name: diff}, state: [5, 5, 0], goal: [9, 9]}\nobstacle: {state: [5, 5]}\n"
    file.write_text(blocked)  # it runs, too, and is no environment either
    assert run(monkeypatch, "check", file) == 0
    said = capsys.readouterr().out
    assert f"{file}: fine to run (robots: 1, obstacles: 1, no robot that can learn)" in said
    assert f"{file}:1   robot_0: the start lies in 'obstacle_1' (line 2)" in said
    for arguments in (["--team", file], [file]):
        assert run(monkeypatch, "check", *arguments) == 1
        file.write_text(blocked + "task: {max_steps: 5}\n")


SHAKY = """
import os
import irsim_gym

@irsim_gym.behavior("{stem}", kinematics=("diff",))
def shaky(ego, others, *, ends: str = "never"):
    print("deciding")
    if ego.time > 0.35 and ends == "abort":
        os.abort()
    if ego.time > 0.35 and ends == "exit":
        raise SystemExit(0)
    if ego.time > 0.35 and ends == "raise":
        raise KeyError("nowhere")
    return [0.5, 0.0]
"""


@pytest.fixture
def shaky(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """A folder with a module of a behaviour that fails, and with files that use it; registries stay as they were."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "path", list(sys.path))
    families.load()
    monkeypatch.setattr(families.BEHAVIORS, "_entries", dict(families.BEHAVIORS._entries))
    Path("shaky.py").write_text(SHAKY.format(stem="shaky"))
    for ends in ("never", "abort", "exit", "raise"):
        behavior = f"{{name: shaky, ends: {'$ends' if ends == 'never' else ends}}}"
        text = f"robot: {{kinematics: {{name: diff}}, goal: [9, 0], behavior: {behavior}}}\n"
        parameter = "parameters: {ends: {default: never, meaning: How.}}\n" if ends == "never" else ""
        Path(f"{ends}.yaml").write_text(parameter + text)


@pytest.mark.usefixtures("shaky")
def test_a_crash_in_check_shows_the_stack(tmp_path: Path) -> None:
    words = [sys.executable, "-m", "irsim_gym", "check", "abort.yaml", "--import", "shaky.py"]
    done = subprocess.run(words, capture_output=True, text=True, check=False)
    assert done.returncode == -signal.SIGABRT
    assert f'File "{tmp_path / "shaky.py"}", line 9 in shaky' in done.stderr


@pytest.mark.usefixtures("shaky")
def test_check_names_the_line_that_raised_an_error(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    assert run(monkeypatch, "check", "never.yaml", "raise.yaml", "exit.yaml", "--import", "shaky.py") == 1
    said = capsys.readouterr()
    assert said.out.splitlines()[0].startswith("never.yaml: fine (robots: 1")  # not what behaviours print
    assert [line.split(":")[0] for line in said.out.splitlines() if ": fine" in line] == ["never.yaml"]
    assert "exit.yaml: could not be played: SystemExit: 0" in said.err
    assert "raise.yaml: could not be played: KeyError: 'nowhere'" in said.err
    assert "in behavior 'shaky' for 'robot_0', step 5 of world 0" in said.err
    assert f"in {tmp_path / 'shaky.py'}:13" in said.err
    del sys.modules["shaky"]


def test_check_plays_teams_and_draws_levels(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    file = tmp_path / "full.yaml"
    file.write_text("world: {width: 3, height: 3}\nrobot: {number: 40, distribution: {name: random}}\n")
    assert run(monkeypatch, "check", file) == 1
    assert "no place found for 'robot_" in capsys.readouterr().err
    assert run(monkeypatch, "check", "four_drives", "circle_swap", "--team") == 0
    assert capsys.readouterr().out.count(": fine (robots") == 2


def test_schema_is_json(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(monkeypatch, "schema") == 0
    assert "world" in json.loads(capsys.readouterr().out)["properties"]


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["record", "cluterd_room", "dash"], "did you mean 'cluttered_room'"),
        (["train", "empty_goal", "--algorithm", "pppo"], "did you mean 'ppo'"),
        (["evaluate", "empty_goal", "runs/nowhere"], "no policy at runs/nowhere"),
        (["evaluate", "empty_goal", "--no-references"], "nothing to evaluate"),
        (["evaluate", "empty_goal", "--split", "tset"], "did you mean 'test'"),
        (["record", "empty_goal", "dash", "--out", "film.avi"], "ends in .mp4 or .gif"),
        (["run", "empty_goal", "--film", "film.avi"], "ends in .mp4, .gif or .html"),
        (["draw", "empty_goal", "--out", "file/picture.png"], "cannot use file"),
        (["run", "empty_goal", "--steps", "1", "--film", "file/film.gif"], "cannot use file"),
    ],
)
def test_mistakes_are_told_in_a_sentence(
    arguments: list[str], said: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("file").touch()
    assert run(monkeypatch, *arguments) == 1
    told = capsys.readouterr()
    assert said in told.err
    assert "level 0" not in told.out  # nothing was driven before
    assert [path.name for path in tmp_path.iterdir()] == ["file"]


@pytest.mark.parametrize(
    ("arguments", "last"),
    [
        (("train", "empty_goal", "--seed", 2**32), 2**32 - 1),
        (("demo", "--seed", 2**70), 2**32 - 1),
        (("record", "empty_goal", "dash", "--level", 2**53), 2**53 - 1),
        (("draw", "empty_goal", "--level", 2**70), 2**53 - 1),
        (("play", "empty_goal", "--seed", 2**63), 2**53 - 1),
        (("evaluate", "empty_goal", "--levels", 2**70), 10**9),
    ],
)
def test_numbers_beyond_what_can_be_seeded_are_told_with_the_last_one(
    arguments: tuple[object, ...], last: int, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(monkeypatch, *arguments) == 2
    told = capsys.readouterr().err
    assert str(arguments[-2]) in told
    assert str(last) in told


def test_a_run_takes_any_seed(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    ends = []
    for seed in (2**70 + 5, 5):
        assert run(monkeypatch, "run", "empty_goal", "--seed", seed, "--steps", "1") == 0
        ends.append(capsys.readouterr().out)
    assert ends[0] == ends[1]


def test_the_last_level_is_that_of_environments() -> None:
    assert read_options({"level": LAST_LEVEL}) == (None, LAST_LEVEL)
    with pytest.raises(ValueError, match=f"from 0 to {LAST_LEVEL}, got"):
        read_options({"level": LAST_LEVEL + 1})


def test_levels_are_counted_from_0(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(monkeypatch, "record", "empty_goal", "dash", "--level", "-1") == 2
    assert "--level" in capsys.readouterr().err


def test_learners_are_disturbed(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    monkeypatch.chdir(tmp_path)
    times = {}
    for name, disturbed in (
        ("plain", ()),
        ("late", ("--perturb", "drive_lag:tau=0.3", "--perturb", "latency:time=0.3")),
    ):
        assert run(monkeypatch, "evaluate", "empty_goal", "dash", "--levels", 3, "--out", name, *disturbed) == 0
        summary = json.loads((tmp_path / name / "summary.json").read_text())
        times[name] = next(one for one in summary["policies"] if one["policy"] == "dash")["time"]
    assert summary["conditions"]["parameters"] == {"disturbances": "drive_lag:tau=0.3; latency:time=0.3"}
    assert times["late"] > times["plain"] + 0.5
    slip = ("--perturb", "slip:ahead=0.3")
    assert run(monkeypatch, "evaluate", "empty_goal", "dash", "--levels", 3, "--out", "slips", *slip) == 0
    assert "misplaced" in capsys.readouterr().out
    summary = json.loads((tmp_path / "slips" / "summary.json").read_text())
    dash = next(one for one in summary["policies"] if one["policy"] == "dash")
    assert (dash["success"]["count"], dash["misplaced"]["count"]) == (0, 3)
    assert dash["end_distance"] > 0.5
    assert run(monkeypatch, "evaluate", "empty_goal", "--perturb", "latncy:time=1") == 1
    assert "did you mean 'latency'?" in capsys.readouterr().err


def test_films_and_draw(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    film, picture = tmp_path / "film.gif", tmp_path / "new" / "picture.png"
    film.write_bytes(b"kept")
    for command in (("record", "empty_goal", "dash"), ("run", "empty_goal")):
        assert run(monkeypatch, *command, "--out", film) == 1
        assert f"{film} exists: choose another name with --out" in capsys.readouterr().err
    assert film.read_bytes() == b"kept"
    assert run(monkeypatch, "record", "empty_goal", "dash", "--out", film, "--overwrite") == 0
    assert film.read_bytes().startswith(b"GIF")
    assert run(monkeypatch, "draw", "empty_goal", "--level", 3, "--out", picture) == 0
    assert picture.read_bytes().startswith(b"\x89PNG")


def test_run(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    film, file = tmp_path / "film.gif", tmp_path / "yard.yaml"
    file.write_text(
        "world: {status: Pause}\nrobot: {kinematics: {name: diff}, goal: [0.35, 0], behavior: {name: dash}}\n"
    )
    assert run(monkeypatch, "run", file, "--film", film) == 0
    said = capsys.readouterr().out.splitlines()
    assert said == ["Arrived after 0.3 s", "robot_0: arrived at (0.30, 0.00, 0.00)", str(film)]
    assert film.read_bytes().startswith(b"GIF")


def test_train_resume_evaluate_and_record(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    monkeypatch.chdir(tmp_path)
    train = ["train", "empty_goal", "--steps", "16384", "--dev-levels", "3", "--algorithm", "PPO"]
    assert run(monkeypatch, *train) == 0
    folder = tmp_path / "runs" / "empty_goal-ppo-steps=16384-0"
    assert {file.name for file in folder.glob("curve.*")} == {"curve.csv", "curve.json", "curve.png"}
    assert "end:" in capsys.readouterr().out
    assert run(monkeypatch, *train, "--resume") == 0
    assert run(monkeypatch, *train, "--resume", "--seed", 1, "--out", folder) == 1
    assert "holds a run with" in capsys.readouterr().err
    assert run(monkeypatch, "evaluate", "empty_goal", folder, "--levels", 5, "--out", "evaluation") == 0
    lines = Path("evaluation/episodes.csv").read_text().splitlines()
    assert len(lines) == 1 + 3 * 5
    summary = json.loads(Path("evaluation/summary.json").read_text())
    assert [row["policy"] for row in summary["policies"]] == ["empty_goal-ppo-steps=16384-0", "random", "dash"]
    assert summary["conditions"]["goal_tolerance"] > 0.0
    table = Path("evaluation/table.txt").read_text()
    assert "empty_goal: 5 test levels" in table
    assert run(monkeypatch, "record", "empty_goal", folder, "dash", "--level", 2, "--out", "film.mp4") == 0
    assert b"ftyp" in Path("film.mp4").read_bytes()[:16]
    assert run(monkeypatch, "train", "empty_goal", "--resume", "--out", "nope") == 1
    assert "--resume: nope holds no run" in capsys.readouterr().err
    (folder / "policy.zip").unlink()
    assert run(monkeypatch, "evaluate", "empty_goal", folder, "--levels", 1) == 0
    assert f"{folder} is not finished: its checkpoint after 16,384 of 16,384 steps plays" in capsys.readouterr().err


def test_demo_twice(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    monkeypatch.setattr("irsim_gym.cli.work.demo.FILMED", (0,))
    demo = ["demo", "--scenario", "empty_goal", "--steps", 16384, "--levels", 3, "--out", tmp_path]
    assert run(monkeypatch, *demo) == 0
    made = [tmp_path / name for name in ("film.mp4", "run/curve.png", "test/table.txt", "test/episodes.csv")]
    assert all(file.stat().st_size > 0 for file in made)
    said, trained = capsys.readouterr().out, (tmp_path / "run" / "policy.zip").stat().st_mtime_ns
    assert all(str(tmp_path / name) in said for name in ("run/policy.zip", "test", "film.mp4"))
    assert run(monkeypatch, *demo) == 0
    assert (tmp_path / "run" / "policy.zip").stat().st_mtime_ns == trained


def test_warmup(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(monkeypatch, "warmup", "empty_goal", "circle_swap") == 0
    said = capsys.readouterr().out
    assert re.fullmatch(r"2 scenarios ready: \d+ kernels compiled in \d+ s, kept in .+\n", said)
    assert run(monkeypatch, "warmup", "empty_goal") == 0
    assert re.match(r"1 scenario ready: 0 kernels compiled in \d+ s", capsys.readouterr().out)


def test_warmup_of_the_suite_and_of_a_task(monkeypatch: pytest.MonkeyPatch) -> None:
    exercised: list[tuple[str, object, object]] = []

    def note(scenario: Scenario, task: str | None) -> None:
        exercised.append((scenario.name, scenario.parameters.get("loops"), task))

    monkeypatch.setattr("irsim_gym.cli.work.warmup.exercise", note)
    assert run(monkeypatch, "warmup", "maze_0.65", "dense_room", "--task", "general_navigation") == 0
    assert exercised == [("maze", 0.65, "general_navigation"), ("dense_room", None, "general_navigation")]
    exercised.clear()
    assert run(monkeypatch, "warmup", "core") == 0
    assert len(exercised) == len(shipped_suite().tiers["core"])


def test_the_command_line_starts_light() -> None:
    loaded = "print([m for m in ('numba', 'torch', 'matplotlib') if m in sys.modules])"
    script = f"import sys, irsim_gym.cli.tools as tools; tools.print_shipped(); {loaded}"
    found = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    assert found.stdout.splitlines()[-1] == "[]"


@pytest.mark.parametrize("name", ["train", "evaluate", "record"])
def test_scripts_are_the_commands(name: str) -> None:
    script = Path(__file__).parents[2] / "agents" / f"{name}.py"
    found = subprocess.run([sys.executable, str(script), "--help"], capture_output=True, text=True, check=False)
    assert found.returncode == 0, found.stderr
    assert "scenario" in found.stdout.lower()


OWN = """
import irsim_gym

@irsim_gym.behavior("ahead_by_{stem}")
def ahead(ego, others, *, speed: float = 1.0):
    return [speed, 0.0] if ego.pose[0] < 0.25 else [1 / 0, 0.0]
"""


@pytest.mark.parametrize(("stem", "suffix"), [("own_file", ".py"), ("own_module", "")])
def test_behaviours_of_ones_own(
    stem: str, suffix: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "path", list(sys.path))
    families.load()
    monkeypatch.setattr(families.BEHAVIORS, "_entries", dict(families.BEHAVIORS._entries))
    Path(f"{stem}.py").write_text(OWN.format(stem=stem))
    Path("yard.yaml").write_text(
        f"robot: {{kinematics: {{name: diff}}, goal: [9, 0], behavior: {{name: ahead_by_{stem}}}}}\n"
    )
    assert run(monkeypatch, "check", "yard.yaml") == 1
    assert "--import FILE.py" in capsys.readouterr().err
    assert run(monkeypatch, "check", "yard.yaml", "--import", stem + suffix) == 1  # it is played for more than 3 steps
    assert f"in behavior 'ahead_by_{stem}' for 'robot_0', step 4 of world 0" in capsys.readouterr().err
    for command in (["run", "yard.yaml", "--steps", 2], ["options", f"ahead_by_{stem}"]):
        assert run(monkeypatch, *command, "--import", stem + suffix) == 0
    said = capsys.readouterr().out
    assert "robot_0: under way at (0.20, 0.00, 0.00)" in said
    assert "speed" in said
    with pytest.raises(ZeroDivisionError) as caught:
        run(monkeypatch, "run", "yard.yaml", "--import", stem + suffix)
    assert caught.value.__notes__ == [f"in behavior 'ahead_by_{stem}' for 'robot_0', step 4 of world 0"]
    del sys.modules[stem]


@pytest.mark.parametrize(
    ("name", "said"),
    [
        ("nowhere.py", "no file"),
        ("nowhere", "no module named 'nowhere' in this folder or installed; name a file with its suffix"),
        ("json.py", "another module named 'json' is already loaded; rename json.py"),
        ("own_typo.py", "own_typo.py:2: invalid syntax"),
        ("own_typo", "own_typo.py:2: invalid syntax"),
    ],
)
def test_imports_that_cannot_be(
    name: str, said: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "path", list(sys.path))
    Path("json.py").write_text("")
    Path("own_typo.py").write_text("\ndef own(:\n")
    assert run(monkeypatch, "check", "empty_goal", "--import", name) == 1
    assert said in capsys.readouterr().err.replace("\n", "")


def test_what_an_imported_module_misses_is_not_hidden(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "path", list(sys.path))
    for name in ("own_one.py", "own_two.py"):
        Path(name).write_text("import nowhere_at_all\n")
    for name in ("own_one", "own_two.py"):
        with pytest.raises(ModuleNotFoundError, match="nowhere_at_all"):
            run(monkeypatch, "check", "empty_goal", "--import", name)


def test_options_of_one_kind(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(monkeypatch, "options", "rvo") == 0
    assert "neighbor_threshold" in capsys.readouterr().out
    assert run(monkeypatch, "options", "robot") == 0
    assert "goal_threshold" in capsys.readouterr().out
    assert run(monkeypatch, "options", "rov") == 1
    assert "named 'rov' (did you mean 'rvo'?)" in capsys.readouterr().err
    assert run(monkeypatch, "options", "none.md") == 1
    assert "no section or kind named 'none.md'" in capsys.readouterr().err


def test_notes_leave_the_exit_status(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    file = tmp_path / "odd.yaml"
    file.write_text("world: {step_time: 2.0}\nrobot: {kinematics: {name: diff}, goal: [9, 0]}\n")
    assert run(monkeypatch, "check", file) == 0
    assert "the exit status stays 0" in capsys.readouterr().out
