"""What an environment is, as plain data: what each number of an observation, an action, a reward or an info means."""

import math
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from gymnasium import Space
from gymnasium.spaces import Box, Dict

from irsim_gym.base.arraytypes import Floats
from irsim_gym.envs.described.description_text import as_html, as_text
from irsim_gym.envs.described.parts import Action, Block, Component, Described, Ending, Info, Part, Reward
from irsim_gym.envs.parts.spaces import action_space, observation_space, observed
from irsim_gym.tasks import Episodes, HitKind, Outcome
from irsim_gym.tasks.terms.episode_state import EXTRAS, EpisodeState
from irsim_gym.tasks.terms.term import IsImage, Term
from irsim_gym.tasks.terms.words import Columns, TellsActions, TellsColumns, TellsWhen, first_sentence

STATE_NAMES = {"is_success": "success"}
"""Keys of infos that ``EpisodeState`` has under another name."""
CODES = {"outcome": Outcome, "hit_kind": HitKind}
"""Keys of infos whose numbers stand for words."""
OF_TEAMS = {"idle": "it had ended before the step (black_death)", "action_mask": "1 for each choice not masked, int8"}
"""Keys of infos that the parallel environment adds."""
SIGNS = {"potential": "+ or -", "bonus": "+", "penalty": "-", "running": "-"}


@dataclass(frozen=True)
class Description(Described):
    """What an environment is. ``print`` shows it as tables, a notebook too; ``as_dict`` is for programs.

    Attributes:
        scenario: Name of the scenario.
        task: Name of the task.
        agent: Name of the robot that it is about.
        same_for: Other learners that observe and act alike.
        max_steps: Time limit [steps].
        step_time: Duration of a step [s].
        observation_space: As text.
        form: ``"flat"`` or ``"dict"``.
        blocks: What the observation consists of.
        action: What an action means.
        rewards: What is paid.
        endings: What ends an episode, beside the time limit; of several in one step the first counts.
        infos: What infos hold.
        numbers: Other numbers of the task, with their units.
    """

    def __str__(self) -> str:
        return as_text(self)

    def _repr_html_(self) -> str:
        return as_html(self)


def describe(episodes: Episodes, info: Mapping[str, object], agent: int = 0, *, of_agent: bool = False) -> Description:
    """Return what an environment is to one of its learners.

    Args:
        info: An info of that learner, as the environment hands it out.
        agent: Which of the learners.
        of_agent: Observations and actions have the columns of this agent alone; else all that the richest agent has.
    """
    task = episodes.task
    terms = episodes.terms
    chosen, act = agent if of_agent else None, terms["action"][0]
    each = [(_blocks(episodes, a, of_agent), _components(episodes, act, a)) for a in range(episodes.n_agents)]
    blocks, _ = each[agent]
    alike = [a for a, parts in enumerate(each) if parts == each[agent] and a != agent]
    numbers = {
        "deadlock_speed": f"{task.deadlock_speed:g} m/s",
        "deadlock_time": f"{task.deadlock_time:g} s",
        "ended": task.ended,
        "team_reward": f"{task.team_reward:g}",
    }
    return Description(
        scenario=episodes.simulation.scenario.name,
        task=task.name,
        agent=episodes.agent_names[agent],
        same_for=tuple(episodes.agent_names[a] for a in alike),
        max_steps=task.max_steps,
        step_time=float(episodes.simulation.model.step_time[0]),
        observation_space=_short(observation_space(episodes, chosen)),
        form=task.observation_form,
        blocks=blocks,
        action=_action(episodes, act, agent, _short(action_space(episodes, chosen))),
        rewards=tuple(_reward(term) for term in terms["rewards"]),
        endings=tuple(Ending(term.name, term.options.outcome.name, _when(term)) for term in terms["endings"]),
        infos=tuple(_infos(info)),
        numbers=tuple(numbers.items()),
    )


def _blocks(episodes: Episodes, agent: int, of_agent: bool) -> tuple[Block, ...]:
    """Return the blocks of an agent's observations, in the order of the flat observation; pictures stand apart."""
    blocks: list[Block] = []
    held: Counter[str] = Counter()
    for key, term in observed(episodes):
        said, (low, high) = (first_sentence(type(term.options)), term.options.needs), term.bounds
        columns = _columns_of(episodes, term, agent)
        if isinstance(term.options, IsImage):
            view = getattr(term.options, "view", "")
            parts = _parts(columns, np.ones(sum(column.count for column in columns), np.bool_), (0.0, 255.0), 0)
            blocks.append(Block(term.name, key, *said, term.image.shape[2:], parts, True, view))
            continue
        used = episodes.feature_mask[agent, term.column : term.column + low.size]
        used_columns = used if of_agent else np.ones(low.size, np.bool_)
        if used_columns.any():
            width = int(used_columns.sum())
            blocks.append(Block(term.name, key, *said, (width,), _parts(columns, used_columns, (low, high), held[key])))
            held[key] += width
    return tuple(blocks)


