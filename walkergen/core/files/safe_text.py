"""Text that is safe to show: what strangers wrote must not steer a terminal, nor flood it.

Names, keys, cells and paths may hold escape sequences, letters that turn the direction of writing,
or halves of letters. They are shown as JSON writes them, so that JSON stays what it was.
"""

import re
import sys
from typing import Any, TextIO, cast

MAX_LINE_LENGTH, MAX_MESSAGE_LENGTH = 200, 1000
"""Longest line of foreign text in a message, and of a message, letters. The middle of a longer one is left out."""

HIDDEN_CHARACTERS = re.compile(
    "[\x00-\x08\x0b-\x1f\x7f-\x9f\xad\u061c\u180e\u200b-\u200f\u2028-\u202e\u2060-\u206f\ud800-\udfff"
    "\ufeff\ufff9-\ufffb\U000e0000-\U000e0fff]"
)
"""Letters that are not seen, or do something: controls, turns of direction, halves of letters."""


def escape_hidden(text: str) -> str:
    r"""Return the text with hidden letters as JSON escapes them: \u001b. Ends of lines and tabs stay."""
    return HIDDEN_CHARACTERS.sub(_escape, text)


def shorten_line(text: str, widest: int = MAX_LINE_LENGTH) -> str:
    """Return text as one line of at most `widest` letters, with hidden letters escaped. A long one loses its middle.

    The end of a message stays, because it says what to do.
    """
    shown = escape_hidden(text.replace("\n", "\\n"))
    if len(shown) <= widest:
        return shown
    end = widest // 3
    head, tail = re.sub(r" \S{0,30}$", "", shown[: widest - end - 5]), re.sub(r"^\S{0,30} ", "", shown[-end:])
    return f"{head} ... {tail}"


class EscapingStream:
    """Stream that escapes hidden letters of text before it writes them, optionally in lines of bounded length.

    Output of rich, whose colours are escape sequences, bypasses it.
    """

    def __init__(self, stream: TextIO, widest: int | None = None) -> None:
        self.rich_proxied_file = stream
        self.widest = widest

    def __getattr__(self, name: str) -> Any:
        return getattr(self.rich_proxied_file, name)

    def write(self, text: str) -> int:
        """Write text with its hidden letters escaped. Return the number of its letters."""
        if text == "\x1b[0m":  # colorama, which numba loads, resets colours on exit
            return self.rich_proxied_file.write(text)
        if self.widest is not None:
            text = "\n".join(shorten_line(row, self.widest) for row in text.split("\n"))
        self.rich_proxied_file.write(escape_hidden(text))
        return len(text)


def guard_output() -> None:
    """Escape hidden letters in all later output of this process. Lines of sys.stderr are also shortened."""
    sys.stdout = cast("TextIO", EscapingStream(sys.stdout))
    sys.stderr = cast("TextIO", EscapingStream(sys.stderr, MAX_MESSAGE_LENGTH))


def _escape(match: re.Match[str]) -> str:
    r"""Return the JSON escape of a matched letter, such as \u001b."""
    code = ord(match[0])
    if code <= 0xFFFF:
        return f"\\u{code:04x}"
    return f"\\u{0xD800 + (code - 0x10000 >> 10):04x}\\u{0xDC00 + (code & 0x3FF):04x}"
