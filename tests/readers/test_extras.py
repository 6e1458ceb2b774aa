"""What only some need comes with extras, which a line names where they are missing."""

import importlib.util
import tomllib
from pathlib import Path

import pytest

from walkergen import extras
from walkergen.core.errors import InputError
from walkergen.readers.drawings import dxf

PROJECT = tomllib.loads((Path(__file__).parents[2] / "pyproject.toml").read_text("utf-8"))


@pytest.mark.parametrize("name", list(extras.PACKAGES))
def test_an_extra_is_named_by_the_line_and_brings_what_it_names(name, monkeypatch):
    asked = " ".join(PROJECT["project"]["optional-dependencies"][name])
    brings = {"dask": "distributed"}  # which brings dask
    for package in extras.PACKAGES[name].values():
        assert brings.get(package, package) in asked
    monkeypatch.setattr(importlib.util, "find_spec", lambda module: None)
    with pytest.raises(InputError, match=rf"this: .* not installed\. .*walkergen\[{name}\]"):
        extras.require(name, "this")


def test_drawings_without_their_extra_are_refused_in_a_line(monkeypatch):
    monkeypatch.setitem(extras.PACKAGES, "drawings", {"no_such_module": "ezdxf"})
    with pytest.raises(InputError, match=r"DXF: ezdxf not installed\. Run pip install 'walkergen"):
        dxf.pack([])
