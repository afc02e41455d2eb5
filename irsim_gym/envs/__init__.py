"""Environments for learning libraries: thin adapters over ``tasks.Episodes``. Import the module you need."""
