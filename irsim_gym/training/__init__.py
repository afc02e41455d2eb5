"""Learning, scoring and filming agents: what the commands ``train``, ``evaluate``, ``record`` and ``demo`` do."""
