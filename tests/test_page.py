"""The report page as a file: what it holds, what it refuses, and that it trusts no text."""

import base64
import hashlib
import json
import math
import re
import shutil
from html.parser import HTMLParser
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from report_folder import add, edit, folder_of, rendered
from typer.testing import CliRunner

import walkergen
from walkergen.cli import command_line
from walkergen.errors import InputError, OutputError
from walkergen.files import viewer
from walkergen.jobs.page.report import chart, chart_data, contents, members, references

ROOT = Path(__file__).parent.parent
ASSETS = Path(walkergen.__file__).parent / "jobs" / "page" / "report" / "assets"
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
def family_folder(tmp_path_factory):
    return folder_of(tmp_path_factory.mktemp("family") / "mine")


@pytest.fixture
def folder(family_folder, tmp_path):
    return shutil.copytree(family_folder, tmp_path / "mine")


def parts_of(text):
    (data,) = re.findall(r'<script type="application/json" id="parts">(.*?)</script>', text)
    return json.loads(data)


def run(*words):
    return CliRunner().invoke(command_line, ["report", *map(str, words)])


def refused(folder):
    with pytest.raises(InputError) as caught:
        rendered(folder)
    assert "\n" not in str(caught.value)
    return str(caught.value)


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
    text = rendered(folder)
    parts = parts_of(text)
    assert [(part["tilt_deg"], part["legs"]) for part in parts] == [
        (tilt, kind) for kind in ("flexible", "braced") for tilt in (0.0, 10.0, 35.0)
    ]
    links = [link["download"] for link in Elements(text).all("a") if "data-stl" in link]
    assert links == [f"{part['name']}.stl" for part in parts]  # as the viewer counts them
    for part in parts:
        assert part["seen"]


def test_files_are_saved_whole_and_under_names_without_folders(folder):
    add(folder, "plates/a&b.csv", b"item\n1\n")
    add(folder, "plates/run.sh", b"echo no")
    saved = downloads(rendered(folder))
    manifest = json.loads((folder / "manifest.json").read_text(encoding="utf-8"))
    kinds = (".stl", ".3mf", ".csv", ".ini", ".json", ".pdf")
    wanted = [name for name in manifest["files"] if name.endswith(kinds)]
    assert sorted(saved) == sorted(Path(name).name for name in wanted)
    for name in wanted:
        assert saved[Path(name).name] == (folder / name).read_bytes()


def test_the_command_writes_one_file_that_asks_for_no_other(folder):
    result = run(folder, "--json")
    assert result.exit_code == 0, result.output
    told = json.loads(result.stdout)
    assert told == {"file": str(folder / "report.html"), "changed": [], "missing": []}
    data = (folder / "report.html").read_bytes()
    assert 0.5e6 < len(data) < 2e6
    page = Elements(data.decode())
    assert page.all("link") == [{"rel": "icon", "href": "data:,"}]
    assert all(image["src"].startswith("data:image/png;base64,") for image in page.all("img"))
    assert all("src" not in script for script in page.all("script"))
    assert len(page.all("img")) == 2  # parts, the map of one plate
    assert run(folder, "--out", folder / "again.html").exit_code == 0
    assert (folder / "again.html").read_bytes() == data


def test_the_policy_admits_the_two_scripts_and_nothing_from_outside(folder):
    text = rendered(folder)
    (policy,) = [meta["content"] for meta in Elements(text).all("meta") if "http-equiv" in meta]
    assert policy.startswith("default-src 'none'; img-src data:;")
    allowed = re.search("script-src (.*)", policy).group(1).split()
    scripts = re.findall(r"<script>(.*?)</script>", text, flags=re.DOTALL)
    digests = [hashlib.sha256(script.encode()).digest() for script in scripts]
    assert allowed == [f"'sha256-{base64.b64encode(digest).decode()}'" for digest in digests]


def test_text_of_files_is_shown_and_never_run(folder):
    edit(folder, lambda facts: facts["design"].update(name=HOSTILE, description=HOSTILE))
    table = (folder / "family.csv").read_text(encoding="utf-8")
    (folder / "family.csv").write_text(table.replace("both feet can stick", HOSTILE))
    add(folder, "plates/<b>.csv", f"item\n{HOSTILE}\n".encode())
    sheet = f"{HOSTILE}\n\n![x](//example.org/x.png)\n\n[link](javascript:alert(1))\n"
    add(folder, "print_sheet.md", sheet.encode())
    old = "stl/walker_t10.0_braced_s1.00.stl"
    add(folder, f"stl/{HOSTILE.replace('/', '|')}.stl", (folder / old).read_bytes())
    name = HOSTILE.replace("/", "|")
    edit(folder, lambda facts: facts["members"].__setitem__(4, name))
    page = Elements(rendered(folder))
    assert [script.get("type") for script in page.all("script")] == ["application/json", None, None]
    assert all(image["src"].startswith("data:") for image in page.all("img"))
    assert not [link for link in page.all("a") if link["href"].startswith("javascript:")]
    assert not [1 for _, attributes in page.found for key in attributes if key.startswith("on")]
    assert page.texts["h1"][0] == HOSTILE
    assert HOSTILE in page.texts["td"]
    assert name in page.texts["button"]


