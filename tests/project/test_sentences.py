"""Pages have short sentences. `python tests/project/test_sentences.py` prints the table of all pages."""

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PAGES = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *sorted((ROOT / "docs").glob("*.md"))]

MAX_MEAN = 18.0
"""Largest mean length of the sentences of a page, words."""

MAX_WORDS = 40
"""Length of the longest sentence allowed, words."""

TOO_LONG: dict[str, tuple[float, int]] = {}
"""Mean length and longest sentence of pages that exceed the limits. Values may only fall; delete rows that pass."""

ABBREVIATIONS = r"(?<!\beq\.)(?<!\beqs\.)(?<!\be\.g\.)(?<!\bi\.e\.)(?<!\bal\.)(?<!\bvs\.)"
SENTENCE_END = re.compile(rf"(?:(?<=[.!?])|(?<=[.!?][)\"”])){ABBREVIATIONS}\s+(?=[(\"“]*(?:[A-Z0-9±]|walkergen\b))")


def split_sentences(text: str) -> list[str]:
    """Return the sentences of a Markdown text. Code, tables, headings, pictures and addresses are left out."""
    text = re.sub(r"^ *(```+|~~~+).*?^ *\1 *$", "", text, flags=re.DOTALL | re.MULTILINE)
    text = re.sub(r"<!--.*?-->", "", text, flags=re.DOTALL)
    text = re.sub(r"!\[[^]]*\]\([^)]*\)", "", text)
    text = re.sub(r"\[([^]]*)\]\([^)]*\)", r"\1", text)
    sentences = []
    for block in re.split(r"\n\s*\n|\n(?= *(?:[-*+]|\d+\.) )|\n(?=[|#])|(?<=\|)\n", text):
        if re.match(r"\s*[|#]|\n* {4}", block):
            continue
        words = re.sub(r"^\s*(?:[-*+>]|\d+\.) ", "", block)
        words = re.sub(r"(`+)[^`]+\1", "Code", words).replace("*", "")
        sentences += [" ".join(part.split()) for part in SENTENCE_END.split(words) if count_words(part)]
    return sentences


def count_words(sentence: str) -> int:
    """Return the number of words. A number and a piece of code are one word each."""
    return sum(bool(re.search(r"\w", word)) for word in sentence.split())


def measure(page: Path) -> tuple[float, int]:
    """Return the mean length of the sentences of a page and the longest, words."""
    lengths = [count_words(sentence) for sentence in split_sentences(page.read_text(encoding="utf-8"))]
    return round(sum(lengths) / len(lengths), 1), max(lengths)


def name_of(page: Path) -> str:
    """Return the path of a page in the repository."""
    return page.relative_to(ROOT).as_posix()


@pytest.mark.parametrize("page", PAGES, ids=name_of)
def test_a_page_has_short_sentences(page):
    mean, longest = measure(page)
    short = mean <= MAX_MEAN and longest <= MAX_WORDS
    if name_of(page) not in TOO_LONG:
        assert short, f"mean {mean}, longest {longest}: {longest_sentences(page)}"
        return
    max_mean, max_words = TOO_LONG[name_of(page)]
    assert mean <= max_mean, f"mean {mean}"
    assert longest <= max_words, longest_sentences(page)
    assert not short, "the page passes: delete its row in TOO_LONG"


def longest_sentences(page: Path) -> str:
    """Return the three longest sentences of a page, one a line."""
    sentences = split_sentences(page.read_text(encoding="utf-8"))
    return "\n".join(sorted(sentences, key=count_words, reverse=True)[:3])


def test_every_row_has_its_page():
    assert set(TOO_LONG) <= {name_of(page) for page in PAGES}


def test_sentences_are_split_as_a_reader_does():
    text = """# A heading. Of two.

A [link](page.md#two.words) and `code. With a stop`. The paper's eq. 15 gives
68 % of **it**. walkergen runs (see there.) 3 mm
are one line:

| a table. Of cells | of 3 |
|---|---|

- One item
- Another item. In two
  sentences!

```sh
walkergen predict  # Not. A sentence.
```

    H = I/M. It is code

![A picture. Of two](picture.png)
"""
    assert split_sentences(text) == [
        "A link and Code.",
        "The paper's eq. 15 gives 68 % of it.",
        "walkergen runs (see there.)",
        "3 mm are one line:",
        "One item",
        "Another item.",
        "In two sentences!",
    ]
    assert count_words("68 % of it ± 0.1, and `predict` -") == 6


if __name__ == "__main__":
    for one in PAGES:
        mean, longest = measure(one)
        print(f'    "{name_of(one)}": ({mean}, {longest}),{"" if mean > MAX_MEAN or longest > MAX_WORDS else "  # passes"}')
