"""Appendices are written from stored data: `python tests/project/test_appendices.py` writes them again."""

import re
import tomllib
from pathlib import Path

import pytest

from evidence.tables import held_out
from evidence.validate import report

ROOT = Path(__file__).parents[2]
FOLDER = ROOT / "docs" / "appendix"
MADE_FROM = "This page is written from `docs/appendix/{}.toml` by `python tests/project/test_appendices.py`."


def rows(table):
    """Return the stored rows of a table, or those of the statements in another file that have all of its fields."""
    if "file" not in table:
        return table["rows"]
    sources = tomllib.loads((ROOT / table["file"]).read_text(encoding="utf-8"))["source"]
    statements = [source | one for source in sources for one in source.get("finding", source.get("statement"))]
    return [[one[field] for field in table["fields"]] for one in statements if one.keys() >= {*table["fields"]}]


def section(table):
    """Return a table with its title, its source and its date."""
    lines = [table["columns"], ["---"] * len(table["columns"]), *rows(table)]
    drawn = "\n".join(f"| {' | '.join(line)} |" for line in lines)
    parts = f"## {table['title']}", table.get("text"), drawn, f"Source: {table['source']}. Date: {table['date']}."
    return "\n\n".join(filter(None, parts))


def page(name):
    """Return the appendix of a file of data, TOML or the comparisons of `python -m evidence validate`."""
    if name == "validation":
        stored = report.read_rows(ROOT / "docs" / "validation.csv")
        return report.to_markdown(stored, "python -m evidence validate", "../validation.png")
    data = tomllib.loads((FOLDER / f"{name}.toml").read_text(encoding="utf-8"))
    lines = held_out.summarize(held_out.read_rows(), data["settings"]) if "settings" in data else []
    parts = f"# {data['title']}", MADE_FROM.format(name), data.get("text"), "\n".join(f"- {line}" for line in lines)
    return "\n\n".join([*filter(None, parts), *map(section, data["table"])]) + "\n"


PAGES = sorted({"validation"} | {path.stem for path in FOLDER.iterdir()})


@pytest.mark.parametrize("name", PAGES)
def test_an_appendix_is_that_of_its_data(name):
    assert (FOLDER / f"{name}.md").read_text("utf-8") == page(name), "run python tests/project/test_appendices.py"


@pytest.mark.parametrize("path", ["README.md", "docs/validation.md"])
def test_pages_state_the_verdicts_of_the_data(path):
    verdicts = [row.verdict for row in report.read_rows(ROOT / "docs" / "validation.csv")]
    numbers = [len(verdicts), *map(verdicts.count, ("agree", "disagree"))]
    assert re.search(r"Of {} .*?{} agree.*? {} d".format(*numbers), (ROOT / path).read_text("utf-8"), re.DOTALL)


if __name__ == "__main__":
    for one in PAGES:
        (FOLDER / f"{one}.md").write_text(page(one), encoding="utf-8")
