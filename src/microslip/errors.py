"""The errors that wrong input meets. All of them are ``ValueError`` too."""


class InputError(ValueError):
    """Something given is not usable; the message says what came and what was wanted."""


class StudyError(InputError):
    """A study file is not usable; the message names the file and the key."""
