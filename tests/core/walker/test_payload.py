"""Motors and batteries that walkers carry: their masses, pockets, prints, and hostile places."""

import math

import numpy as np
import pytest
import trimesh
from mesh_checks import to_trimesh

from walkergen.commands.export import profile
from walkergen.commands.plate.request import PlateRequest
from walkergen.core.errors import GeometryError, InputError
from walkergen.core.files import config
from walkergen.core.printing import checks
from walkergen.core.printing.pocket_checks import ceiling_span, thinnest_wall
from walkergen.core.printing.printers import Printer
from walkergen.core.shapes import modeller
from walkergen.core.walker import names, pockets, solids, weighed_masses
from walkergen.core.walker.design import Design
from walkergen.files import templates

CARRIERS = ("bristlebot", "coinbot", "spinner")


def load_walker(name):
    return templates.load(name, "walkers", Design)


def printer_of(name):
    return templates.load(name, "printers", Printer)


def design_of(**tables):
    return Design.model_validate(tables)


def refusal_of(**tables):
    """Line of the refusal of a walker, whether by its keys or once its solids are built."""
    with pytest.raises((GeometryError, InputError)) as caught:
        solids.build(config.validate(tables, Design, "my.toml"))
    return str(caught.value)


def shift_tensor(mass, tensor, arm):
    return tensor + mass * (arm @ arm * np.eye(3) - np.outer(arm, arm))


def rival_mass(design):
    """Mass, centre and tensor of a whole walker: trimesh's of the printed part, closed forms of what it carries."""
    depth, share = design.size.depth, design.pocket_settings.glue_g / 2.0
    part = trimesh.Trimesh(*solids.build(design).walker, process=False)
    part.density = 1e-3 * design.material.density_g_cm3
    pieces = [(part.mass, part.center_mass, part.moment_inertia)]
    motor = design.motor
    shapes = {"motor": (motor.diameter_mm, motor.height_mm, motor.mass_g), "battery": (20.0, 3.2, 2.9)}
    places = []
    for name, (diameter, height, mass) in shapes.items():
        one, mass = design.parts[name], mass + share
        places.append(np.array([one.along_mm, one.up_mm, one.across_mm + 0.5 * depth]))
        across = mass * (diameter**2 / 16.0 + height**2 / 12.0)
        about = {"along": 0, "up": 1, "across": 2}[one.axis]
        tensor = np.diag([mass * diameter**2 / 8.0 if i == about else across for i in range(3)])
        pieces.append((mass, places[-1], tensor))
    rod, wires = places[1] - places[0], design.pocket_settings.wires_g
    thin = wires / 12.0 * (rod @ rod * np.eye(3) - np.outer(rod, rod))
    pieces.append((wires, 0.5 * (places[0] + places[1]), thin))
    total = sum(mass for mass, _, _ in pieces)
    centre = sum(mass * place for mass, place, _ in pieces) / total
    return total, centre, sum(shift_tensor(mass, own, at - centre) for mass, at, own in pieces)


@pytest.mark.parametrize("name", CARRIERS)
def test_masses_add_the_printed_part_and_its_payload(name):
    """Rigid legs, so that the whole is one solid; flexible ones only part it otherwise."""
    design = load_walker(name)
    if design.has_legs_table:
        design = design.variant(kind="braced")
    found = solids.mass_of(design)
    total, centre, tensor = rival_mass(design)
    # Both weigh the same triangles; rounding grows with the distance from trimesh's origin
    assert found.total == pytest.approx(total, rel=1e-9)
    O = centre[:2] if found.rigid else centre[:2] - found.centre  # noqa: E741
    anchors = np.array([limb.anchor for limb in design.limbs])
    for leg, anchor in zip(found.legs, anchors, strict=True):
        np.testing.assert_allclose(leg.anchor, anchor - O, atol=1e-8)
    if found.rigid:
        assert found.J == pytest.approx(tensor[2, 2], rel=1e-9)
        assert found.spatial.z == pytest.approx(centre[2] - 0.5 * design.size.depth, abs=1e-8)
        np.testing.assert_allclose(found.spatial.body, tensor, rtol=1e-9, atol=1e-7)


def test_a_motor_off_the_middle_moves_the_centre_of_mass_across():
    spinner = load_walker("spinner")
    mirrored = spinner.variant(**{"motor.across_mm": -spinner.motor.across_mm})
    right, left = (solids.mass_of(design) for design in (spinner, mirrored))
    assert right.spatial.z == pytest.approx(-left.spatial.z, abs=1e-9)
    assert right.spatial.z > 1.0


