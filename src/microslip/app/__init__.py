"""Workbench: the commands in a local browser."""
