"""Work counted in executed lines of the package: the same on any machine, however busy."""

import sys
from collections.abc import Callable
from pathlib import Path
from types import FrameType
from typing import Any

import walkergen

PACKAGE = str(Path(walkergen.__file__).parent)


def lines(call: Callable[[], object]) -> int:
    """Lines of walkergen's Python that `call` executes in this thread."""
    count = 0

    def trace(frame: FrameType, event: str, argument: Any) -> Any:
        nonlocal count
        if not frame.f_code.co_filename.startswith(PACKAGE):
            return None
        count += event == "line"
        return trace

    before = sys.gettrace()
    sys.settrace(trace)
    try:
        call()
    finally:
        sys.settrace(before)
    return count