@pytest.mark.parametrize("key", ["motor.mass_g", "battery.mass_g", "pockets.wires_g", "pockets.glue_g"])
def test_every_gram_that_is_carried_counts_once(key):
    design = load_walker("coinbot")
    table, name = key.split(".")
    own = getattr(getattr(design, table), name) or 2.9  # a CR2032's
    before, after = (solids.mass_of(one).total for one in (design, design.variant(**{key: own + 0.5})))
    assert after - before == pytest.approx(0.5, rel=1e-9)


@pytest.mark.parametrize("name", CARRIERS)
def test_parts_go_into_their_pockets_with_their_clearance(name):
    """Rival: distances of points of the printed surface from the parts, in closed form."""
    design = load_walker(name)
    built = solids.build(design)
    printed = trimesh.Trimesh(*built.walker, process=False)
    assert printed.is_watertight
    assert modeller.count_bodies(built.walker) == 1
    sampled, _ = trimesh.sample.sample_surface(printed, 50_000, seed=1)
    points = np.concatenate([printed.vertices, sampled])
    for part in design.parts.values():
        own = part.cylinder
        way = points - own.centre_in_design(design.size.depth)
        beyond = np.abs(way[:, own.axis]) - 0.5 * own.height
        aside = np.linalg.norm(np.delete(way, own.axis, axis=1), axis=1) - own.radius
        outside = np.hypot(np.maximum(beyond, 0.0), np.maximum(aside, 0.0))
        # Chords of the pocket, of 128 edges, come 3 um closer
        assert outside.min() == pytest.approx(design.pocket_settings.clearance_mm, abs=0.004)


def test_wires_lead_from_pocket_to_pocket():
    """A channel joins them; without one they are apart, and its plastic is there."""
    design = load_walker("bristlebot")
    closed = design.variant(**{"pockets.channel_mm": 0.0})
    with_channel, without = (trimesh.Trimesh(*solids.build(one).body, process=False) for one in (design, closed))
    # A bore of 1 mm^2 through the wall, at least 0.4 mm thick, and no more than the way it leads
    lost = without.volume - with_channel.volume
    way = math.hypot(design.motor.along_mm - design.battery.along_mm, 10.0)
    assert 0.4 < lost < way
    assert with_channel.euler_number == without.euler_number - 2  # one tunnel


@pytest.mark.parametrize("printer", ["ender3", "prusa-mk3s"])
@pytest.mark.parametrize("name", CARRIERS)
def test_shipped_carriers_print_without_warnings(name, printer):
    design = load_walker(name)
    lying = solids.orient_for_print(design, solids.build(design).walker)
    findings = checks.check_part(name, design, lying, printer_of(printer))
    assert not [finding for finding in findings if finding.level != "advice"]


def test_a_pocket_is_judged_by_the_way_that_its_walker_prints():
    """On its side a pocket open to the side has no ceiling, upside down one open below."""
    side, upside = load_walker("coinbot"), load_walker("bristlebot")
    assert solids.is_printed_on_side(side)
    assert not solids.is_printed_on_side(upside)
    for design, free in ((side, "side"), (upside, "down")):
        for opens in ("up", "down", "side"):
            part = design.battery.model_copy(update={"opens": opens})
            span = 0.0 if opens == free else 20.4  # across the cell and its clearance
            assert ceiling_span(part, design) == pytest.approx(span)
    # The motor's slot is bridged the short way
    assert ceiling_span(upside.motor, upside) == pytest.approx(3.1)


def messages(design, printer):
    lying = solids.orient_for_print(design, solids.build(design).walker)
    findings = checks.check_part("it", design, lying, printer)
    return [finding.line for finding in findings if finding.level == "warning"]


def test_a_ceiling_too_wide_for_a_bridge_is_reported():
    over = load_walker("bristlebot").variant(**{"battery.opens": "up", "battery.up_mm": 1.0, "pockets.channel_mm": 0.0})
    (line,) = messages(over, printer_of("prusa-mk3s"))
    assert "battery" in line
    assert "20.4 mm, limit 10 mm" in line
    assert "battery.opens = 'down'" in line


def test_walls_around_pockets_are_distinguished():
    spinner = load_walker("spinner")
    corner = math.hypot(0.5 * 10.4, 12.7 + 0.5 * 3.1)
    assert thinnest_wall(spinner.motor, spinner) == pytest.approx(17.0 - corner, abs=0.001)
    assert thinnest_wall(spinner.battery, spinner) == pytest.approx(17.0 - 10.2, abs=0.001)
    outward = {"motor.across_mm": 14.3, "pockets.channel_mm": 0.0}
    (line,) = messages(spinner.variant(**outward), printer_of("prusa-mk3s"))
    assert "wall around the pocket of the motor" in line
    assert "0.3184 mm, limit 0.45 mm" in line  # 17 - hypot(5.2, 15.85)


