"""docs/story.md holds excerpts of the current code; `python tests/project/test_story.py` writes them again."""

import ast
import re
import textwrap
from pathlib import Path

ROOT = Path(__file__).parents[2]
PAGE = ROOT / "docs" / "story.md"
MARK = re.compile(r"^<!-- (\S+): (.+) -->\n(?:\n```\w+\n([\s\S]*?)^```\n)?", re.M)
LANGUAGES = {".py": "python", ".toml": "toml"}


def excerpt(path, name):
    """Return the source of a function or method of a file, or a table of a TOML file."""
    text = (ROOT / path).read_text(encoding="utf-8")
    if path.endswith(".toml"):
        return re.search(rf"^{re.escape(name)}\n(?:[^\[\n].*\n)*", text, re.M)[0]
    scope = ast.parse(text)
    for part in name.split("."):
        scope = next(node for node in scope.body if getattr(node, "name", "") == part)
    first = min(node.lineno for node in (scope, *scope.decorator_list))
    return textwrap.dedent("\n".join(text.splitlines()[first - 1 : scope.end_lineno])) + "\n"


def page_with_excerpts(page):
    """Return the page with its current excerpts."""

    def block(found):
        path, name = found[1], found[2]
        return f"<!-- {path}: {name} -->\n\n```{LANGUAGES[Path(path).suffix]}\n{excerpt(path, name)}```\n"

    return MARK.sub(block, page)


def test_the_story_shows_the_current_code():
    page = PAGE.read_text(encoding="utf-8")
    assert page_with_excerpts(page) == page, "run python tests/project/test_story.py"


def test_the_story_has_twelve_short_excerpts():
    found = MARK.findall(PAGE.read_text(encoding="utf-8"))
    assert len(found) == 12
    assert max(len(text.splitlines()) for _, _, text in found) <= 30


if __name__ == "__main__":
    PAGE.write_text(page_with_excerpts(PAGE.read_text(encoding="utf-8")), encoding="utf-8")
