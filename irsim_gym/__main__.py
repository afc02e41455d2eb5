"""The command line as ``python -m irsim_gym``, for where no script is on the path."""

import sys


def main() -> None:
    """Run the command line; Ctrl-C while its packages are loaded ends it without a traceback."""
    try:
        from irsim_gym.cli import main as run
    except KeyboardInterrupt:
        print("stopped", file=sys.stderr)
        sys.exit(130)
    run()


if __name__ == "__main__":
    main()
