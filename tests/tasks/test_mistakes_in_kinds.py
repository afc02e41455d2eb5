"""Mistakes in rewards, observations, endings and actions of one's own: each is told with file, line and cure."""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest
from task_tools import play, scenario

from irsim_gym.base import families
from irsim_gym.cli.work import trial
from irsim_gym.errors import KindError
from irsim_gym.tasks import Episodes
from irsim_gym.tasks.plugin_checks.term_watch import watch_terms

HEAD = """
import numpy as np
from irsim_gym.base.options import kind, option
from irsim_gym.tasks import Outcome

"""
REWARD = f"""{HEAD}@kind
class Mine:
    role = "running"
    outcome = Outcome.RUNNING
    needs_goal = False
    needs_ending = False
    weight: float = option(0.5, ge=0.0, meaning="Cost of an episode.")

    @staticmethod
    def pay(term, model, state, episode, shard):
        rate = state.velocity[np.ix_(shard.worlds, term.agents)][..., 1] / 1.5
        paid = -term.options.weight / term.max_steps * np.abs(rate)
        episode.reward_term[shard.worlds, :, term.column] = paid
"""
OBSERVATION = f"""{HEAD}@kind
class Mine:
    needs_goal = False
    needs = ()

    def bounds(self, term, model):
        return -np.ones(2, np.float32), np.ones(2, np.float32)

    @staticmethod
    def write(term, model, state, episode, shard):
        heading = state.pose[np.ix_(shard.worlds, term.agents)][..., 2]
        episode.observation[shard.worlds, :, term.column] = np.cos(heading)
        episode.observation[shard.worlds, :, term.column + 1] = np.sin(heading)
"""
PICTURE = f"""{HEAD}@kind
class Mine:
    needs_goal = False
    needs = ()

    @property
    def image_shape(self):
        return 8, 8, 1

    @staticmethod
    def write(term, model, state, episode, shard):
        term.image[shard.worlds] = 7
"""
ENDING = f"""{HEAD}@kind
class Mine:
    outcome = Outcome.LEFT_WORLD
    needs_goal = False

    @staticmethod
    def ends(term, model, state, episode, shard):
        x = state.pose[np.ix_(shard.worlds, term.agents)][..., 0]
        episode.ending[shard.worlds, :, term.column] = x > 9
"""
ACTION = f"""{HEAD}@kind
class Mine:
    n_choices = 0

    @staticmethod
    def act(term, model, state, episode, shard):
        episode.previous_action[shard.worlds] = episode.action[shard.worlds]
        episode.action[shard.worlds] = np.clip(episode.given[shard.worlds], -1, 1)
"""
SOURCES = {"reward": REWARD, "observation": OBSERVATION, "picture": PICTURE, "ending": ENDING, "action": ACTION}
FAMILIES = {"reward": families.REWARDS, "ending": families.ENDINGS, "action": families.ACTIONS}
INTO = r"it must write into episode.reward_term\[shard.worlds, :, term.column\]"
RUNNING = 'role = "running"\n    outcome = Outcome.RUNNING'
OWN_COLUMN = "episode.reward_term[shard.worlds, :, term.column] = paid"
COSINE = "episode.observation[shard.worlds, :, term.column] = np.cos(heading)"
SINE = "episode.observation[shard.worlds, :, term.column + 1] = np.sin(heading)"
ENDED = "episode.ending[shard.worlds, :, term.column] = x > 9"
BOUNDS = "return -np.ones(2, np.float32), np.ones(2, np.float32)"
CLIPPED = "np.clip(episode.given[shard.worlds], -1, 1)"
KEPT = "episode.previous_action[shard.worlds] = episode.action[shard.worlds]"

AT_ONCE: list[tuple[str, str, str, str]] = [
    ("reward", "@kind\n", "", "it is no kind: write @kind above the class"),
    ("reward", '"running"', '"runing"', "'role' must be one of .*, got 'runing' .did you mean 'running'"),
    ("reward", '"running"', '"bonus"', "a bonus is for an outcome, such as Outcome.SUCCESS, got Outcome.RUNNING"),
    ("reward", 'role = "running"', "", "it has no 'role': one of potential, bonus, penalty, running"),
    ("reward", "Outcome.RUNNING", '"collision"', "'outcome' must be .* one of .*COLLISION.*, got 'collision'"),
    ("reward", "outcome = Outcome.RUNNING", "", "it has no 'outcome'"),
    ("reward", "needs_goal = False", "", "it has no 'needs_goal': True if"),
    ("reward", "needs_ending = False", "needs_ending = 'no'", "'needs_ending' must be True if .*, got 'no'"),
    ("reward", "weight: float =", "wait: float =", "it has no option 'weight'"),
    ("reward", "def pay(", "def pays(", r"it has no method pay\(term, model, state, episode, shard\); is 'pays' meant"),
    ("reward", "    @staticmethod\n", "", "'pay' is called as pay.* but takes .*; write @staticmethod above it"),
    ("reward", "term, model, state, episode, shard)", "term, state, shard)", r"but takes \(term, state, shard\)$"),
    ("reward", "term, model, state,", "term, state, model,", "by position, but takes .*: another order"),
    ("observation", "needs = ()", "", "it has no 'needs': what a robot must have"),
    ("observation", "def bounds", "def limits", "it has neither 'bounds.term, model.' nor"),
    (
        "observation",
        "def bounds(self, term, model)",
        "def bounds(self, term)",
        "'bounds' is called as bounds.term, model",
    ),
    ("ending", "Outcome.LEFT_WORLD", "Outcome.TIMEOUT", "'outcome' must be .*, one of .*SUCCESS.*, got .*TIMEOUT"),
    ("ending", "Outcome.LEFT_WORLD", "7", "'outcome' must be .*, got 7"),
    ("ending", "def ends(", "def end(", r"it has no method ends\(.*\); is 'end' meant"),
    ("action", "n_choices = 0", "", "it has no 'n_choices'"),
    ("action", "def act(", "def action(", "it has no method act"),
]
"""Told when the class is registered: family, what is replaced in it, by what, and what is said."""

