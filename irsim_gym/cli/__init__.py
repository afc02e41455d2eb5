"""What can be typed: the command ``irsim-gym``.

Declarations of options; what commands do is in ``work``.
"""

from collections.abc import Sequence

__all__ = ["main"]


def main(arguments: Sequence[str] | None = None) -> None:
    """Run the command line, see ``app.main``.

    Args:
        arguments: The command and its arguments; None for those of the process.
    """
    from irsim_gym.cli.app import main as run

    run(arguments)
