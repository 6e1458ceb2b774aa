"""First line of a command answers, and the last one names what to open next."""

import csv

import pytest
from typer.testing import CliRunner

from walkergen.cli import command_line
from walkergen.commands.family.request import FamilyRequest
from walkergen.core.errors import InputError
from walkergen.core.files.progress import silent
from walkergen.files import figures


def run(*words):
    result = CliRunner(env={"COLUMNS": "200"}).invoke(command_line, [*words], catch_exceptions=False)
    assert result.exit_code == 0, result.output
    return result.stdout.splitlines()


@pytest.mark.parametrize(
    ("words", "answer"),
    [
        ("predict --tilt 5,10", "2 walkers of koumakis2016; the fastest, 10 deg, runs at 51 mm/s (95 %: 34 to 74)"),
        (
            "predict --tilt 10",
            "koumakis2016, flexible legs, tilt 10 deg: 51 ± 11 mm/s; your print: 33.6 to 73.8 (95 %)",
        ),
        ("predict --tilt 5,10 --legs braced", "2 walkers of koumakis2016; all stand"),
        (
            "predict --tilt 10 --legs braced,flexible",
            "2 walkers of koumakis2016; the fastest, flexible legs, runs at 51 mm/s (95 %: 34 to 74)",
        ),
        (
            "predict --tilt=-10,5 --model theory",
            "2 walkers of koumakis2016; the fastest, 5 deg, runs at 68 mm/s (the paper's theory, eq. 15)",
        ),
        ("plate --tilt 10 --how-many", "one plate holds 105 of walker_t10.0_flexible_s0.40 (prusa-mk3s)"),
    ],
)
def test_the_first_line_answers(words, answer):
    assert run(*words.split())[0] == answer


def test_a_family_explains_its_speeds_only_on_request(tmp_path):
    words = ("family", "--tilt", "5,10", "--legs", "flexible", "--no-pictures", "--out", str(tmp_path))
    lines = run(*words)
    assert lines[0] == f"2 walkers in {tmp_path}; the fastest, 10 deg, runs at 51 mm/s (95 %: 34 to 74)"
    assert lines[-1] == f"next: print {tmp_path / 'plates' / 'family_prusa-mk3s_1.3mf'}"
    assert "eq. 15" not in "".join(lines)
    assert "eq. 15" in "".join(run(*words, "--why"))
    assert "eq. 15" in (tmp_path / "family.md").read_text()


def test_a_family_without_speeds_has_parts_and_masses_alone(tmp_path):
    lines = run("family", "--tilt", "5,10", "--no-speeds", "--out", str(tmp_path))
    assert lines[0] == f"4 walkers in {tmp_path}"
    assert lines[-1].startswith(f"next: look at {tmp_path / 'preview.png'}, then print ")
    assert "mm/s" not in "".join(lines)
    names = {path.name for path in tmp_path.iterdir()}
    assert names == {"family.csv", "family.md", "manifest.json", "plates", "preview.png", "stl", "weights.csv"}
    with (tmp_path / "family.csv").open(newline="") as file:
        assert next(csv.DictReader(file)).keys() == {"tilt_deg", "legs", "total_g", "M_g", "J_g_mm2", "m_g", "j_g_mm2"}
    assert "mm/s" not in (tmp_path / "family.md").read_text()


def test_a_flag_that_needs_speeds_is_refused_without_them():
    with pytest.raises(InputError, match=r"^simulate: needs speeds, which this request leaves out. Remove it.$"):
        FamilyRequest(speeds=False, simulate=True).run(silent)


def test_a_plate_names_its_map_and_its_first_file(tmp_path):
    lines = run("plate", "--tilt", "5,10", "--copies", "2", "--printer", "ender3,prusa-mk3s", "--out", str(tmp_path))
    assert lines[0] == "4 parts on 1 plate of ender3; 4 parts on 1 plate of prusa-mk3s"
    plate = tmp_path / "plates" / "plate_ender3_1"
    assert lines[-1] == f"next: look at {plate}.png, then print {plate}.3mf and 1 more"


def test_titles_of_pictures_answer_with_their_scene_and_are_all_different(tmp_path, monkeypatch):
    monkeypatch.setattr("walkergen.commands.accuracy.machine_speed.cpu_per_s", lambda: 0.05)
    titles, png = [], figures.png

    def record_title(figure, *words, **values):
        titles.append(figures.figure_title(figure))
        return png(figure)

    monkeypatch.setattr(figures, "png", record_title)
    for number, words in enumerate(
        (
            "family --tilt 5,10 --legs flexible",
            "family --tilt 5,10 --legs flexible --scene plane-90hz",
            "family --tilt 5,10 --legs flexible --no-speeds",
            "sweep --set legs.tilt_deg=5,10",
            "accuracy --tilt 10",
        )
    ):
        run(*words.split(), "--out", str(tmp_path / str(number)))
    titles = [title for title in titles if title and not title.startswith("family_")]
    answer = "the fastest, 10 deg, runs at 51 mm/s (95 %: 34 to 74)"
    assert titles[:2] == [
        f"koumakis2016 on lane-90hz (90 Hz, 1.8 g): {answer}",
        "2 walkers of koumakis2016 and how they run on lane-90hz",
    ]
    assert titles[2].startswith("koumakis2016 on plane-90hz (90 Hz, 1.8 g): the fastest, ")
    assert titles[4] == "2 walkers of koumakis2016"
    assert titles[5].startswith("Speed of koumakis2016 (lane-90hz, predicted): highest, 51.2 mm/s, at 10 deg")
    assert titles[6].startswith("Accuracy of koumakis2016, tilt 10°, on lane-90hz (measured): 20 % takes ")
    assert len(set(titles)) == len(titles) == 7
