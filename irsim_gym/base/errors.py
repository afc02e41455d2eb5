"""The errors that users of the package meet."""

import copyreg
import difflib
import sys
import warnings
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar, Self

__all__ = ["BehaviorError", "ChangedScenarioWarning", "IgnoredKeyWarning", "IrsimGymError", "KindError"]
__all__ += ["MissingExtraError", "MissingScenarioError", "NoEffectWarning", "NoKeyboardWarning", "NoWayError"]
__all__ += ["NoWindowError", "OptionError", "PlacementError", "Problem", "ScenarioError", "ScenarioWarning"]
__all__ += ["SeveralAgentsError", "SeveralProblemsError", "UnknownKeywordError", "UnknownNameError"]
__all__ += ["UnknownParameterError", "UnknownPerceptionWarning", "UnreadableFileError", "UntrustedCodeWarning"]
__all__ += ["WaitingRobotsWarning"]


def _pickled(error: Exception) -> tuple[Any, ...]:
    """Return how an error is made again from its message and attributes, whatever its ``__init__`` takes."""
    # An OSError whose class has an ``__init__`` of its own does not keep what ``__new__`` gets.
    state = {**vars(error), "args": error.args}
    return copyreg.__newobj__, (type(error), *error.args), state  # type: ignore[attr-defined]


class IrsimGymError(Exception):
    """Base of every error raised on purpose by this package."""

    __reduce__ = _pickled


@dataclass(frozen=True, order=True)
class Problem:
    """One mistake in a file: where it stands and what would be right.

    Attributes:
        line: Line in the file, counted from 1; 0 when the problem belongs to the whole file.
        path: Dotted path of the value, e.g. ``robot[0].shape.radius``.
        message: What was found and what would be right.
    """

    line: int
    path: str
    message: str


class ScenarioError(IrsimGymError, ValueError):
    """A scenario, task or hyper-parameter file that cannot be used; it lists all its problems at once.

    Args:
        file: The file.
        problems: Its problems, in the order of their lines.
        advice: A last line.
    """

    def __init__(self, file: str, problems: Sequence[Problem], advice: str = "") -> None:
        self.file = file
        self.problems = tuple(dict.fromkeys(sorted(problems)))
        self.advice = advice
        super().__init__(self._text())

    def _text(self) -> str:
        head = f"{several(len(self.problems), 'problem')} in {self.file}"
        return "\n".join([listing(head, self.file, self.problems), *filter(None, [self.advice])])


class ScenarioWarning(UserWarning):
    """Values of a scenario file that are allowed but seldom meant; it lists all of them at once.

    Args:
        file: The file.
        problems: Its problems, in the order of their lines.
    """

    HEAD: ClassVar[str] = "seldom meant in"
    __reduce__ = _pickled

    def __init__(self, file: str, problems: Sequence[Problem]) -> None:
        self.file = file
        self.problems = tuple(problems)
        super().__init__(listing(f"{self.HEAD} {file}:", file, self.problems))


class IgnoredKeyWarning(ScenarioWarning):
    """Keys of a scenario file that nothing reads; it lists all of them at once."""

    HEAD = "ignored in"


class WaitingRobotsWarning(UserWarning):
    """Robots wait for their world, and nothing shows that the algorithm leaves out their rows."""


class ChangedScenarioWarning(UserWarning):
    """A scenario is not what it was when a policy was trained in it."""


class UnknownPerceptionWarning(UserWarning):
    """What a policy was trained to observe cannot be read."""


class UntrustedCodeWarning(UserWarning):
    """A file that holds code, or can make code run, and may not be one's own."""


def listing(head: str, file: str, problems: Sequence[Problem]) -> str:
    """Return problems as text below a headline, each with file and line.

    Args:
        head: What stands above them.
        file: The file.
        problems: Its problems, in the order of their lines.
    """
    places = [f"{file}:{problem.line}" if problem.line else file for problem in problems]
    width = max((len(place) for place in places), default=0)
    rows = [
        f"  {place:<{width}}   {problem.path + ': ' if problem.path else ''}{problem.message}"
        for place, problem in zip(places, problems, strict=True)
    ]
    return "\n".join([head, *rows])


class UnreadableFileError(IrsimGymError, ValueError):
    """A file that cannot be read, or is something else than it should be.

    Args:
        file: The file.
        kind: What it should be, e.g. ``"certificate of levels"``.
        reason: What is wrong with it.
    """

    def __init__(self, file: str, kind: str, reason: str) -> None:
        self.file, self.kind, self.reason = file, kind, reason
        super().__init__(f"{file} is no {kind}: {reason}")


class SeveralProblemsError(IrsimGymError):
    """Several arguments cannot be used; the message lists what is wrong with each.

    Args:
        problems: The errors of the arguments.
    """

    def __init__(self, problems: Sequence[IrsimGymError]) -> None:
        self.problems = tuple(problems)
        super().__init__("\n".join(map(str, self.problems)))


