"""Contracts that every template, effect and printer keeps: a new one is tested without editing this file.

Those of commands are in test_command_contracts.py.
"""

import io
import itertools
import math
import re
import xml.etree.ElementTree as ElementTree
from pathlib import Path
from typing import get_args

import ezdxf
import numpy as np
import pytest
import threemf
import tomli_w
import trimesh
from command_checks import assert_every_form, assert_one_line

import walkergen as wg
from walkergen.commands.export.request import Format
from walkergen.core.errors import InputError, WalkergenError
from walkergen.core.printing import packing, plates
from walkergen.core.printing.printers import Printer
from walkergen.core.scene import Scene
from walkergen.core.shapes import modeller
from walkergen.core.simulation.effects import active_effects
from walkergen.core.simulation.effects.effect import Case
from walkergen.core.simulation.effects.resolve import replace_without_validation
from walkergen.core.walker import mass, solids
from walkergen.core.walker.design import Design
from walkergen.files import templates

PHYSICS = (Path(__file__).parents[2] / "docs" / "physics.md").read_text(encoding="utf-8")
PAPER = Design()
MODELS = {"walkers": Design, "scenes": Scene, "printers": Printer}
WALKERS, SCENES, PRINTERS = (templates.all_names(kind) for kind in MODELS)
TEMPLATES = [(kind, name) for kind in MODELS for name in templates.all_names(kind)]


def load(kind, name):
    """Return a template."""
    return templates.load(name, kind, MODELS[kind])


# --- templates -----------------------------------------------------------------------------------


@pytest.mark.parametrize(("kind", "name"), TEMPLATES)
def test_a_template_loads_and_its_toml_reads_back_as_itself(tmp_path, kind, name):
    model = load(kind, name)
    assert wg.load(name) == model
    assert model.name == name.rpartition("/")[2]
    assert model.description
    path = tmp_path / "again.toml"
    path.write_text(templates.to_toml(model, "comment", every=False), encoding="utf-8")
    assert templates.load(path, kind, MODELS[kind]) == model
    path.write_text(tomli_w.dumps({**model.model_dump(exclude_unset=True), "colour": "red"}), encoding="utf-8")
    with pytest.raises(WalkergenError, match="colour: unknown key") as refused:
        templates.load(path, kind, MODELS[kind])
    assert_one_line(refused.value)


@pytest.mark.parametrize("name", WALKERS)
def test_a_walker_is_closed_and_weighs_what_its_stl_file_weighs(tmp_path, name):
    design = load("walkers", name)
    found = solids.mass_of(design)
    assert min(float(found.M), float(found.J)) > 0.0
    assert all(float(leg.m) >= 0.0 and float(leg.j) >= 0.0 for leg in found.legs)
    walker = solids.build(design).walker
    density = design.material.density_g_cm3 * 1e-3
    ours, rival = mass.weigh(walker, density), trimesh.Trimesh(*walker, process=False)
    rival.density = density
    assert ours.mass == pytest.approx(rival.mass, rel=1e-12)
    np.testing.assert_allclose(ours.centre, rival.center_mass, atol=1e-11)
    np.testing.assert_allclose(ours.tensor, rival.moment_inertia, rtol=1e-9, atol=1e-9)
    wg.export(design, tmp_path / "walker.stl")
    theirs = trimesh.load(tmp_path / "walker.stl")
    assert theirs.is_watertight
    assert theirs.is_winding_consistent
    assert theirs.body_count == modeller.count_bodies(walker) == 1
    # Numbers of 32 bits in the file: 1e-6 of some 30 mm, over legs of some 0.4 mm
    theirs.density = density
    assert theirs.mass == pytest.approx(ours.mass, rel=1e-4)
    inertia = np.linalg.eigvalsh(ours.tensor)
    assert np.linalg.eigvalsh(theirs.moment_inertia) == pytest.approx(inertia, rel=1e-4)
    if not design.parts and design.cap is None:
        assert float(found.total) == pytest.approx(theirs.mass, rel=1e-4)


def parse_file(path):
    """Read a file with another program's library; raise if it is not sound."""
    if path.suffix == ".stl":
        assert trimesh.load(path).is_watertight
    elif path.suffix == ".3mf":
        found = threemf.read_3mf(path.read_bytes())
        assert (found.sound, len(found.items)) == (True, 1)
    elif path.suffix == ".dxf":
        assert len(ezdxf.readfile(path).modelspace()) > 0
    else:
        root = ElementTree.parse(path).getroot()
        assert list(root)
        assert root.tag.rpartition("}")[2] in ("svg", "mujoco")


@pytest.mark.parametrize("form", get_args(Format))
@pytest.mark.parametrize("name", WALKERS)
def test_a_walker_is_exported_in_every_format_and_read_back(tmp_path, name, form):
    try:
        report = wg.export(name, tmp_path / "out", format=form)
    except WalkergenError as refused:
        assert form in ("dxf", "svg", "mjcf")
        assert_one_line(refused)
        assert not (tmp_path / "out").exists()
        return
    for path in report.files:
        parse_file(path)
    assert any(path.suffix in (f".{form}", ".xml") for path in report.files)


