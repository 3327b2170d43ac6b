"""The workbench: the commands in a browser, on this machine alone."""