WHEN_USED: list[tuple[str, str, str, str]] = [
    ("reward", "ge=0.0, ", "", "its weight must be a number >= 0, its role gives the sign; got -1"),
    (
        "reward",
        "= -term.options",
        "= term.options",
        r"pay\(\) writes 0.* for robot_0 .*: a running term is never positive",
    ),
    ("reward", RUNNING, RUNNING.replace("running", "bonus").replace("RUNNING", "SUCCESS"), "a bonus is never negative"),
    ("reward", "np.abs(rate)", "np.abs(rate) / 0", r"pay\(\) writes (nan|-inf) for robot_0 in world 0: .* finite"),
    ("reward", " / term.max_steps *", " * 9 *", "a running term costs at most its weight, 0.5, in an episode"),
    ("reward", OWN_COLUMN, "return paid", rf"pay\(\) returns ndarray of shape \(\d, 1\) and writes nothing: {INTO}"),
    ("reward", OWN_COLUMN, "pass", r"leaves episode.reward_term.* as it was"),
    ("reward", "] = paid", "] += paid", r"leaves episode.reward_term.* as it was"),
    ("reward", OWN_COLUMN, f"{OWN_COLUMN}\n        return paid", "returns ndarray .*, which is not used"),
    ("reward", ":, term.column]", ":]", r"pay\(\) writes column \d, which is another term's; its own column: 1,"),
    (
        "reward",
        "[shard.worlds, :, term.column]",
        "[:, :, term.column]",
        r"writes into worlds that are not in shard.worlds",
    ),
    (
        "reward",
        OWN_COLUMN,
        f"{OWN_COLUMN}\n        state.pose[shard.worlds] += 1",
        "changes state.pose, which it may only read",
    ),
    (
        "observation",
        COSINE,
        COSINE.replace("np.cos", "2 + np.cos"),
        r"writes 3 into element 0 .*: bounds.. says .* in \[-1, 1\]",
    ),
    ("observation", COSINE, COSINE.replace("np.cos(heading)", "np.nan"), "writes nan into element 0 .* finite"),
    ("observation", SINE, "", r"write\(\) leaves episode.observation.* as it was"),
    ("observation", "term.column + 1]", "term.column + 2]", "leaves episode.obs|writes column 6, which is another"),
    ("observation", "term.column + 1]", "1]", "leaves episode.obs|writes column 1, which is another"),
    ("observation", BOUNDS, "return np.ones(2), -np.ones(2)", "the least values first: element 0 is from 1 to -1"),
    ("observation", BOUNDS, "return -np.ones(2), np.ones(3)", r"of one shape .width,., .* got .array.*array"),
    ("observation", BOUNDS, "return -np.ones((1, 2)), np.ones((1, 2))", r"of one shape .width,., .* got .array.*array"),
    ("observation", BOUNDS, "return -9 * np.ones(2), np.ones(2)", r"within \[-1, 1\], .*: element 0 is from -9 to 1"),
    ("observation", BOUNDS, "return -1, 1, 2", r"must return two arrays .* got \(-1, 1, 2\)"),
    ("picture", "term.image[shard.worlds] = 7", "pass", "leaves term.image.* as it was"),
    ("picture", "8, 8, 1", "8, 8", r"image_shape must be \(height, width, channels\), whole numbers > 0, got \(8, 8\)"),
    ("ending", ENDED, "return x > 9", r"ends\(\) returns ndarray .* and writes nothing"),
    ("ending", ENDED, "episode.ending[shard.worlds] = (x > -9)[..., None]", "writes column 1, which is another term's"),
    (
        "action",
        CLIPPED,
        "2 * episode.given[shard.worlds]",
        r"act\(\) writes -?[12].* for robot_0 .*: an action lies in",
    ),
    ("action", KEPT, "pass", "does not keep the action before"),
    ("action", CLIPPED, "episode.action[shard.worlds]", "writes the same action whatever is given"),
    ("action", "n_choices = 0", "n_choices = 2.5", "n_choices must be a whole number >= 0, got 2.5"),
]
"""Told when it is bound, or by ``watch_terms``."""


