"""The site builds without a warning, and holds what the README shows and the docstrings say."""

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent


@pytest.mark.slow
def test_the_site_builds_without_a_warning(tmp_path):
    command = [sys.executable, "-m", "mkdocs", "build", "--strict", "--site-dir", str(tmp_path)]
    found = subprocess.run(
        command, cwd=ROOT, env=os.environ | {"NO_MKDOCS_2_WARNING": "1"}, capture_output=True,
        text=True, check=False,
    )  # fmt: skip
    assert found.returncode == 0, found.stderr
    assert "WARNING" not in found.stderr
    page = (tmp_path / "api" / "theory" / "index.html").read_text()
    assert "walkergen.theory.impact" in page
    pictures = [path.name for path in (ROOT / "docs").glob("*.[pg][ni][gf]")]
    gallery = (tmp_path / "gallery" / "index.html").read_text()
    assert pictures
    for picture in pictures:
        assert (tmp_path / picture).exists()
        assert picture in gallery
    begin = (tmp_path / "index.html").read_text()
    loaded = re.findall(r'<(?:script|link|img)[^>]+(?:src|href)="(https?:[^"]+)"', begin)
    assert loaded == []  # nothing comes from elsewhere
