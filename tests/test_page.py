"""The report page as a file: what it holds, what it refuses, and that it trusts no text."""

import base64
import hashlib
import json
import math
import re
from html.parser import HTMLParser
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from report_folder import files_of, job_of, made_in, rendered, silent, text_of

import walkergen
from walkergen.analysis.speeds import Measured
from walkergen.errors import OutputError
from walkergen.files import viewer
from walkergen.jobs.make.family import chart, chart_data, references
from walkergen.jobs.make.family import make as family
from walkergen.jobs.make.family.chart_data import ChartData
from walkergen.points.members import Simulated

ROOT = Path(__file__).parent.parent
ASSETS = Path(walkergen.__file__).parent / "jobs" / "make" / "family" / "assets"
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


def parts_of(text):
    (data,) = re.findall(r'<script type="application/json" id="parts">(.*?)</script>', text)
    return json.loads(data)


def downloads(text):
    """Bytes behind every link that saves a file, by the name that it is saved under."""
    found = {}
    for link in Elements(text).all("a"):
        if "download" in link:
            head, data = link["href"].split(",", 1)
            assert re.fullmatch("data:[a-z]+/[a-z0-9]+;base64", head)
            found[link["download"]] = base64.b64decode(data, validate=True)
    return found


def test_every_part_is_seen_and_saved_as_its_stl_file(folder):
    text = text_of(folder)
    parts = parts_of(text)
    assert [(part["tilt_deg"], part["legs"]) for part in parts] == [
        (tilt, kind) for kind in ("flexible", "braced") for tilt in (0.0, 10.0, 35.0)
    ]
    links = [link["download"] for link in Elements(text).all("a") if "data-stl" in link]
    assert links == [f"{part['name']}.stl" for part in parts]  # as the viewer counts them


def test_files_are_saved_whole_and_under_names_without_folders(made, files):
    more = files | {"plates/a&b.csv": b"item\n1\n", "plates/run.sh": b"echo no"}
    saved = downloads(rendered(made, more))
    kinds = (".stl", ".3mf", ".csv", ".ini", ".json", ".pdf")
    assert saved == {Path(name).name: data for name, data in more.items() if name.endswith(kinds)}


def test_the_page_is_one_file_that_asks_for_no_other(folder):
    data = (folder / "report.html").read_bytes()
    assert 0.5e6 < len(data) < 2e6
    elements = Elements(data.decode())
    assert elements.all("link") == [{"rel": "icon", "href": "data:,"}]
    assert all(image["src"].startswith("data:image/png;base64,") for image in elements.all("img"))
    assert all("src" not in script for script in elements.all("script"))
    assert len(elements.all("img")) == 2  # parts, the map of one plate
    family.make(job_of(), folder, silent, silent)  # ours is made anew, and equal families have equal pages
    assert (folder / "report.html").read_bytes() == data


def test_the_policy_admits_the_two_scripts_and_nothing_from_outside(folder):
    text = text_of(folder)
    (policy,) = [meta["content"] for meta in Elements(text).all("meta") if "http-equiv" in meta]
    assert policy.startswith("default-src 'none'; img-src data:;")
    allowed = re.search("script-src (.*)", policy).group(1).split()
    scripts = re.findall(r"<script>(.*?)</script>", text, flags=re.DOTALL)
    digests = [hashlib.sha256(script.encode()).digest() for script in scripts]
    assert allowed == [f"'sha256-{base64.b64encode(digest).decode()}'" for digest in digests]


def test_text_of_files_is_shown_and_never_run(made, files):
    name = HOSTILE.replace("/", "|")
    sheet = f"{HOSTILE}\n\n![x](//example.org/x.png)\n\n[link](javascript:alert(1))\n"
    more = {"plates/<b>.csv": f"item\n{HOSTILE}\n".encode(), "print_sheet.md": sheet.encode()}
    more |= {f"stl/{name}.stl": files[f"stl/{made.members[4].name}.stl"]}
    walkers = list(made.members)
    walkers[4] = walkers[4]._replace(name=name)
    text = rendered(made, files | more, walkers=walkers, name=HOSTILE, description=HOSTILE)
    elements = Elements(text)
    assert [script.get("type") for script in elements.all("script")] == ["application/json", None, None]
    assert all(image["src"].startswith("data:") for image in elements.all("img"))
    assert not [link for link in elements.all("a") if link["href"].startswith("javascript:")]
    assert not [1 for _, attributes in elements.found for key in attributes if key.startswith("on")]
    assert elements.texts["h1"][0] == HOSTILE
    assert HOSTILE in elements.texts["td"]
    assert name in elements.texts["button"]