def test_walls_of_pockets_that_open_to_the_side_are_reported():
    """A body 6 mm thick: floor and lid in closed form; over what stands out there is none."""
    design = load_walker("coinbot")
    assert thinnest_wall(design.battery, design) == pytest.approx(3.0 - (0.4 + 1.8), abs=1e-6)
    assert thinnest_wall(design.motor, design) == pytest.approx(3.7 - 5.2 + 3.0, abs=1e-6)
    thin = design.variant(**{"battery.up_mm": 0.9})
    (line,) = messages(thin, printer_of("ender3"))
    assert "wall around the pocket of the battery" in line
    assert "0.3 mm, limit 0.4 mm" in line
    round_ones = design.variant(
        **{"motor.axis": "along", "motor.diameter_mm": 4.0, "motor.up_mm": 0.2, "motor.across_mm": 4.0}
    )
    lid = 3.0 - (0.2 + 2.2)  # a cylinder along the body: its slot is as high as its diameter
    assert thinnest_wall(round_ones.motor, round_ones) == pytest.approx(lid, abs=1e-6)


def test_a_side_wall_follows_the_outline_of_the_body():
    """An arched body: the wall to its upper edge, by points of that edge."""
    arch = [[-18, -3], [18, -3], [18, 0], [0, 6], [-18, 0]]
    data = {
        "name": "arch",
        "body": {"profile_mm": arch, "depth_mm": 22.0},
        "motor": {
            "axis": "across",
            "diameter_mm": 4.0,
            "height_mm": 4.0,
            "up_mm": 0.5,
            "along_mm": 4.0,
            "across_mm": 6.0,
            "opens": "side",
        },
    }
    design = Design.model_validate(data)
    middle = np.array(design.motor.cylinder.centre_in_design(22.0)[:2])
    corners = solids.side_view(design).body
    ends = np.roll(corners, -1, axis=0)
    share = np.linspace(0.0, 1.0, 2001)[:, None, None]
    edge = (corners + share * (ends - corners)).reshape(-1, 2)
    away = np.linalg.norm(edge - middle, axis=1).min() - 2.2
    assert thinnest_wall(design.motor, design) == pytest.approx(away, abs=0.01)


def test_the_wall_between_two_pockets_is_reported():
    """From the round slot of a motor to the corner of the battery's, in closed form."""
    design = load_walker("coinbot")
    gap = math.hypot(11.0 + 6.2 - 10.2, 3.7 - 2.2) - 5.2
    assert pockets.wall_between(design, 50.0) == pytest.approx(gap, abs=0.004)
    assert pockets.wall_between(design, 1.0) == 1.0
    near = design.variant(**{"motor.along_mm": 9.3, "pockets.channel_mm": 0.0})
    thin = math.hypot(9.3 + 6.2 - 10.2, 3.7 - 2.2) - 5.2
    (line,) = messages(near, printer_of("ender3"))
    assert "wall between the pockets of motor and battery" in line
    assert pockets.wall_between(near, 50.0) == pytest.approx(thin, abs=0.004)
    joined = design.variant(**{"motor.along_mm": 8.6, "pockets.channel_mm": 0.0})
    assert pockets.wall_between(joined, 50.0) == 0.0
    alone = design.variant(**{"battery": None, "pockets.channel_mm": 0.0})
    assert pockets.wall_between(alone, 50.0) == 50.0


def test_the_clearance_of_a_printer_is_respected():
    wide = printer_of("prusa-mk3s").model_copy(update={"pocket_clearance_mm": 0.35})
    (line,) = messages(load_walker("coinbot"), wide)
    assert "0.2 mm, limit 0.35 mm" in line
    assert "pockets.clearance_mm = 0.35" in line
    assert messages(load_walker("koumakis2016"), wide) == []


def test_designs_without_payload_are_written_without_its_keys():
    """Neither their data nor a printer's of the usual clearance name the new keys."""
    for name in templates.names("walkers"):
        data = load_walker(name).model_dump(mode="json")
        carries = name in CARRIERS
        assert [key in data for key in ("motor", "battery", "pockets")] == 3 * [carries]
    assert "pocket_clearance_mm" not in printer_of("ender3").model_dump()
    own = printer_of("ender3").model_copy(update={"pocket_clearance_mm": 0.3})
    assert own.model_dump()["pocket_clearance_mm"] == 0.3


def test_weighing_forms_have_rows_for_the_payload(tmp_path):
    design = load_walker("coinbot").variant(tilt_deg=10.0)
    part, path = names.part_name(design), tmp_path / weighed_masses.FILE_NAME
    weighed_masses.write_form(tmp_path, [part, *weighed_masses.carried_rows(design)])
    rows = [line.split(",")[0] for line in path.read_text().splitlines()[1:]]
    assert rows == [part, "motor", "battery", "wires", "glue"]
    assert not weighed_masses.is_filled_in(path)
    path.write_text("part,grams\nmotor,1.2\nmotor,1.4\nbattery,3.1\nglue,0.3\n")
    assert weighed_masses.is_filled_in(path)
    weighed = weighed_masses.apply_carried_masses(design, weighed_masses.read_masses(path, [design]))
    assert weighed_masses.unused_parts(path, [design]) == []
    gained = solids.mass_of(weighed).total - solids.mass_of(design).total
    assert gained == pytest.approx(0.3 + 0.2 + 0.2, rel=1e-9)


