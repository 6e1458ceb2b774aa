"""Tree of the errors that walkergen raises.

WalkergenError            everything walkergen raises on purpose; the CLI prints it, exit code 2
├── InputError            a value a person wrote is unusable: says what was seen, allowed, to try
│   ├── GeometryError     a design whose parts cannot be built as drawn
│   ├── PlateError        parts that do not fit the printer's bed
│   └── PrintabilityError parts that would not print as drawn: one line each
├── SolidError            the solid modeller refused or returned an unsound body
├── TheoryError           a formula has no answer for these numbers
└── OutputError           a file or folder could not be written, or is not ours: exit code 1
"""


class WalkergenError(Exception):
    """Base of every error that walkergen raises on purpose; its text is meant for the user."""


class InputError(WalkergenError):
    """A value that a person wrote is unusable; the text says what was seen and what is allowed."""

    keys: tuple[str, ...]
    """Keys at fault, of each line of the text; "" of a line, or none, where it is no key's."""

    def __init__(self, text: str = "", *keys: str) -> None:
        super().__init__(text)
        self.keys = keys


class GeometryError(InputError):
    """A design's parts cannot be built as drawn; the text names the limit that was passed."""


class PlateError(InputError):
    """Parts do not fit the printer's bed; the text says how many parts would fit."""


class PrintabilityError(InputError):
    """Parts would not print as drawn; the text has a line for each finding, with what to change."""


class SolidError(WalkergenError):
    """The solid modeller refused an operation or returned a body that is not sound."""


class TheoryError(WalkergenError):
    """A formula has no answer for the given numbers."""


class OutputError(WalkergenError):
    """A file or folder could not be written, or holds what is not ours to write over."""
