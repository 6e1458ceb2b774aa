"""Any key from anywhere: `--set KEY=VALUE` on every command, and what it refuses."""

import json
import shlex
import sys
from pathlib import Path

import pytest
import typer
from command_checks import refusal_of

from walkergen import inputs
from walkergen.cli import command_line, main
from walkergen.core.errors import InputError
from walkergen.core.files import assignments
from walkergen.core.scene import Scene
from walkergen.core.walker.design import Design
from walkergen.files import templates
from walkergen.points import walkers

COMMAND_INPUTS = {
    ("accuracy",): "design scene",
    ("app",): "design scene printer",
    ("calibrate", "measurements.csv"): "design scene",
    ("check",): "design printer",
    ("crowd",): "design scene",
    ("explain",): "design scene",
    ("export", "--format", "mjcf"): "design scene",
    ("family",): "design scene printer",
    ("fit", "speeds.csv"): "design scene",
    ("movie",): "design scene",
    ("plate",): "design printer",
    ("predict",): "design scene",
    ("simulate",): "design scene",
}
WRONG_KEYS = {
    "design": ("legs.lenght_mm=8", "Did you mean legs.length_mm?"),
    "scene": ("scene.drive.gama=2", "Did you mean scene.drive.gamma?"),
    "printer": ("printer.nozle_mm=0.25", "Did you mean printer.nozzle_mm?"),
}
OUTSIDE_VALUES = {
    "design": ("body.length_mm=-5", "body.length_mm = -5: must be a number >= 1e-06"),
    "scene": ("scene.contact.restitution=1.5", "scene.contact.restitution = 1.5: must be a number"),
    "printer": ("printer.margin_mm=-9", "printer.margin_mm = -9: must be a number >= 0"),
}
PAIRS = [(words, thing) for words in COMMAND_INPUTS for thing in WRONG_KEYS]


def predict_json(run, *words):
    result = run("predict", *words, "--model", "theory", "--json")
    assert result.exit_code == 0, (words, result.exception)
    return result.stdout


@pytest.mark.parametrize(("words", "thing"), PAIRS)
def test_every_command_accepts_the_keys_of_its_inputs_only(run, words, thing):
    wrong, hint = WRONG_KEYS[thing]
    outside, allowed = OUTSIDE_VALUES[thing]
    if thing in COMMAND_INPUTS[words].split():
        assert hint in refusal_of(run, *words, "--set", wrong)
        assert allowed in refusal_of(run, *words, "--set", outside)
    else:
        assert f"this command takes no {thing}" in refusal_of(run, *words, "--set", wrong)


def test_every_command_with_a_design_a_scene_or_a_printer_is_covered():
    def commands(group, *path):
        for name, command in getattr(group, "commands", {}).items():
            yield from commands(command, *path, name)
        if not hasattr(group, "commands"):
            yield path, {option for one in group.params for option in (*one.opts, one.name)}

    found = dict(commands(typer.main.get_command(command_line)))
    loading = {path for path, options in found.items() if options & {"design", "scene", "--scene", "--printer"}}
    assert loading == {path for path, options in found.items() if "--set" in options}
    assert loading == {words[:1] for words in COMMAND_INPUTS} | {("sweep",)}  # whose values are axes: test_axes.py


@pytest.mark.parametrize(
    ("key", "flag"),
    [
        ("legs.tilt_deg=12", ("--tilt", "12")),
        ("legs.kind=braced", ("--legs", "braced")),
        ('legs.kind="braced"', ("--legs", "braced")),
        ("scene.contact.friction=0.1", ("--friction", "0.1")),
        ("scene.drive.gamma=2.2", ("--gamma", "2.2")),
        ("scene.drive.frequency_hz=80", ("--frequency", "80")),
    ],
)
def test_a_key_and_its_flag_are_one(run, key, flag):
    by_key = predict_json(run, "--set", key)
    assert by_key == predict_json(run, *flag) != predict_json(run)


def test_speeds_follow_the_drive_as_they_must(run):
    def predict_speed(*words):
        return json.loads(predict_json(run, *words))["rows"][0]["theory_mm_s"]

    base = predict_speed()  # in proportion to the plate's peak speed, gamma g / (2 pi f)
    assert predict_speed("--gamma", "3.6") == pytest.approx(2 * base)
    assert predict_speed("--frequency", "45") == pytest.approx(2 * base)
    assert predict_speed("--gamma", "0.9", "--frequency", "45") == pytest.approx(base)
    assert predict_speed("--gamma", "0.9", "--set", "scene.drive.frequency_hz=45") == pytest.approx(base)
    both = ("--set", "scene.drive.amplitude_um=50", "--set", "scene.drive.peak_speed_mm_s=62.4")
    assert predict_speed(*both) == pytest.approx(base * 62.4 / 31.216, rel=1e-4)


