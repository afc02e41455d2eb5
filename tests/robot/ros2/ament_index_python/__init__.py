"""Stands for ament_index_python."""
