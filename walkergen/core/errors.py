"""Tree of the errors that walkergen raises.

WalkergenError            everything walkergen raises on purpose; the CLI prints it, exit code 2
├── InputError            a user's value is unusable: reports value, allowed range and remedy
│   ├── GeometryError     a design whose parts cannot be built as drawn
│   ├── PlateError        parts that do not fit the printer's bed
│   └── PrintabilityError parts that would not print as drawn: one line each
├── SolidError            the solid modeller refused or returned an unsound body
├── TheoryError           a formula has no answer for these numbers
└── OutputError           a file or folder could not be written, or is not ours: exit code 1

Texts name fields as ‹mm_per_px›, which is --mm-per-px on a command line and mm_per_px in Python. ‹tilt=› precedes a
value: --tilt 12 or tilt=12. ‹cost=False› is --no-cost. A field is spelled when its text is shown.
"""

import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from functools import cached_property, partial
from typing import Any, NamedTuple, Self

Spelling = Callable[[str], str]

FIELD_PATTERN = re.compile(r"‹([a-z][a-z_]*)((?:=(?:False)?)?)›")
COMMAND_LINE_SOURCE = "‹command line›"
"""Source of keys that a request sets, in errors about their values; Python has no word for it."""


def spell_for_python(text: str) -> str:
    """Return a text with its marked fields as Python's arguments: ‹mm_per_px› becomes mm_per_px."""
    return FIELD_PATTERN.sub(r"\1\2", text.replace(f"{COMMAND_LINE_SOURCE}: ", ""))


SPELLINGS: list[Spelling] = [spell_for_python]
"""Spellings in use: that of Python, then those of running commands or pages; the last one is used."""


def spell(text: str) -> str:
    """Return a text with its marked fields (‹field›) as the running command's user writes them, or as in Python."""
    return SPELLINGS[-1](text) if "‹" in text else text


def spell_all(data: Any) -> Any:
    """Return a copy of nested lists and dictionaries, with `spell` applied to every text in their values."""
    if isinstance(data, str):
        return spell(data)
    if isinstance(data, Mapping):
        return {key: spell_all(value) for key, value in data.items()}
    if isinstance(data, (list, tuple)):
        values = map(spell_all, data)
        return type(data)(*values) if hasattr(data, "_fields") else type(data)(values)
    return data


class Remedy(NamedTuple):
    """Remedy for a mistake: what it does, and the values of keys to set."""

    words: str
    values: Mapping[str, bool | float | str | None]
    """Values by dotted keys. None leaves a key out; the command line does so automatically."""

    def __str__(self) -> str:
        """Describe what the remedy does, and how to write it on a command line."""
        keys = [f"{key} = {_format_value(value)}" for key, value in self.values.items() if value is not None]
        return ", ".join([self.words, *filter(None, [" and ".join(keys)])])


def _format_value(value: bool | float | str) -> str:
    """Format a value as in TOML, but text without quotes."""
    return str(value).lower() if isinstance(value, bool) else f"{value:g}" if isinstance(value, float) else value


class WalkergenError(Exception):
    """Base of every error that walkergen raises on purpose; its text is meant for the user.

    str() spells the fields of the text as the user writes them.

    Examples
    --------
    >>> import walkergen as wg
    >>> try:
    ...     wg.predict(gamma=-1.0)
    ... except wg.WalkergenError as error:
    ...     print("refused")
    refused
    """

    spelling: Spelling = staticmethod(spell)

    @property
    def text(self) -> str:
        """Text in which fields are still marked as ‹field›, for use in the text of another error."""
        return Exception.__str__(self)

    def __str__(self) -> str:
        """Return the text, with fields as the user of this process writes them."""
        return self.spelling(self.text)


@contextmanager
def use_spelling(spelling: Spelling) -> Iterator[None]:
    """Spell fields by the function `spelling` while a block runs, in all threads, and in errors that leave it."""
    SPELLINGS.append(spelling)
    try:
        yield
    except WalkergenError as error:
        error.spelling = spelling
        raise
    finally:
        SPELLINGS.remove(spelling)


class InputError(WalkergenError):
    """A user's value is unusable; the text reports the value and the allowed range."""

    keys: tuple[str, ...]
    """Key at fault for each line of the text; "" for a line without a key, empty if no line has one."""
    helps: Callable[[], Sequence[Remedy]]
    """Function that finds the remedies. It may be slow, so it is called only when the error is shown."""

    def __init__(self, text: str = "", *keys: str, helps: Callable[[], Sequence[Remedy]] = tuple) -> None:
        """Create the error. `keys`: key at fault of each line of the text. `helps`: function that finds remedies."""
        super().__init__(text)
        self.keys, self.helps = keys, helps

    @cached_property
    def remedies(self) -> tuple[Remedy, ...]:
        """Remedies listed at the end of the text; a page shows a button for each."""
        return tuple(self.helps())

    def resolve_remedies(self) -> Self:
        """Find the remedies now and keep them, so that the error can be sent to another process. Return this error."""
        self.helps = partial(tuple, self.remedies)
        return self

    @property
    def fault(self) -> str:
        """Text of the error without the remedies."""
        return str(self.args[0])

    @property
    def text(self) -> str:
        """Text of the error with the remedies, in which fields are still marked as ‹field›."""
        helps = ", or ".join(map(str, self.remedies))
        return f"{self.fault.rstrip('.')}. What helps: {helps}" if helps else self.fault


class GeometryError(InputError):
    """A design's parts cannot be built as drawn; the text names the limit that was passed."""


class PlateError(InputError):
    """Parts do not fit the printer's bed; the text gives the number that would fit."""


class PrintabilityError(InputError):
    """Parts would not print as drawn; the text has a line for each finding, with what to change."""


class SolidError(WalkergenError):
    """The solid modeller refused an operation or returned a body that is not sound."""


class TheoryError(WalkergenError):
    """A formula has no answer for the given numbers."""


class OutputError(WalkergenError):
    """A file or folder could not be written, or holds files that walkergen must not overwrite."""
