"""Workbench: forms for the commands, in a browser on the user's machine."""
