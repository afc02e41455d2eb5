"""Training, evaluation and recording: the commands ``train``, ``evaluate``, ``record`` and ``demo``."""
