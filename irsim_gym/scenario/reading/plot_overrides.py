"""Overrides drawing options of a scenario, for pictures with their own options."""

from collections.abc import Mapping
from dataclasses import fields, replace
from typing import Any

from irsim_gym.base.errors import ScenarioError
from irsim_gym.scenario.checking.validation import Report, build
from irsim_gym.scenario.specs.plot_spec import ObjectPlot, SavedFigure
from irsim_gym.scenario.specs.spec import Scenario
from irsim_gym.scenario.text.source import read_mapping

BODY_KEYS = frozenset(field.name for field in fields(ObjectPlot))
FIGURE_KEYS = frozenset(field.name for field in fields(SavedFigure))


def drawn_with(scenario: Scenario, options: Mapping[str, object]) -> Scenario:
    """Return a scenario with drawing options set for all bodies.

    Args:
        options: Keys of a body's section ``plot``, with their values.

    Raises:
        ScenarioError: If an option has a bad value; the error lists all of them.
    """
    values = _checked(ObjectPlot, "plot", options)
    bodies = tuple(replace(body, plot=replace(body.plot, **values)) for body in scenario.bodies)
    return replace(scenario, bodies=bodies)


def saved_with(scenario: Scenario, options: Mapping[str, object]) -> Scenario:
    """Return a scenario with options for saved figures, keys of ``plot.saved_figure``.

    Raises:
        ScenarioError: If an option has a bad value; the error lists all of them.
    """
    plot = scenario.world.plot
    saved = replace(plot.saved_figure, **_checked(SavedFigure, "saved_figure", options))
    return replace(scenario, world=replace(scenario.world, plot=replace(plot, saved_figure=saved)))


def _checked(kind: type[ObjectPlot] | type[SavedFigure], section: str, options: Mapping[str, object]) -> dict[str, Any]:
    source = read_mapping({section: dict(options)})
    report = Report(source)
    built = build(kind, source.data[section], (section,), report)
    if built is None or report.problems:
        raise ScenarioError("options of a picture", list(report.problems))
    return {key: getattr(built, key) for key in options}
