"""Pages have short sentences, and few words. `python tests/project/test_sentences.py` prints the words of each page."""

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PAGES = ["README.md", "CONTRIBUTING.md", *(str(page.relative_to(ROOT)) for page in sorted(ROOT.glob("docs/**/*.md")))]

MAX_MEAN, MAX_WORDS = 13.0, 25
"""Mean and largest length of the sentences of a page, words."""

MAX_TOTAL = 22_700
GENERATED = "gallery", "scenes"
HOW_TO = "app", "classroom", "crowds", "failing", "making", "measuring", "plate", "python", "running", "walkers"
MAX_PAGE = {"physics": 6000, "trusting": 1200} | dict.fromkeys(HOW_TO, 700)
"""Words of all pages of docs/ and of some, with tables and without code blocks and comments. They may only fall.

Pages in docs/appendix/ and GENERATED do not count: scripts write them.
"""

CODE = re.compile(r"^ *(```+)[\s\S]*?^ *\1 *$|<!--[\s\S]*?-->", re.MULTILINE)

NO_SENTENCES = re.compile(CODE.pattern + r"|!\[[^]]*\]\([^)]*\)|^ *[|#].*$|\n\n(?: {4}.*\n+)+", re.MULTILINE)
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


@pytest.mark.parametrize("page", PAGES)
def test_a_page_has_short_sentences(page):
    lengths = {one: count_words(one) for one in split_sentences((ROOT / page).read_text(encoding="utf-8"))}
    assert sum(lengths.values()) <= MAX_MEAN * len(lengths)
    assert [one for one, words in lengths.items() if words > MAX_WORDS] == []


def words_of_pages():
    """Return the words of each page of docs/ by its name."""
    pages = [page for page in sorted(ROOT.glob("docs/*.md")) if page.stem not in GENERATED]
    return {page.stem: len(CODE.sub("", page.read_text("utf-8")).split()) for page in pages}


def test_pages_have_few_words():
    words = words_of_pages()
    assert sum(words.values()) <= MAX_TOTAL
    assert {page: words[page] for page, limit in MAX_PAGE.items() if words[page] > limit} == {}


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
    print("\n".join(f"{count:6} {name}" for name, count in words_of_pages().items()))
