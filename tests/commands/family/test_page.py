"""The report page as a file: what it holds, what it refuses, and that it trusts no text."""

import base64
import hashlib
import json
import re
import zlib
from html.parser import HTMLParser
from pathlib import Path

import numpy as np
import pytest
from report_folder import files_of, made_in, render_page, text_of

from walkergen.commands.family import report
from walkergen.core.errors import OutputError
from walkergen.core.numerics.quantity import Quantity
from walkergen.files import viewer, web_page

ROOT = Path(__file__).parents[3]
HOSTILE = "</script><script>alert(1)</script><img src=//example.org/x onerror=alert(1)>"


class Elements(HTMLParser):
    """Elements, their attributes, and the text of each kind of element."""

    def __init__(self, text):
        super().__init__()
        self.found, self.texts, self.inside = [], {}, []
        self.feed(text)

    def handle_starttag(self, tag, attributes):
        self.found.append((tag, dict(attributes)))
        self.inside.append(tag)

    def handle_endtag(self, tag):
        while self.inside and self.inside.pop() != tag:
            pass

    def handle_data(self, data):
        if self.inside:
            self.texts.setdefault(self.inside[-1], []).append(data)

    def all(self, tag):
        return [attributes for name, attributes in self.found if name == tag]


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """Report of a family with its page."""
    return made_in(tmp_path_factory.mktemp("family") / "mine")


@pytest.fixture(scope="module")
def folder(made):
    return made.folder


@pytest.fixture(scope="module")
def files(folder):
    return files_of(folder)


def held(text, name):
    """Content of a script of the page that holds data."""
    return re.search(rf'id="{name}">(.*?)</script>', text, re.DOTALL)[1]


def downloads(text):
    """Bytes behind every link that saves a file, by the name that it is saved under."""
    found = {}
    for link in Elements(text).all("a"):
        if "download" in link:
            head, data = link["href"].split(",", 1)
            assert re.fullmatch("data:[a-z]+/[a-z0-9]+;base64", head)
            found[link["download"]] = base64.b64decode(data, validate=True)
    return found


def test_every_part_is_seen_with_its_speed_and_saved_as_its_stl_file(made, folder):
    text = text_of(folder)
    parts = json.loads(held(text, "parts"))
    assert [(part["name"], part["kind"]) for part in parts] == [
        (f"walker_t{tilt}_{kind}", kind.partition("_")[0])
        for kind in ("flexible_s0.40", "braced_s1.00")
        for tilt in ("00.0", "10.0", "35.0")
    ]
    assert [re.sub(r"[0-9.]+", "n", part["words"]) for part in parts[:2]] == ["stands", "n ± n mm/s"]
    corners = np.frombuffer(zlib.decompress(base64.b64decode(held(text, "meshes"))), "<f4").reshape(-1, 3)
    assert len(corners) == 3 * sum(part["triangles"] for part in parts)
    mesh = made.members[0].mesh
    np.testing.assert_allclose(corners[: mesh.triangles.size], mesh.vertices[mesh.triangles.ravel()], atol=1e-5)
    links = {link["download"] for link in Elements(text).all("a") if "download" in link}
    assert {f"{part['name']}.stl" for part in parts} <= links


def test_files_are_saved_whole_and_under_names_without_folders(made, files):
    more = files | {"plates/a&b.csv": b"item\n1\n", "plates/run.sh": b"echo no"}
    saved = downloads(render_page(made, more))
    kinds = (".stl", ".3mf", ".csv", ".ini", ".json", ".pdf")
    assert saved == {Path(name).name: data for name, data in more.items() if name.endswith(kinds)}


def test_the_page_is_one_file_that_asks_for_no_other(folder):
    data = (folder / "report.html").read_bytes()
    assert 0.5e6 < len(data) < 2e6
    elements = Elements(data.decode())
    assert elements.all("link") == [{"rel": "icon", "href": "data:,"}]
    assert all(image["src"].startswith("data:image/png;base64,") for image in elements.all("img"))
    assert all("src" not in script for script in elements.all("script"))
    assert len(elements.all("img")) == 3  # speeds, parts, the map of one plate
    made_in(folder)  # ours is made again, and equal families have equal pages
    assert (folder / "report.html").read_bytes() == data


def test_the_policy_admits_the_two_scripts_and_nothing_from_outside(folder):
    text = text_of(folder)
    (policy,) = [meta["content"] for meta in Elements(text).all("meta") if "http-equiv" in meta]
    assert policy.startswith("default-src 'none'; img-src data:;")
    allowed = re.search("script-src (.*)", policy).group(1).split()
    scripts = re.findall(r"<script>(.*?)</script>", text, flags=re.DOTALL)
    digests = [hashlib.sha256(script.encode()).digest() for script in scripts]
    digests += [hashlib.sha256(zlib.decompress(base64.b64decode(held(text, "viewer")))).digest()]
    assert allowed == [f"'sha256-{base64.b64encode(digest).decode()}'" for digest in digests]


