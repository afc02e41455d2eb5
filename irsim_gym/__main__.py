"""The command line as ``python -m irsim_gym``, for where no script is on the path."""

from irsim_gym.cli import main

if __name__ == "__main__":
    main()