def report_together(*checks: Callable[[], object]) -> None:
    """Run checks that do not depend on each other, and report all problems together.

    Args:
        *checks: Functions that raise an ``IrsimGymError`` if something is wrong.

    Raises:
        IrsimGymError: The only problem, or ``SeveralProblemsError`` with all of them.
    """
    errors: list[IrsimGymError] = []
    for check in checks:
        try:
            check()
        except SeveralProblemsError as error:
            errors += error.problems
        except IrsimGymError as error:
            errors.append(error)
    different = list({str(error): error for error in errors}.values())
    if different:
        raise different[0] if len(different) == 1 else SeveralProblemsError(different)


class MissingExtraError(IrsimGymError, ModuleNotFoundError):
    """Something needs packages that an extra of the package installs."""


class UnknownNameError(IrsimGymError, KeyError):
    """A name that is not registered; the message offers the nearest known one."""

    def __str__(self) -> str:
        return str(self.args[0])


class UnknownParameterError(UnknownNameError):
    """Values are given for parameters that a scenario does not have; the message lists those that it has.

    Args:
        name: The first of them.
        message: What is wrong, and what would be right.

    Attributes:
        name: The first of them.
    """

    def __init__(self, name: str, message: str) -> None:
        self.name = name
        super().__init__(message)


class UnknownKeywordError(UnknownNameError, TypeError):
    """A keyword argument that is neither an argument of an environment nor a parameter of its scenario.

    It is a TypeError whose message has Python's own words as well, since libraries look for these to find out what an
    environment can be made with.
    """

    @classmethod
    def of(cls, name: str, message: str) -> Self:
        """Return the error for a name, with what there is in its place.

        Args:
            name: The keyword.
            message: What is wrong, and what there is in its place.
        """
        return cls(f"got an unexpected keyword argument '{name}': {message}")


class MissingScenarioError(IrsimGymError, TypeError):
    """An environment of no scenario is asked for."""


class OptionError(IrsimGymError, ValueError):
    """An option of a kind that cannot be used; whoever reads the file tells it with its line.

    Args:
        key: The option's key.
        message: What is wrong with its value.
    """

    def __init__(self, key: str, message: str) -> None:
        self.key = key
        super().__init__(message)


class KindError(IrsimGymError, ValueError):
    """A kind of one's own that does not do what its family asks for; the message says what would be right."""


class SeveralAgentsError(IrsimGymError, ValueError):
    """A task has several learners where one is expected."""


class PlacementError(IrsimGymError, RuntimeError):
    """A level could not be drawn within the allowed number of tries."""


class NoWayError(IrsimGymError, ValueError):
    """No free way leads from one point to another."""


class BehaviorError(IrsimGymError, ValueError):
    """A behaviour written in Python returned no command of the body's drive."""


class NoWindowError(IrsimGymError, RuntimeError):
    """A window is asked for where none can be opened: no display, or no toolkit that works."""


class NoKeyboardWarning(UserWarning):
    """A file asks for a keyboard, and there is none."""


class NoEffectWarning(UserWarning):
    """A script asks for what changes nothing here, or for a file that cannot be written."""


def several(count: int, noun: str) -> str:
    """Return a number of things: ``1 world``, ``2 worlds``.

    Args:
        count: How many.
        noun: What they are, for one of them.
    """
    return f"{count} {noun}{'' if count == 1 else 's'}"


def suggestion(name: str, choices: Iterable[str]) -> str:
    """Return ``" (did you mean 'x'?)"`` for the nearest known name, else an empty string.

    Args:
        name: What was written.
        choices: What there is.
    """
    near = nearest(name, choices)
    return f" (did you mean '{near}'?)" if near is not None else ""


def nearest(name: str, choices: Iterable[str], cutoff: float = 0.6) -> str | None:
    """Return the known name that a misspelt one most likely stands for; None when none is near.

    The same words in another order come first: ``max_range`` stands for ``range_max``.

    Args:
        name: What was written.
        choices: What there is.
        cutoff: How alike they have to be, a share from 0 to 1.
    """
    choices = list(choices)
    words = sorted(name.lower().split("_"))
    same = [choice for choice in choices if sorted(choice.lower().split("_")) == words]
    near = same or difflib.get_close_matches(name, choices, n=1, cutoff=cutoff)
    return near[0] if near else None


def warn_caller(message: str | Warning, category: type[Warning] = UserWarning) -> None:
    """Warn at the line that called this package.

    Args:
        message: What it says.
        category: Which warning it is.
    """
    frame, level = sys._getframe(), 1
    while frame.f_back is not None and str(frame.f_globals.get("__name__")).split(".")[0] in ("irsim_gym", "gymnasium"):
        frame, level = frame.f_back, level + 1
    warnings.warn(message, category, stacklevel=level)