@pytest.fixture(autouse=True)
def forgotten() -> Iterator[None]:
    """Forget afterwards what was registered."""
    yield
    for family in (*FAMILIES.values(), families.OBSERVATIONS):
        family._entries.pop("mine", None)


def registered(family: str, source: str) -> None:
    """Run the source of a kind as a file would be, and register the class."""
    space: dict[str, Any] = {"__name__": "my_terms"}
    exec(compile(source, "my_terms.py", "exec", dont_inherit=True), space)
    FAMILIES.get(family, families.OBSERVATIONS).register("mine", space["Mine"])


def episodes(family: str, n_worlds: int = 2, **options: Any) -> Episodes:
    """Return episodes with the kind between others."""
    mine = {"name": "mine", **options}
    action = {"action": mine} if family == "action" else {}
    task = {
        "name": "blank",
        "observations": ["goal", *([mine] if family in ("observation", "picture") else []), "velocity"],
        "rewards": ["progress", *([mine] if family == "reward" else []), "time"],
        "endings": ["arrived", *([mine] if family == "ending" else [])],
        "audit": False,
        **action,
    }
    return play({"sensors": []}, task=task, n_worlds=n_worlds)


def run(family: str, steps: int = 8, watched: bool = True, **options: Any) -> list[Any]:
    """Play some steps, and return what was seen and paid."""
    played, seen = episodes(family, **options), []
    if watched:
        watch_terms(played.terms, played.simulation)
        played.begin(np.arange(2), np.arange(2))
    for k in range(steps):
        played.step(np.full((2, 1, 2), 0.9 - 0.3 * (k % 5)))
        seen += [played.view.observation.copy(), played.view.reward.copy(), played.view.terminated.copy()]
    return seen


def changed(family: str, old: str, new: str) -> str:
    """Return the source of a kind with a mistake in it."""
    assert old in SOURCES[family]
    return SOURCES[family].replace(old, new)


@pytest.mark.parametrize(("family", "old", "new", "said"), AT_ONCE)
def test_told_when_registered(family: str, old: str, new: str, said: str) -> None:
    with pytest.raises(KindError, match=said) as error:
        registered(family, changed(family, old, new))
    assert re.match(rf"{family} 'mine' \(Mine, my_terms.py:\d+\): ", str(error.value))
    assert "mine" not in FAMILIES.get(family, families.OBSERVATIONS)


@pytest.mark.filterwarnings("ignore:(divide|invalid):RuntimeWarning")
@pytest.mark.parametrize(("family", "old", "new", "said"), WHEN_USED)
def test_told_when_used(family: str, old: str, new: str, said: str) -> None:
    registered(family, changed(family, old, new))
    with pytest.raises(KindError, match=said) as error:
        run(family, **({"weight": -1.0} if old == "ge=0.0, " else {}))
    assert re.match(rf"{family.replace('picture', 'observation')} 'mine' \(Mine, my_terms.py:\d+\): ", str(error.value))


def test_all_mistakes_of_a_class_are_told_at_once() -> None:
    with pytest.raises(KindError, match=r"(?s)role.*\n.*needs_goal.*\n.*needs_ending") as error:
        registered("reward", REWARD.replace("needs_", "wants_").replace('"running"', '"cost"'))
    assert len(str(error.value).splitlines()) == 4


@pytest.mark.parametrize("family", list(SOURCES))
def test_what_is_right_is_left_alone(family: str) -> None:
    """A watched kind does the same as one that nobody watches."""
    registered(family, SOURCES[family])
    np.testing.assert_equal(run(family, steps=12), run(family, steps=12, watched=False))


def test_shipped_kinds_are_not_watched() -> None:
    played = episodes("none")
    before = [term.options for terms in played.terms.values() for term in terms]
    watch_terms(played.terms, played.simulation)
    after = [term.options for terms in played.terms.values() for term in terms]
    assert all(one is other for one, other in zip(before, after, strict=True))


def test_the_trial_of_a_file_watches_kinds() -> None:
    """It plays two worlds, so that a term that writes into worlds of others is found."""
    registered("reward", changed("reward", "[shard.worlds, :, term.column]", "[:, :, term.column]"))
    task = {"name": "blank", "observations": ["goal"], "rewards": ["mine"], "endings": ["arrived"], "audit": False}
    steps = trial._with_terms_watched(scenario({"sensors": []}, task=task), None)
    with pytest.raises(KindError, match=r"writes into worlds that are not in shard\.worlds"):
        next(steps)
