"""Policies by name, with options: ``dash``, ``pursuit:known=seen``."""

from pathlib import Path
from typing import Any

from irsim_gym.base import families
from irsim_gym.base.errors import IrsimGymError
from irsim_gym.base.families import BEHAVIORS, GROUP_BEHAVIORS
from irsim_gym.scenario.checking.validation import Report, build_named
from irsim_gym.scenario.text.source import read_mapping

TRUTHS = {"true": True, "false": False}


class PolicyOptionError(IrsimGymError, ValueError):
    """Options in a policy's name that its behaviour does not have."""


def kind_name(source: str | Path) -> str:
    """Return the name of the behaviour in ``NAME`` or ``NAME:OPTION=VALUE:...``, which need not be registered."""
    return str(source).partition(":")[0]


def read_options(source: str) -> dict[str, object]:
    """Return the options in ``NAME:OPTION=VALUE:OPTION=VALUE`` in their types; empty for a name alone.

    Raises:
        PolicyOptionError: If the text cannot be parsed, or the behaviour has no such option or value; the message lists
            all problems.
    """
    families.load()
    name, *texts = source.split(":")
    options: dict[str, Any] = {}
    for text in texts:
        option, equals, value = text.partition("=")
        if not equals or not option or option in options or option == "name":
            raise PolicyOptionError(f"'{source}': write NAME:OPTION=VALUE:..., each option once, got '{text}'")
        options[option] = TRUTHS.get(value, value)
    if not options:
        return {}
    registry = BEHAVIORS if name in BEHAVIORS else GROUP_BEHAVIORS
    if name not in registry:
        raise PolicyOptionError(f"'{source}': '{name}' is no behavior, and has no options")
    report = Report(read_mapping({"behavior": {"name": name, **options}}))
    behavior = build_named(registry, {"name": name, **options}, ("behavior",), report)
    if report.problems:
        told = (f"'{source}': {each.path.removeprefix('behavior.')}: {each.message}" for each in report.problems)
        raise PolicyOptionError("\n".join(told))
    return {option: getattr(behavior, option) for option in options}