def test_wrong_weights_of_the_payload_are_refused(tmp_path):
    design, path = load_walker("coinbot"), tmp_path / weighed_masses.FILE_NAME
    path.write_text("part,grams,body_g\nmotor,,1.2\n")
    with pytest.raises(InputError, match="motor: body_g: it has neither"):
        weighed_masses.read_masses(path, [design])
    path.write_text("part,grams\nmotor,1200\n")
    with pytest.raises(InputError, match="motor: the weighed mass is 1200 g, that of the design 1 g"):
        weighed_masses.apply_carried_masses(design, weighed_masses.read_masses(path, [design]))
    path.write_text("part,grams\nmotor,1.2\n")
    with pytest.raises(InputError, match="'motor': is not among the parts that tilt and legs select"):
        weighed_masses.read_masses(path, [load_walker("koumakis2016")])


WIDE_BODY = {"length_mm": 40.0, "depth_mm": 24.0, "thickness_mm": 6.0}


@pytest.mark.parametrize(("name", "steps"), [("coinbot", 7), ("koumakis2016", 6)])
def test_the_print_sheet_states_when_to_weigh_and_to_insert_the_payload(tmp_path, name, steps):
    request = PlateRequest(design=name, printer="ender3", out=tmp_path, pictures=False)
    request.run(lambda *step: None)
    sheet = (tmp_path / "plates" / "plate_ender3.md").read_text(encoding="utf-8")
    assert f"\n{steps}. " in sheet
    assert f"\n{steps + 1}. " not in sheet
    assert ("motor and the battery" in sheet) == (steps == 7)


def test_marks_that_pockets_take_away_are_refused():
    line = refusal_of(**load_walker("coinbot").model_dump(exclude_unset=True), marks={"serial": 7})
    assert "marks.serial = 7" in line
    assert line.count("\n") == 0
    beside = load_walker("spinner").variant(**{"marks.kind": "text", "marks.text": "A7"})
    assert modeller.count_bodies(solids.build(beside).walker) == 1


def test_pockets_are_in_no_drawing_for_a_laser_cutter():
    for name in CARRIERS:
        with pytest.raises(InputError, match=r"no drawing .* pockets \(motor, battery\)"):
            profile.drawing_outlines(load_walker(name))


def test_a_drawn_body_can_have_pockets(tmp_path):
    """A mesh is cut as its box would be, and refused where it has no plastic."""
    box = trimesh.creation.box((40.0, 24.0, 6.0))  # z up in the file
    box.export(tmp_path / "box.stl")
    legs = [{"along_mm": along, "width_mm": 8.0} for along in (-14.0, 14.0)]
    tables = {"body": {"mesh": str(tmp_path / "box.stl")}, "legs": legs, "motor": {"axis": "up", "up_mm": 1.5}}
    own = solids.mass_of(design_of(**tables))
    plain = solids.mass_of(design_of(**(tables | {"body": WIDE_BODY})))
    assert own.M == pytest.approx(plain.M, rel=1e-6)  # STL holds 32-bit floats
    ring = trimesh.creation.annulus(6.0, 20.0, 6.0)
    ring.export(tmp_path / "ring.stl")
    line = refusal_of(**(tables | {"body": {"mesh": str(tmp_path / "ring.stl")}}))
    assert "motor.along_mm = 0" in line
    assert "outside the body or over a hole" in line


def test_a_finished_mesh_can_have_pockets(tmp_path):
    plain = design_of(body=WIDE_BODY, legs={"contact_spacing_mm": 30.0})
    mesh = to_trimesh(solids.build(plain).walker)
    mesh.export(tmp_path / "whole.stl")
    motor = {"axis": "up", "up_mm": 1.5}
    whole = {"mesh": str(tmp_path / "whole.stl"), "up": "y", "legs_below_mm": 7.0}
    design = design_of(walker=whole, motor=motor)
    gained = solids.mass_of(design).total - solids.mass_of(design_of(walker=whole)).total
    deep = 0.5 * design.size.thickness - 1.5 + 0.5 * 2.7 + 0.2
    pocket = math.pi * 5.2**2 * deep * 1.24e-3
    # A polygon of 128 edges is smaller than its circle by 0.04 %
    assert gained == pytest.approx(1.0 + 0.1 + 0.1 - pocket, abs=1e-3 * pocket)