def test_text_of_files_is_shown_and_never_run(made, files):
    name = HOSTILE.replace("/", "|")
    sheet = f"{HOSTILE}\n\n![x](//example.org/x.png)\n\n[link](javascript:alert(1))\n"
    more = {"plates/<b>.csv": b"item\n", "print_sheet.md": sheet.encode(), f"stl/{name}.stl": b""}
    parts = [viewer.Part(name, "flexible", np.eye(3), np.array([[0, 1, 2]]), HOSTILE)]
    text = render_page(made, files | more, parts=parts, name=HOSTILE, description=HOSTILE)
    elements = Elements(text)
    kinds = ["application/json", "text/plain", "text/plain", None]
    assert [script.get("type") for script in elements.all("script")] == kinds
    assert all(image["src"].startswith("data:") for image in elements.all("img"))
    assert not [link for link in elements.all("a") if link["href"].startswith("javascript:")]
    assert not [1 for _, attributes in elements.found for key in attributes if key.startswith("on")]
    assert elements.texts["h1"][0] == HOSTILE
    assert f"stl/{name}.stl" in elements.texts["a"]
    assert json.loads(held(text, "parts"))[0]["name"] == name


def test_plates_and_print_sheet_are_there_when_the_folder_has_them(made, folder, files):
    elements = Elements(text_of(folder))
    assert "Map of the plate plates/family_prusa-mk3s_1.png" in [i["alt"] for i in elements.all("img")]
    assert "Print sheet: family_prusa-mk3s, Prusa i3 MK3S / MK3S+" in elements.texts["h2"]
    assert "walker_t10.0_flexible_s0.40" in elements.texts["code"]
    text = render_page(made, {name: data for name, data in files.items() if "plates/" not in name})
    assert "Print sheet" not in text
    assert "Map of the plate" not in text


def test_every_setting_of_the_manifest_is_told(folder):
    told = json.loads("".join(Elements(text_of(folder)).texts["pre"][-1:]))
    facts = json.loads((folder / "manifest.json").read_text(encoding="utf-8"))
    del facts["files"], facts["sealed"], facts["time_taken_s"]
    assert told == facts


def test_the_table_is_the_folders_with_its_notes(folder):
    page, table = Elements(text_of(folder)), (folder / "family.md").read_text(encoding="utf-8")
    cells = [
        cell for row in re.findall(r"^\| +\d.*", table, re.MULTILINE) for cell in re.findall(r"[^| ][^|]*[^| ]", row)
    ]
    assert len(cells) > 20
    assert set(cells) <= set(page.texts["td"])
    notes = re.findall("^- (.*)", table, re.MULTILINE)
    assert notes
    assert set(notes) <= {*page.texts["li"], *page.texts["p"]}


def test_a_page_that_somebody_changed_is_left_alone(tmp_path):
    made_in(tmp_path, (10.0,), pictures=False)
    (tmp_path / "report.html").write_bytes(b"mine")
    with pytest.raises(OutputError, match=r"report\.html.*not as walkergen wrote it: left alone"):
        made_in(tmp_path, (10.0,), pictures=False)
    assert (tmp_path / "report.html").read_bytes() == b"mine"


def test_a_walker_of_unknown_speed_says_so(made):
    speeds = {name: Quantity(name, "mm_s", None) for name in ("speed", "nominal")}
    unknown = [member._replace(row=member.row._replace(**speeds)) for member in made.members]
    assert {part.words for part in report.view_parts(unknown)} == {"no speed yet"}


def test_without_pictures_the_page_has_none(tmp_path):
    text = text_of(made_in(tmp_path, (10.0,), pictures=False).folder)
    assert not Elements(text).all("img")
    assert "canvas" in text


def test_the_bundle_is_built_from_the_viewer_here_and_keeps_its_licence():
    bundle = viewer.viewer_script()
    scripts = sorted((ROOT / "viewer").glob("*.js"))
    source = hashlib.sha256(b"".join(path.read_bytes() for path in scripts)).hexdigest()
    three = json.loads((ROOT / "viewer" / "package.json").read_text())["dependencies"]["three"]
    assert f"viewer/, sha256 {source}\nwith parts of three.js {three}:" in bundle
    assert "The above copyright notice and this permission notice shall be included" in bundle
    assert len(bundle) < 650_000
    for script in (bundle, web_page.read_asset("part.js")):
        assert not re.search(r"</script|<!--", script, flags=re.IGNORECASE)