def test_a_changed_and_a_missing_file_are_told(folder):
    changed, missing = "stl/walker_t00.0_flexible_s0.40.stl", "stl/walker_t10.0_braced_s1.00.stl"
    (folder / changed).write_bytes((folder / "stl/walker_t35.0_flexible_s0.40.stl").read_bytes())
    (folder / missing).unlink()
    told = json.loads(run(folder, "--json").stdout)
    assert (told["changed"], told["missing"]) == ([changed], [missing])
    page = Elements((folder / "report.html").read_text(encoding="utf-8"))
    assert [text for text in page.texts["code"] if text.startswith("stl/")] == [changed, missing]
    (without,) = [part for part in parts_of(rendered(folder)) if not part["seen"]]
    assert f"stl/{without['name']}.stl" == missing
    text = run(folder).stdout
    assert f"{changed}: changed" in text
    assert f"{missing}: missing" in text


def test_plates_and_print_sheet_are_there_when_the_folder_has_them(folder):
    page = Elements(rendered(folder))
    assert "Map of the plate plates/family_prusa-mk3s_1.png" in [i["alt"] for i in page.all("img")]
    assert "Print sheet: family_prusa-mk3s, Prusa i3 MK3S / MK3S+" in page.texts["h3"]
    assert "walker_t10.0_flexible_s0.40" in page.texts["code"]
    for name in (folder / "plates").iterdir():
        name.unlink()
    edit(
        folder,
        lambda facts: facts.update(
            files={name: digest for name, digest in facts["files"].items() if "plates/" not in name}
        ),
    )
    text = rendered(folder)
    assert '<h2 id="print-heading">' not in text
    assert '<h2 id="plates-heading">' not in text


def test_every_setting_of_the_manifest_is_told(folder):
    cells = Elements(rendered(folder)).texts["td"]
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
    text = rendered(folder_of(tmp_path, (10.0,), law, pictures=False))
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


def test_a_page_that_is_not_ours_is_left_alone(folder):
    """Nor one of ours that somebody changed; wherever it lies."""
    assert run(folder).exit_code == 0
    made = (folder / "report.html").read_bytes()
    assert run(folder).exit_code == 0  # ours is made anew
    assert (folder / "report.html").read_bytes() == made
    elsewhere = folder.parent / "page.html"
    for page, words in ((folder / "report.html", ()), (elsewhere, ("--out", elsewhere))):
        for theirs in (b"mine", made + b"<!-- mine -->\n", made.replace(b"<title>", b"<title>my ")):
            page.write_bytes(theirs)
            result = run(folder, *words)
            assert isinstance(result.exception, OutputError)
            assert "not as walkergen wrote it: left alone" in str(result.exception)
            assert page.read_bytes() == theirs
        page.write_bytes(b"")
        assert run(folder, *words).exit_code == 0
        assert page.read_bytes() == made


def test_a_folder_that_family_did_not_write_is_refused(tmp_path):
    assert "walkergen family" in refused(tmp_path)
    assert "walkergen family" in refused(tmp_path / "nowhere")
    manifest = tmp_path / "manifest.json"
    for text, told in (("{", "not valid JSON"), ("[]", "its contents"), ("{}", "design"), ('{"design": 1}', "design")):
        manifest.write_text(text)
        assert told in refused(tmp_path)
    assert isinstance(run(tmp_path).exception, InputError)
    assert not (tmp_path / "report.html").exists()


@pytest.mark.parametrize("name", ["../secret.csv", "/etc/hostname", "stl/../../secret.csv"])
def test_a_manifest_never_leads_out_of_its_folder(folder, name):
    (folder.parent / "secret.csv").write_text("secret")
    edit(folder, lambda facts: facts["files"].update({name: "0" * 64}))
    assert f"{name!r} is not inside the folder" in refused(folder)


def test_broken_files_are_refused_by_name(folder):
    stl = folder / "stl" / "walker_t10.0_braced_s1.00.stl"
    whole = stl.read_bytes()
    for data in (whole[:-1], whole[:40], b"", whole[:80] + b"\0" * 4):
        stl.write_bytes(data)
        assert refused(folder).startswith("stl/walker_t10.0_braced_s1.00.stl: ")
    stl.write_bytes(whole)
    table = folder / "family.csv"
    lines = table.read_text(encoding="utf-8").splitlines()
    for broken, told in (
        (lines[:-1], "family.csv: 5 rows for 6 members"),
        ([*lines[:-1], lines[-1].replace("35.0", "nan", 1)], "family.csv:7: tilt_deg: must be a"),
        ([*lines[:-1], lines[-1].replace("braced", "", 1)], "family.csv:7: legs: missing"),
        ([*lines[:-1], lines[-1] + "x" * 200_000], "family.csv:7: not valid CSV"),
        ([*lines[:-1], lines[-1] + ",more"], "family.csv:7: 22 cells, the header has 21"),
    ):
        table.write_text("\n".join(broken), encoding="utf-8")
        assert refused(folder).startswith(told)
    table.unlink()
    assert refused(folder).startswith("family.csv: missing")


