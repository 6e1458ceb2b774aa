"""Pictures of docs/ are of this code: each bears the digest of what it was made of."""

import importlib.util
import io
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

ROOT = Path(__file__).parents[2]
DOCS = ROOT / "docs"


def module():
    spec = importlib.util.spec_from_file_location("docs_pictures", DOCS / "pictures.py")
    found = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(found)
    return found


pictures = module()


@pytest.mark.pictures
def test_pictures_are_of_this_code():
    """Of its numbers and its drawing: comments and docstrings may change without them."""
    old = [one for one in pictures.PICTURES if pictures.is_stale(one)]
    names, took = ",".join(Path(one.name).stem for one in old), sum(one.seconds for one in old)
    assert not old, f"their code has moved on; some {took} s: make pictures ONLY={names}"


def test_every_picture_is_made_again_from_files_that_exist():
    names = [one.name for one in pictures.PICTURES]
    assert sorted(names) == sorted(path.name for path in DOCS.iterdir() if path.suffix in (".png", ".gif"))
    for one in pictures.PICTURES:
        for pattern in one.sources:
            assert list(ROOT.glob(pattern)), (one.name, pattern)
    assert pictures.MOVIE in (ROOT / "README.md").read_text(encoding="utf-8")


@pytest.mark.parametrize("form", ["PNG", "GIF"])
def test_a_picture_has_version_command_and_digest_and_looks_the_same(form, tmp_path):
    rng = np.random.default_rng(1)
    frames = [Image.fromarray(rng.integers(0, 9, (8, 8), np.uint8)) for _ in range(3)]
    data = io.BytesIO()
    more = {} if form == "PNG" else {"save_all": True, "append_images": frames[1:]}
    frames[0].save(data, form, **more)
    told = pictures.current_facts(pictures.PICTURES[0]) | {"Command": "walkergen family " + 300 * "x"}
    path = tmp_path / "picture"
    path.write_bytes(pictures.add_facts(data.getvalue(), told))
    assert pictures.read_facts(path) == told
    assert told["Software"].startswith("walkergen 0")
    with Image.open(path) as after, Image.open(data) as before:
        assert after.n_frames == before.n_frames if form == "GIF" else 1
        for number in range(3 if form == "GIF" else 1):
            after.seek(number)
            before.seek(number)
            assert after.convert("RGB").tobytes() == before.convert("RGB").tobytes()


CODE = '''
def f(x):  # what
    """Docstring, long."""
    return "# no comment" + g(x,  # Ω why
        2.0)
'''


def test_the_digest_covers_code_and_not_comments():
    same = 'def f(x):\n    "Other."\n    # more\n    return "# no comment" + g(x, 2.0)\n'
    assert pictures.strip_comments(CODE) == pictures.strip_comments(same) == 'deff(x):return"#nocomment"+g(x,2.0)'
    assert pictures.strip_comments(CODE.replace("2.0", "3.0")) != pictures.strip_comments(same)
