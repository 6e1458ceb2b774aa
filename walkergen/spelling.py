"""How doors spell the fields that texts name: --mm-per-px on a command line, mm_per_px in Python."""

import re
from collections.abc import Iterator, Mapping
from contextlib import contextmanager

from walkergen.errors import DOORS, FIELD, SOURCE, Spelling, WalkergenError, for_python

KEY = re.compile(rf"{SOURCE}: ([\w.]+) = ")


def for_shell(text: str, names: Mapping[str, str] | None = None) -> str:
    """Return a text whose fields are flags; `names` are those that are not the field's name with dashes."""

    def flag(found: re.Match[str]) -> str:
        name, value = found.groups()
        if value == "=False":
            return f"--no-{name.replace('_', '-')}"
        return (names or {}).get(name, f"--{name.replace('_', '-')}") + (" " if value else "")

    return FIELD.sub(flag, text.replace(SOURCE, SOURCE[1:-1]))


def for_call(text: str, sets: Mapping[str, str]) -> str:
    """Return a text whose fields are Python's arguments; `sets` are the arguments of a call that set keys of files."""
    return for_python(KEY.sub(lambda found: f"‹{sets[found[1]]}=›" if found[1] in sets else found[0], text))


@contextmanager
def spelled_by(spelling: Spelling) -> Iterator[None]:
    """Spell fields in another way while a block runs, in all threads, and in errors that leave it."""
    DOORS.append(spelling)
    try:
        yield
    except WalkergenError as error:
        error.spelling = spelling
        raise
    finally:
        DOORS.remove(spelling)