def test_plates_and_print_sheet_are_there_when_the_folder_has_them(made, folder, files):
    elements = Elements(text_of(folder))
    assert "Map of the plate plates/family_prusa-mk3s_1.png" in [i["alt"] for i in elements.all("img")]
    assert "Print sheet: family_prusa-mk3s, Prusa i3 MK3S / MK3S+" in elements.texts["h3"]
    assert "walker_t10.0_flexible_s0.40" in elements.texts["code"]
    text = rendered(made, {name: data for name, data in files.items() if "plates/" not in name})
    assert '<h2 id="print-heading">' not in text
    assert '<h2 id="plates-heading">' not in text


def test_every_setting_of_the_manifest_is_told(folder):
    cells = Elements(text_of(folder)).texts["td"]
    facts = json.loads((folder / "manifest.json").read_text(encoding="utf-8"))
    for value in (
        facts["scene"]["drive"]["gamma"],
        facts["design"]["body"]["length_mm"],
        facts["seed"],
        facts["printer"]["gap_mm"],
        facts["versions"]["manifold3d"],
    ):
        assert str(value) in cells


@pytest.mark.parametrize(("law", "name"), [("poisson", "Routh"), ("newton", "Newton"), ("stronge", "Stronge")])
def test_only_the_law_in_use_is_cited(tmp_path, law, name):
    text = text_of(made_in(tmp_path, (10.0,), law, pictures=False).folder)
    cited = text[text.index('<ul id="references">') :]
    assert "Koumakis" in cited
    assert [one for one in ("Routh", "Newton", "Stronge") if one in cited] == [name]
    assert not [one for one in ("Dormand", "Moreau", "Numba", "Matplotlib") if one in cited]


def test_simulations_and_plates_are_cited_by_what_they_used():
    def uses(methods, files):
        return {reference.text.split(":")[0] for reference in references.cited({"poisson"}, methods, files)}

    nothing = uses(set(), [])
    numba = "S. K. Lam, A. Pitrou, S. Seibert"
    assert uses({"event"}, []) - nothing == {"J. R. Dormand, P. J. Prince", numba}
    assert uses({"step"}, []) - nothing == {"J. J. Moreau", numba}
    assert uses(set(), ["plates/a.3mf"]) - nothing == {"lib3mf, 3MF Consortium"}
    assert uses(set(), ["speed.png"]) - nothing == {"J. D. Hunter"}


def test_a_page_that_somebody_changed_is_left_alone(tmp_path):
    job = job_of((10.0,), pictures=False)
    family.make(job, tmp_path, silent, silent)
    (tmp_path / "report.html").write_bytes(b"mine")
    with pytest.raises(OutputError, match=r"report\.html.*not as walkergen wrote it: left alone"):
        family.make(job, tmp_path, silent, silent)
    assert (tmp_path / "report.html").read_bytes() == b"mine"


def test_simulated_speeds_are_marks_of_their_own(made, files):
    runs = [
        Simulated(57.5, 2.5, 52.5, 62.5, "compliant", "event", "4 ended", "agree"),
        Simulated(60.5, None, None, None, "compliant", "step", "4 ended", "unknown"),
        *[Simulated(None, None, None, None, "rigid", "event", "4 toppled", "unknown")] * 4,
    ]
    walkers = [member._replace(simulated=one) for member, one in zip(made.members, runs, strict=True)]
    labels = [point.label for point in chart.speeds(walkers).points if point.simulated]
    assert labels == [
        "flexible legs, 0°: simulated 57.5 mm/s (95 %: 52.5 to 62.5)",
        "flexible legs, 10°: simulated 60.5 mm/s, error unknown",
    ]
    elements = Elements(rendered(made, files, walkers=walkers))
    assert "point flexible simulated" in [group.get("class") for group in elements.all("g")]
    for cell in ("57.5 ± 2.5", "52.5 to 62.5", "60.5 ± ?", "4 toppled"):
        assert cell in elements.texts["td"]
    assert any("Dormand" in text for text in elements.texts["li"])
    assert any("Moreau" in text for text in elements.texts["li"])


def test_marks_of_the_chart_lie_where_the_numbers_say(made):
    drawn = chart.speeds(made.members)
    heights = {tick.text: tick.at for tick in drawn.y_ticks}
    top = drawn.y_ticks[-1]
    per_mm_s = (heights["0"] - top.at) / float(top.text)
    for point in drawn.points:
        row = made.members[point.member].row
        # coordinates are rounded to 0.01
        assert heights["0"] - point.y == pytest.approx(row.speed_mm_s * per_mm_s, abs=0.03)
        wide = row.speed_high_68_mm_s - row.speed_low_68_mm_s
        assert point.low - point.high == pytest.approx(wide * per_mm_s, abs=0.03)