def _columns_of(episodes: Episodes, term: Term, agent: int) -> Sequence[Columns]:
    """Return what an observation says of its columns; one part for all of them where it says nothing."""
    if isinstance(term.options, TellsColumns):
        return term.options.columns(term, episodes.simulation.model, agent)
    if isinstance(term.options, IsImage):
        return [Columns("not described", count=term.options.image_shape[2])]
    return [Columns("not described", count=term.bounds[0].size)]


def _parts(columns: Sequence[Columns], used: Any, bounds: tuple[Any, Any], start: int) -> tuple[Part, ...]:
    """Return the parts of a block, without columns that are not kept.

    Args:
        used: Which of them the agent has, ``(width,)``.
        bounds: Least and greatest values, ``(width,)`` or a number.
        start: Place of the first column that is kept.
    """
    parts, at = [], 0
    lows, highs = (np.broadcast_to(bound, used.shape) for bound in bounds)
    for column in columns:
        span = slice(at, at + column.count)
        chosen = np.flatnonzero(used[span])
        at += column.count
        if not len(chosen):
            continue
        low, high = (float(values[span][chosen].min()) for values in (lows, -highs))
        turned = [column.sectors[k] for k in chosen] if column.sectors else []
        sectors = tuple((math.degrees(begin), math.degrees(end)) for begin, end in turned)
        parts.append(Part(start, start + len(chosen), column.meaning, column.scale, low, -high + 0.0, sectors))
        start += len(chosen)
    return tuple(parts)


def _limits(episodes: Episodes, agent: int) -> Floats:
    """Return least and greatest commands and their greatest changes, ``(3, n_components)``."""
    model, body, size = episodes.simulation.model, episodes.task.agents[agent], int(episodes.action_sizes[agent])
    fields = model.velocity_min, model.velocity_max, model.acceleration_limit
    return np.array([field[0, body, :size] for field in fields])


def _components(episodes: Episodes, term: Term, agent: int) -> tuple[Component, ...]:
    lows, highs, changes = _limits(episodes, agent).tolist()
    rows = zip(term.components[agent], lows, highs, changes, strict=True)
    return tuple(Component(name, unit, low, high, change) for (name, unit), low, high, change in rows)


def _action(episodes: Episodes, term: Term, agent: int, space: str) -> Action:
    """Return the meaning of an action, with its choices if the kind describes them."""
    choices: tuple[tuple[float, ...], ...] = ()
    if episodes.n_discrete and isinstance(term.options, TellsActions):
        low, high, _ = _limits(episodes, agent)
        example = term.options.samples(term)[agent][:, : len(low)]
        commands = 0.5 * (low + high) + example * (0.5 * (high - low))
        choices = tuple(map(tuple, (commands + 0.0).tolist()))
    components = _components(episodes, term, agent)
    return Action(term.name, first_sentence(type(term.options)), space, components, choices)


def _reward(term: Term) -> Reward:
    options = term.options
    return Reward(term.name, options.role, SIGNS[options.role], float(options.weight), _when(term))


def _when(term: Term) -> str:
    """Return when a term pays or applies: in its own words, else by its docstring."""
    if isinstance(term.options, TellsWhen):
        return term.options.when(term)
    return first_sentence(type(term.options)) or "not described"


def _infos(info: Mapping[str, object]) -> list[Info]:
    """Return the keys of an info with what they mean, which their arrays declare."""
    declared = EpisodeState.columns()
    infos = []
    for key in info:
        name = STATE_NAMES.get(key, key)
        if "/" in key:
            infos.append(Info(key, "", f"what the term {key.split('/', 1)[1]} paid in the step"))
        elif name in declared:
            codes = ", ".join(f"{code.value} {code.name}" for code in CODES.get(key, ()))
            column = declared[name]
            infos.append(Info(key, column.unit, f"{column.meaning}: {codes}" if codes else column.meaning))
        else:
            infos.append(Info(key, "", (OF_TEAMS | EXTRAS).get(key, "not described")))
    return infos


def _short(space: Space[Any]) -> str:
    """Return a space as text, of a box with different bounds the least and the greatest one."""
    if isinstance(space, Dict):
        return f"Dict({', '.join(f'{name}: {_short(part)}' for name, part in space.items())})"
    if isinstance(space, Box):
        return f"Box({space.low.min():.4g}, {space.high.max():.4g}, {space.shape}, {space.dtype})"
    return str(space)