def test_the_page_does_not_overwrite_what_it_is_made_from(folder):
    before = (folder / "family.csv").read_bytes()
    result = run(folder, "--out", folder / "stl" / ".." / "family.csv")
    assert "one of the family's files" in str(result.exception)
    assert (folder / "family.csv").read_bytes() == before


def test_simulated_speeds_are_marks_of_their_own(folder):
    table = folder / "family.csv"
    first, *rows = table.read_text(encoding="utf-8").splitlines()
    more = ["57.5,2.5,52.5,62.5,compliant,event,4 ended", "60.5,,,,compliant,step,4 ended"]
    more += [",,,,rigid,event,4 toppled"] * 4
    columns = "sim_speed_mm_s,sim_se_mm_s,sim_low_95_mm_s,sim_high_95_mm_s"
    lines = [f"{first},{columns},sim_model,sim_method,sim_outcomes"]
    lines += [f"{row},{cells}" for row, cells in zip(rows, more, strict=True)]
    table.write_text("\n".join(lines), encoding="utf-8")
    drawn = chart.speeds(members.of(contents.read(folder)))
    labels = [point.label for point in drawn.points if point.simulated]
    assert labels == [
        "flexible legs, 0°: simulated 57.5 mm/s (95 %: 52.5 to 62.5)",
        "flexible legs, 10°: simulated 60.5 mm/s, error unknown",
    ]
    page = Elements(rendered(folder))
    assert "point flexible simulated" in [group.get("class") for group in page.all("g")]
    for cell in ("57.5 ± 2.5", "52.5 to 62.5", "60.5 ± ?", "4 toppled"):
        assert cell in page.texts["td"]
    assert any("Dormand" in text for text in page.texts["li"])
    assert any("Moreau" in text for text in page.texts["li"])


def test_marks_of_the_chart_lie_where_the_numbers_say(family_folder):
    found = members.of(contents.read(family_folder))
    drawn = chart.speeds(found)
    heights = {tick.text: tick.at for tick in drawn.y_ticks}
    top = drawn.y_ticks[-1]
    per_mm_s = (heights["0"] - top.at) / float(top.text)
    for point in drawn.points:
        speed = found[point.member].number("speed_mm_s")
        low, high = (found[point.member].number(f"speed_{end}_68_mm_s") for end in ("low", "high"))
        # coordinates are rounded to 0.01
        assert heights["0"] - point.y == pytest.approx(speed * per_mm_s, abs=0.03)
        assert point.low - point.high == pytest.approx((high - low) * per_mm_s, abs=0.03)


def test_the_chart_and_speed_png_have_one_source(folder, family_folder):
    """Lines, bands, measured and stated speeds of the page stand where speed.csv has them."""
    found = members.of(contents.read(family_folder))
    rows = chart_data.of(contents.read(family_folder))
    drawn = chart.speeds(found, rows)
    scale = {tick.text: tick.at for tick in drawn.y_ticks}
    per_mm_s = (scale["0"] - scale["100"]) / 100.0
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
    text = (folder / "speed.csv").read_text(encoding="utf-8")
    more = text + "measured,braced,10.0,12.0,11.0,13.0,10.04,13.96,,\nmeasured,flexible,10,5,,,,,,\n"
    (folder / "speed.csv").write_text(more, encoding="utf-8")
    *_, barred, bare = chart.speeds(found, chart_data.of(contents.read(folder))).marks
    assert barred.label == "braced legs, 10°: measured 12.0 mm/s (95 %: 10.0 to 14.0)"
    assert (bare.low, bare.label) == (None, "flexible legs, 10°: measured 5.0 mm/s")


@pytest.mark.parametrize(
    ("line", "told"),
    [
        ("hearsay,flexible,10,1,,,,,,", "speed.csv:2: what: must be predicted, measured, paper,"),
        ("predicted,wooden,10,1,,,,,,", "speed.csv:2: legs: must be flexible or braced, not 'wooden'"),
        ("predicted,flexible,nan,1,,,,,,", "speed.csv:2: tilt_deg: must be a number within ±1e+09"),
        ("predicted,flexible,10,1e300,,,,,,", "speed.csv:2: speed_mm_s: must be a number within"),
        ("predicted,flexible,10,,,,,,,", "speed.csv:2: tilt_deg, speed_mm_s: a number is missing"),
        ("predicted,flexible,10,1,x,,,,,", "speed.csv:2: speed_low_68_mm_s: must be a number"),
        ("predicted,flexible", "speed.csv:2: 2 cells, the header has 10"),
    ],
)
def test_a_broken_curve_is_refused_by_its_line(folder, line, told):
    path = folder / "speed.csv"
    header = path.read_text(encoding="utf-8").splitlines()[0]
    path.write_text(f"{header}\n{line}\n", encoding="utf-8")
    assert refused(folder).startswith(told)


def test_without_a_curve_the_chart_joins_the_members(folder):
    (folder / "speed.csv").unlink()
    text = rendered(folder)
    assert 'class="guide flexible"' in text
    assert "Lines only join the members" in text


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
