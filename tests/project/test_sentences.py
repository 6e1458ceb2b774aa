"""Pages have short sentences. `python tests/project/test_sentences.py` prints the rows of TOO_LONG."""

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PAGES = ["README.md", "CONTRIBUTING.md", *(f"docs/{page.name}" for page in sorted((ROOT / "docs").glob("*.md")))]

MAX_MEAN = 18.0
"""Mean length of the sentences of a page, words."""

MAX_WORDS = 40
"""Length of the longest sentence, words."""

TOO_LONG: dict[str, tuple[float, int]] = {"docs/validation.md": (10.1, 48)}
"""Mean and largest length of sentences on pages beyond these limits. Numbers may only fall; delete rows that pass."""

NO_SENTENCES = re.compile(
    r"^ *(```+)[\s\S]*?^ *\1 *$|<!--[\s\S]*?-->|!\[[^]]*\]\([^)]*\)|^ *[|#].*$|\n\n(?: {4}.*\n+)+", re.MULTILINE
)
"""Code, comments, pictures, tables and headings."""

BLOCK_START = re.compile(r"(?:^|\n)\s*(?:[-*+>]|\d+\.) |\n\s*\n")
"""What separates paragraphs and items of lists."""

ABBREVIATIONS = "".join(rf"(?<!\b{word}\.)" for word in ("eq", "eqs", "e.g", "i.e", "al", "vs"))
SENTENCE_END = re.compile(rf'(?:(?<=[.!?])|(?<=[.!?][)"])){ABBREVIATIONS}\s+(?=[("]*(?:[A-Z0-9±]|walkergen\b))')


def split_sentences(markdown: str) -> list[str]:
    """Return the sentences of a page. The text of a link counts, not its address, and a piece of code is one word."""
    text = NO_SENTENCES.sub("\n\n", markdown)
    text = re.sub(r"\[([^]]*)\]\([^)]*\)", r"\1", text)
    text = re.sub(r"(`+)[^`]+\1", "Code", text)
    parts = [part for block in BLOCK_START.split(text) for part in SENTENCE_END.split(block.replace("*", ""))]
    return [" ".join(part.split()) for part in parts if count_words(part)]


def count_words(sentence: str) -> int:
    """Return the number of words and numbers."""
    return sum(bool(re.search(r"\w", word)) for word in sentence.split())


def measure(page: str) -> tuple[float, int, str]:
    """Return the mean length of the sentences of a page, the largest length, and the longest sentence."""
    sentences = split_sentences((ROOT / page).read_text(encoding="utf-8"))
    lengths = [count_words(sentence) for sentence in sentences]
    return round(sum(lengths) / len(lengths), 1), max(lengths), max(sentences, key=count_words)


@pytest.mark.parametrize("page", PAGES)
def test_a_page_has_short_sentences(page):
    mean, words, sentence = measure(page)
    max_mean, max_words = TOO_LONG.get(page, (MAX_MEAN, MAX_WORDS))
    assert mean <= max_mean
    assert words <= max_words, sentence
    assert page not in TOO_LONG or mean > MAX_MEAN or words > MAX_WORDS, "it passes: delete its row in TOO_LONG"


def test_sentences_are_split_where_a_reader_stops():
    page = """# A heading. Of two

A [link](page.md#two.words) and `code. Of two`. The paper's eq. 15 gives 68 % of *it*. walkergen
runs (see there.) 3 mm are one line:

| a table. Of cells |
|---|

- One item
- Another item. In two
  sentences!

```sh
walkergen predict  # Not. A sentence.
```

    H = I/M. It is code

![A picture. Of two](picture.png)
"""
    first = ["A link and Code.", "The paper's eq. 15 gives 68 % of it.", "walkergen runs (see there.)"]
    assert split_sentences(page) == [*first, *("3 mm are one line:", "One item", "Another item.", "In two sentences!")]
    assert [count_words(sentence) for sentence in first] == [4, 8, 4]


if __name__ == "__main__":
    for name in PAGES:
        mean_length, most, _ = measure(name)
        if mean_length > MAX_MEAN or most > MAX_WORDS:
            print(f'    "{name}": ({mean_length}, {most}),')