@pytest.mark.parametrize("name", WALKERS)
@pytest.mark.parametrize("job", ["check", "predict"])
def test_a_walker_is_checked_and_predicted_or_refused_in_a_line(capsys, name, job):
    words = {"check": {}, "predict": {"model": "known"}}[job]
    try:
        assert_every_form(getattr(wg, job)(name, **words), capsys)
    except WalkergenError as refused:
        assert_one_line(refused)


def walker_on(scene):
    """Return the first walker that a scene takes: the paper's, but where a motor drives or a lid lies lower."""
    for design in [PAPER, *(load("walkers", name) for name in WALKERS)]:
        case = Case(scene, design, solids.mass_of(design))
        try:
            return case, [rule.decide(case) for rule in active_effects.all_rules()]
        except InputError as refused:
            assert_one_line(refused)
    raise AssertionError(f"no walker runs on {scene.name}")


@pytest.mark.parametrize("name", SCENES)
def test_explain_has_a_row_for_every_effect_of_a_scene(capsys, name):
    case, effects = walker_on(load("scenes", name))
    report = wg.explain(case.design, name, cost=False)
    assert [(row["effect"], row["on"]) for row in report.table] == [(effect.name, effect.on) for effect in effects]
    assert all(row["meaning"] and row["reason"] for row in report.table)
    assert_every_form(report, capsys)


# --- effects -------------------------------------------------------------------------------------

CASES = [
    Case(load("scenes", scene), design, solids.mass_of(design))
    for scene, design in (("plane-90hz", PAPER), ("table-motor", load("walkers", "coinbot")))
]
EFFECTS = {rule.decide(CASES[0]).name: rule for rule in active_effects.all_rules()}


def decide(rule, values):
    """Return the effect where a scene has other values of keys, on a walker with a motor where one is needed."""
    plain, driven = (case._replace(scene=replace_without_validation(case.scene, values)) for case in CASES)
    try:
        return rule.decide(plain)
    except InputError as refused:
        assert_one_line(refused)
        return rule.decide(driven)


@pytest.mark.parametrize("name", EFFECTS)
def test_an_effect_is_named_in_the_physics_and_its_number_is_finite(name):
    effect = decide(EFFECTS[name], {})
    assert math.isfinite(effect.number)
    assert effect.meaning and effect.reason  # noqa: PT018
    assert re.search(rf"\b{re.escape(name)}\b", PHYSICS)


@pytest.mark.parametrize("name", [name for name, rule in EFFECTS.items() if rule.off])
def test_an_effect_is_switched_off_and_is_on_at_its_usual_size(name):
    rule = EFFECTS[name]
    assert not decide(rule, rule.off).on
    if rule.typical_values:
        effect = decide(rule, {f"effects.{rule.switch}": None, **rule.typical_values})
        assert effect.on
        assert math.isfinite(effect.number)
    if rule.switch and "." not in rule.switch:
        assert not decide(rule, {**rule.typical_values, f"effects.{rule.switch}": False}).on
    for values in (rule.off, rule.typical_values):
        scene = replace_without_validation(CASES[0].scene, values)
        assert Scene.model_validate(scene.model_dump(exclude_unset=True)) == scene


# --- printers ------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", PRINTERS)
def test_a_plate_of_two_lies_apart_on_the_bed_and_its_3mf_reads_back(name):
    printer, members = load("printers", name), [PAPER, PAPER.variant(kind="braced")]
    built = [solids.build(design) for design in members]
    layout = plates.arrange(members, built, [1, 1], printer)
    files = dict(plates.layout_files(layout, "plate", draw=None))
    (data,) = (data for file, data in files.items() if file.endswith(".3mf"))
    found = threemf.read_3mf(data)
    assert found.sound
    (left, front), border = printer.bed_corner, packing.border_width(printer) - 2e-5  # 32 bits below 256 mm
    for item in found.items:
        assert left + border <= item.low[0] < item.high[0] <= left + printer.bed_width_mm - border
        assert front + border <= item.low[1] < item.high[1] <= front + printer.bed_depth_mm - border
        assert 0.0 == item.low[2] < item.high[2] <= printer.height_mm
    for one, other in itertools.combinations(found.items, 2):
        gaps = [max(one.low[k] - other.high[k], other.low[k] - one.high[k]) for k in (0, 1)]
        assert max(gaps) >= packing.spacing(printer) - 2e-5
    scene = trimesh.load(io.BytesIO(data), file_type="3mf")
    assert all(mesh.is_watertight for mesh in scene.geometry.values())
    assert len(scene.graph.nodes_geometry) == len(found.items) == len(plates.list_copy_positions(layout)) == 2
