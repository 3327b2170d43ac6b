"""Floor 11: the workbench: the commands in a browser, on this machine alone."""
