"""What can go wrong: the words of the command, and of its remedies those that the function has an argument for."""

from __future__ import annotations


class Error(Exception):
    """Why there is no result.

    ``message`` says what is wrong and where, ``help`` what to do about it, if anything is known.
    """

    def __init__(self, message: str, help: str | None = None) -> None:
        super().__init__(message, help)
        self.message = message
        self.help = help

    def __str__(self) -> str:
        return self.message if self.help is None else f"{self.message}\nhelp: {self.help}"


class InputError(Error, ValueError):
    """Wrong arguments or bad input: exit code 2 of the command."""


class NoResultError(Error):
    """Good input of which nothing came: exit code 4 of the command."""


class PartWarning(UserWarning):
    """What is odd about an input or a result; also in the result's ``warnings``."""