def test_all_values_reach_the_manifests(run):
    words = ("--set", "legs.length_mm=9", "--set", "printer.gap_mm=4", "--set", "name=longer")
    more = "--set family.tilt_deg=[12] --set scene.plate.slope_deg=1.5 --frequency 70 --no-pictures --quiet --out a"
    made = run("family", *words, *shlex.split(more), "--set", 'family.legs=["flexible"]')
    assert made.exit_code == 0, made.exception
    facts = json.loads(Path("a/manifest.json").read_text())
    assert facts["members"] == ["walker_t12.0_flexible_s0.40"]
    assert (facts["design"]["name"], facts["design"]["legs"]["length_mm"]) == ("longer", 9)
    assert facts["scene"]["plate"]["slope_deg"] == 1.5
    assert facts["scene"]["drive"]["frequency_hz"] == 70
    assert facts["printer"]["gap_mm"] == 4
    made = run("plate", *words, "--set", "legs.tilt_deg=12", "--no-pictures", "--quiet", "--out", "b")
    assert made.exit_code == 0, made.exception
    facts = json.loads(Path("b/plates/plate_prusa-mk3s.json").read_text())
    assert facts["designs"]["longer"]["legs"]["length_mm"] == 9
    assert facts["designs"]["longer"]["legs"]["tilt_deg"] == 12
    assert facts["printer"]["gap_mm"] == 4


LEANING_WALKER = """
stance = "as built"
[[legs]]
foot = "round"
along_mm = -6.0
length_mm = {length}
[[legs]]
foot = "round"
along_mm = 6.0
"""


def test_a_key_means_what_its_line_in_the_file_means(run, tmp_path):
    """A leg of a walker that leans: set after it was turned onto its feet, it would hover."""
    for length in (7.5, 8.5):
        text = 'name = "leaning"\n' + LEANING_WALKER.format(length=length)
        (tmp_path / f"l{length}.toml").write_text(text)
    by_file = predict_json(run, "l8.5.toml")
    assert predict_json(run, "l7.5.toml", "--set", "legs[1].length_mm=8.5") == by_file
    assert predict_json(run, "l7.5.toml", "--set", "legs[01].length_mm=8.5") == by_file
    assert predict_json(run, "l7.5.toml") != by_file


def test_paths_in_values_are_relative_to_the_current_folder(run, tmp_path):
    (tmp_path / "sub").mkdir()
    (tmp_path / "sub" / "disc.toml").write_text(
        '[body]\noutline = "disc"\n[[legs]]\nalong_mm = -4.0\nwidth_mm = 4.0\n'
        "[[legs]]\nalong_mm = 4.0\nwidth_mm = 4.0\n"
    )
    (tmp_path / "box.svg").write_text(
        '<svg xmlns="http://www.w3.org/2000/svg" width="20mm" height="12mm" viewBox="0 0 20 12">'
        '<path d="M0 0H20V12H0Z"/></svg>'
    )
    (row,) = json.loads(predict_json(run, "sub/disc.toml", "--set", "body.outline=box.svg"))["rows"]
    assert row["M_g"] == pytest.approx(20 * 12 * 3 * 1.24e-3, rel=1e-3)
    told = refusal_of(run, "predict", "sub/disc.toml", "--set", "body.outline=disc.svg")
    assert told == "command line: disc.svg: no such file. Check the path."


def test_the_exit_code_is_two(run, monkeypatch, capsys):
    monkeypatch.setattr(sys, "argv", ["walkergen", "predict", "--set", "legs.tlt_deg=1"])
    with pytest.raises(SystemExit, match="2"):
        main()
    assert capsys.readouterr().err == ("error: command line: legs.tlt_deg: unknown key. Did you mean legs.tilt_deg?\n")


def test_every_key_of_the_templates_can_be_set_to_its_own_value():
    """Round trip of every number and word of every template: the section stays the same."""
    for kind, model in (("walkers", Design), ("scenes", Scene)):
        for name in templates.names(kind):
            section = templates.load(name, kind, model)
            for key, value in leaves(section.model_dump(exclude_unset=True)):
                word = json.dumps(value, ensure_ascii=False)
                one, text = assignments.split_key_value(f"{key}={word}")
                assert assignments.replace_values(section, {one: assignments.parse_value(text)}) == section