def test_the_chart_stands_where_the_numbers_of_speed_csv_say(made):
    """Lines, bands, measured and stated speeds."""
    rows = made["speed"].rows
    drawn = chart.speeds(made.members, rows)
    scale = {tick.text: tick.at for tick in drawn.y_ticks}
    top = drawn.y_ticks[-1]
    per_mm_s = (scale["0"] - top.at) / float(top.text)
    along = {tick.text: tick.at for tick in drawn.x_ticks}
    per_deg = (along["20"] - along["0"]) / 20.0
    for line in drawn.lines:
        own = [row for row in rows if (row.what, row.legs) == ("predicted", line.legs)]
        value = {"predicted": "speed_mm_s", "theory": "theory_mm_s"}[line.what]
        places = np.array([point.split(",") for point in line.points.split()], float)
        wanted = [(along["0"] + per_deg * row.tilt_deg, scale["0"] - per_mm_s * getattr(row, value)) for row in own]
        assert places == pytest.approx(np.array(wanted), abs=0.05)
    braced, flexible = ([band.share for band in drawn.bands if band.legs == legs] for legs in ("braced", "flexible"))
    assert braced == flexible == [95, 68]
    for point in drawn.points:  # a member's predicted speed lies on its kind's curve
        line = next(one for one in drawn.lines if (one.what, one.legs) == ("predicted", point.legs))
        places = np.array([one.split(",") for one in line.points.split()], float)
        assert np.interp(point.x, *places.T) == pytest.approx(point.y, abs=0.7)
    (mark,) = drawn.marks
    assert mark.label == "flexible legs, 10°: stated by the paper 60.0 mm/s"
    assert mark.y == pytest.approx(scale["0"] - 60.0 * per_mm_s, abs=0.05)
    for se, bars in ((1.0, (10.0, 14.0)), (float("nan"), None)):
        measured = Measured(np.array([10.0]), ["braced"], np.array([12.0]), np.array([se]), np.array([31.0]), "")
        (mark,) = chart.speeds(made.members, chart_data.speeds(ChartData({}, measured))).marks
        told = "" if bars is None else " (95 %: 10.0 to 14.0)"
        assert (mark.label, mark.low is None) == (f"braced legs, 10°: measured 12.0 mm/s{told}", bars is None)


def test_without_a_curve_the_chart_joins_the_members(made, files):
    text = rendered(made, files)
    assert 'class="guide flexible"' in text
    assert "Lines only join the members" in text


def test_a_curve_is_broken_where_a_run_has_yet_to_tell(made):
    rows = made["speed"].rows
    told = [row for row in rows if not 15.0 < row.tilt_deg < 25.0]
    drawn, broken = (chart.speeds(made.members, shown) for shown in (rows, told))
    assert (drawn.gaps, broken.gaps) == (False, True)
    kinds = {row.legs for row in rows if row.what == "predicted"}
    for lines, count in ((drawn.lines, 1), (broken.lines, 2)):
        assert [line.what for line in lines].count("predicted") == count * len(kinds)
    joined = " ".join(line.points for line in drawn.lines if line.what == "predicted")
    assert set(" ".join(line.points for line in broken.lines if line.what == "predicted").split()) < set(joined.split())
    assert len(broken.bands) == 2 * len(drawn.bands)


def test_a_walker_of_unknown_speed_has_a_page_that_says_so(made, files):
    speeds = {name: None for name in made.members[0].row._fields if name.startswith(("speed_", "nominal_"))}
    unknown = [member._replace(row=member.row._replace(**speeds, note="a run tells")) for member in made.members]
    elements = Elements(rendered(made, files, walkers=unknown))
    assert not [svg for svg in elements.all("svg") if svg.get("id") == "chart"]
    assert any("without a run" in text for text in elements.texts["p"])
    assert elements.texts["td"].count("- [1]") == len(unknown)
    assert "[1] a run tells" in elements.texts["p"]


@given(st.floats(-1e3, 1e3), st.floats(1.0, 1e3))
def test_an_axis_has_four_to_ten_round_ticks_inside(low, width):
    found = chart.ticks(low, low + width)
    assert 4 <= len(found) <= 10
    step = found[1] - found[0]
    assert step / 10 ** math.floor(math.log10(step * 1.000001)) == pytest.approx(
        round(step / 10 ** math.floor(math.log10(step * 1.000001)))
    )
    assert low - 1e-6 <= found[0]
    assert found[-1] <= low + width + 1e-6


def test_the_bundle_is_built_from_the_viewer_here_and_keeps_its_licence():
    bundle = viewer.script()
    scripts = sorted((ROOT / "viewer").glob("*.js"))
    source = hashlib.sha256(b"".join(path.read_bytes() for path in scripts)).hexdigest()
    three = json.loads((ROOT / "viewer" / "package.json").read_text())["dependencies"]["three"]
    assert f"viewer/, sha256 {source}\nwith parts of three.js {three}:" in bundle
    assert "The above copyright notice and this permission notice shall be included" in bundle
    assert len(bundle) < 650_000
    for script in (bundle, (ASSETS / "page.js").read_text(encoding="utf-8")):
        assert not re.search(r"</script|<!--", script, flags=re.IGNORECASE)