def leaves(data, before=""):
    for key, value in data.items():
        if isinstance(value, dict):
            yield from leaves(value, f"{before}{key}.")
        elif isinstance(value, list) and isinstance(value[0], dict):
            for number, entry in enumerate(value, start=1):
                yield from leaves(entry, f"{before}{key}[{number}].")
        else:
            yield before + key, value


def test_a_set_key_overrides_a_default_of_the_command(tmp_path):
    def make_inputs(values):
        return inputs.from_settings(values, {}, ("design", "scene"))

    own = {"scene.run.seconds": 4.0, "scene.run.runs": 3}
    assert make_inputs({"scene.run.seconds": 7}).scene("lane-90hz", own).run.seconds == 7
    assert make_inputs({"scene.run.seconds": 7}).scene("lane-90hz", own).run.runs == 3
    assert make_inputs({"scene.run": {"seconds": 7}}).scene("lane-90hz", own).run.seconds == 7
    with pytest.raises(InputError, match="takes no printer") as caught:
        make_inputs({"printer.gap_mm": 1})
    assert caught.value.keys == ("printer.gap_mm",)


SHORT_RUN = ("--restitution", "0.8", "--seconds", "0.2", "--runs", "4", "--json")


@pytest.mark.slow
def test_several_walkers_give_the_rows_that_each_gives_alone(run):
    several = run("simulate", "--legs", "braced", "--tilt", "0:10:5", *SHORT_RUN)
    rows = json.loads(several.stdout)["rows"]
    assert [(row["tilt_deg"], row["legs"]) for row in rows] == [(tilt, "braced") for tilt in (0.0, 5.0, 10.0)]
    for row in rows:
        alone = json.loads(run("simulate", "--legs", "braced", "--tilt", str(row["tilt_deg"]), *SHORT_RUN).stdout)
        same = set(row) & set(alone)
        assert same >= {"speed_mm_s", "speed_se_mm_s", "speed_low_95_mm_s", "outcomes", "runs"}
        assert {key: row[key] for key in same} == {key: alone[key] for key in same}
        told = run("predict", "--legs", "braced", "--tilt", str(row["tilt_deg"]), "--restitution", "0.8", "--json")
        (known,) = json.loads(told.stdout)["rows"]
        assert row["theory_mm_s"] == known["theory_mm_s"]
        assert row["predicted_mm_s"] == known["speed_mm_s"]
    table = run("simulate", "--legs", "braced", "--tilt", "5,10", *SHORT_RUN[:-1]).stdout
    assert max(len(line) for line in table.splitlines()) <= 80
    assert "90 Hz, 1.8 g, 31.2 mm/s" in table
    assert "-0.0" not in table


def test_ctrl_c_shows_the_finished_rows_and_names_the_others(run, monkeypatch):
    simulate, done = walkers.simulate, []

    def stop_early(asked, progress, threads=None):
        if done:
            raise KeyboardInterrupt
        done.append(asked)
        return simulate(asked, progress, threads)

    monkeypatch.setattr(walkers, "simulate", stop_early)
    result = run("simulate", "--legs", "braced", "--tilt", "5,10,15", *SHORT_RUN)
    assert result.exit_code == 130
    assert [row["tilt_deg"] for row in json.loads(result.stdout)["rows"]] == [5.0]
    told = "interrupted after 1 of 3 walkers; missing: 10 deg braced, 15 deg braced"
    assert f"warning: {told}" in result.stderr.splitlines()


def test_ctrl_c_reports_the_finished_runs_as_partial(run, monkeypatch, tmp_path):
    simulate = walkers.simulate

    def stop_early(asked, progress, threads=None):
        return simulate(asked.with_run_settings(runs=2), progress)._replace(walker=asked)

    words = ("simulate", "--legs", "braced", "--tilt", "5", *SHORT_RUN, "--trajectory", "runs.csv")
    assert json.loads(run(*words).stdout)["partial"] is False
    whole = (tmp_path / "runs.csv").read_bytes()
    monkeypatch.setattr(walkers, "simulate", stop_early)
    result = run(*words)
    assert result.exit_code == 130
    found = json.loads(result.stdout)
    assert (found["runs"], found["partial"]) == (2, True)
    told = ["warning: interrupted after 2 of 4 runs", "warning: runs.csv: not written"]
    assert result.stderr.splitlines()[-2:] == told
    assert (tmp_path / "runs.csv").read_bytes() == whole


def test_an_impossible_walker_is_reported_before_any_run(run, monkeypatch):
    monkeypatch.setattr(walkers, "simulate", None)
    assert "A tilt up to" in refusal_of(run, "simulate", "--tilt", "5,80")
