"""Answers about a page's walker: the part, its printing and its predicted motion.

Every number comes from the job that the command line calls for it.
"""

import json
import re
from collections.abc import Iterator, Sequence
from itertools import zip_longest
from typing import Any

import numpy as np
import numpy.typing as npt

from walkergen.app import document as documents
from walkergen.app import form, sentences
from walkergen.app.document import Document
from walkergen.commands.check import make as checking
from walkergen.commands.predict import make as predicting
from walkergen.core.errors import InputError, WalkergenError
from walkergen.core.files import safe_text
from walkergen.core.printing import findings
from walkergen.core.printing.findings import About, Finding
from walkergen.core.scene import Scene
from walkergen.core.shapes.mesh import Mesh
from walkergen.core.walker import names, solids
from walkergen.core.walker.design import Design
from walkergen.core.walker.mass import MassProperties, to_centre_frame
from walkergen.files import web_page
from walkergen.readers.walkers.leg_placement import UnplacedError

UPLOAD_PATH = re.compile(
    r"""(?<!\S)(['"]?)(?:[A-Za-z]:)?[\\/][^:\n]*?\.(?:svg|dxf|stl|3mf|obj|ply|off|glb|png|jpe?g)\b\1""", re.IGNORECASE
)
"""Path of a file that was dropped onto a page. Users do not know this path."""

LEG_GAP_MM = 1e-4
"""A triangle belongs to a leg if its middle is more than this below the underside of the body."""


def walker_facts(document: Document) -> tuple[dict[str, Any], Mesh]:
    """Return the facts on the walker and its predicted speed as JSON values, and its mesh in standing position.

    Raises WalkergenError for a walker that cannot be built or predicted.
    """
    design, scene = document.load_design(), document.load_scene()
    report = predicting.predict(design, [design], scene, "coulomb", model="known", united=False)
    (member,) = report.members
    row = member.row.columns()
    facts = {
        "name": design.name,
        "part": member.name,
        "tilt_deg": design.tilt_deg,
        "tilt_key": documents.tilt_key(design),
        "lengths": form.real_lengths(design),
        "legs": len(design.limbs),
        "kind": design.kind,
        "size_mm": list(design.size),
        "row": row,
        "speed": str(member.row.speed),
        "sentence": sentences.format_speed(member.row)._asdict(),
        "note": sentences.to_plain_text(member.row.note),
        "motor": design.motor is not None,
        "shaken": scene.drive.kind == "plate",
        "mass_g": float(member.mass.total),
        "caption": sentences.to_plain_text(report.headline),
        "dimensions": list(_dimensions(design)),
        "centre": _centre_of_mass(design, member.mass),
        "loads": list(_foot_loads(design, member.mass)),
        "prints": "on its side" if solids.is_printed_on_side(design) else "legs up",
    }
    return facts, member.mesh


def pack_walker(document: Document) -> bytes:
    """Return bytes for the page: `walker_facts` as a line of JSON, then `triangle_corners`, then `leg_mask`.

    Raises WalkergenError, as `walker_facts` does.
    """
    facts, mesh = walker_facts(document)
    corners, legs = triangle_corners(mesh), leg_mask(document, mesh)
    head = json.dumps(facts | {"triangles": len(corners)}, allow_nan=False).encode()
    head += b" " * (-(len(head) + 1) % 4) + b"\n"  # numbers begin at a multiple of 4 bytes
    return head + corners.tobytes() + legs.tobytes()


def printing_outlook(document: Document) -> dict[str, Any]:
    """Return the printer's findings on the walker, and its export as a shell command and Python code.

    Raises WalkergenError, as `walker_facts` does.
    """
    found = checking.check([document.load_design()], [1], document.load_printer()).findings
    return {
        "findings": [_format_finding(finding) for finding in findings.group_findings(found)],
        "legs_at_fault": any(finding.level != "advice" and finding.part is About.LEGS for finding in found),
        "shell": documents.shell_command(documents.arguments(document, "export")),
        "python": documents.python_code(document),
    }


def variance_shares(document: Document) -> list[dict[str, Any]]:
    """Return each uncertain input's share of the variance of the speed, largest first.

    Returns
    -------
    list of dict
        `name`: name of the input. `part`: share of the variance that vanishes if the input is known exactly. `key`:
        key for a measured value of the input, "" without one. The last entry is the share of several inputs together.
        The list is empty if the speed needs a simulation.

    Raises
    ------
    WalkergenError
        If the walker cannot be built or predicted.
    """
    design, scene = document.load_design(), document.load_scene()
    report = predicting.predict(design, [design], scene, "coulomb", uncertain=True, model="known")
    alone = [
        {
            "key": _page_key(share["name"], design),
            "name": sentences.format_name(share["name"]),
            "part": max(share["first"], 0.0),
        }
        for share in report.facts["rows"][0]["shares"]
    ]
    if not alone:
        return []
    rest = 1.0 - sum(part["part"] for part in alone)
    together = [{"key": "", "name": "several of them together", "part": rest}] if rest > 0.0 else []
    return sorted(alone, key=lambda part: -part["part"]) + together


def _page_key(name: str, design: Design) -> str:
    """Return the key of an uncertain input in the page's form; "" without one. `name`: its name in predictions."""
    table, _, key = name.partition(".")
    if table == "legs":
        return f"legs.{design.kind}_{key}" if design.has_legs_table else ""
    return f"scene.{name}" if table in Scene.model_fields else name if key else ""


def format_refusal(error: WalkergenError) -> list[dict[str, Any]]:
    """Return the mistakes that an error reports, as JSON values.

    Returns
    -------
    list of dict
        `key`: key of the mistake, "" without one. `text`: message for users of the page. `helps`: remedies, of the last
        mistake only. `drawn`: True for the last mistake if `trouble_picture` shows it.
    """
    mistaken = error if isinstance(error, InputError) else InputError(error.text)
    keys, remedies = mistaken.keys, mistaken.remedies
    texts = [line.removeprefix(f"{documents.SOURCE}: ") for line in mistaken.fault.splitlines()]
    mistakes: list[dict[str, Any]] = [
        {
            "key": key,
            "text": safe_text.shorten_line(sentences.to_plain_text(UPLOAD_PATH.sub("the file", text))),
            "helps": [],
            "drawn": False,
        }
        for text, key in zip_longest(texts, keys[: len(texts)], fillvalue="")
    ]
    for mistake in mistakes[-1:]:
        mistake["helps"] = [{"words": remedy.words, "values": dict(remedy.values)} for remedy in remedies]
        mistake["drawn"] = isinstance(error, UnplacedError)
    return mistakes


def trouble_picture(document: Document) -> dict[str, str]:
    """Return {"picture": data URL} of the body, red where legs lack room; "" instead of a URL if they have room."""
    from walkergen.commands.family import unsupported_body as drawing
    from walkergen.files import figures

    try:
        document.load_design()
    except UnplacedError as error:
        return {"picture": web_page.data_url("image/png", figures.png(drawing.draw_unsupported_body(error), 100))}
    except WalkergenError:
        pass  # the page shows the error already
    return {"picture": ""}


def triangle_corners(mesh: Mesh) -> npt.NDArray[np.float32]:
    """Return the corners of all triangles, shape (k, 9), little-endian float32, mm."""
    return mesh.vertices[mesh.triangles].reshape(-1, 9).astype("<f4")


def leg_mask(document: Document, mesh: Mesh) -> npt.NDArray[np.uint8]:
    """Return 1 for each triangle of a leg and 0 for each of the body, shape (k,)."""
    bottom = min(limb.bottom for limb in document.load_design().limbs)
    middles = mesh.vertices[mesh.triangles][:, :, 1].mean(axis=1)
    return np.asarray(middles < bottom - LEG_GAP_MM, dtype=np.uint8)


def _format_finding(finding: Finding) -> dict[str, Any]:
    """Return a finding of the printing checks as JSON values. `does`: the setting that corrects it, or None."""
    setting = finding.setting
    text = sentences.to_plain_text(finding.text if setting is None else finding.seen_text)
    does = None if setting is None else setting._asdict() | {"words": sentences.format_setting(*setting)}
    return {"level": finding.level, "part": finding.part, "text": text, "does": does}


def _dimensions(design: Design) -> Iterator[dict[str, Any]]:
    """Yield the dimension lines of the part: both ends in the frame of its mesh, mm, and the length as text."""
    length, thickness, depth = design.size
    x, y = 0.5 * length, 0.5 * thickness

    def dimension(start: Sequence[float], end: Sequence[float]) -> dict[str, Any]:
        """Return the dimension line between two points (x, y, z), mm."""
        text = f"{np.linalg.norm(np.subtract(end, start)):.4g} mm"
        return {"from": list(start), "to": list(end), "text": text}

    yield dimension((-x, y, depth), (x, y, depth))
    yield dimension((x, -y, depth), (x, y, depth))
    yield dimension((x, y, 0.0), (x, y, depth))
    limbs = sorted(design.limbs, key=lambda limb: limb.along)
    for limb in limbs[-1:]:
        front = 0.5 * (depth + limb.width) + limb.across
        foot = np.add(limb.anchor, limb.anchor_to_foot)
        yield dimension((*limb.anchor, front), (*foot.tolist(), front))
    if len(limbs) > 1 and limbs[0].along < limbs[-1].along:
        low = min(limb.foot_height for limb in limbs)
        yield dimension((limbs[0].along, low, depth), (limbs[-1].along, low, depth))


def _centre_of_mass(design: Design, mass: MassProperties) -> list[float]:
    """Return the centre of mass of the whole walker in the frame of its mesh, mm."""
    along, up = mass.centre - to_centre_frame(design.limbs, mass, np.zeros(2))
    z = mass.spatial.z if mass.spatial is not None else 0.0
    across = (mass.M * z + sum(leg.m * leg.across for leg in mass.legs)) / mass.total
    return [float(along), float(up), float(0.5 * design.size.depth + across)]


def _foot_loads(design: Design, mass: MassProperties) -> Iterator[dict[str, float]]:
    """Yield position and weight (percent) of back and of front feet; nothing unless feet have just these positions."""
    places = sorted({round(limb.along, 6) for limb in design.limbs})
    if len(places) != 2:
        return
    back, front = places
    x = _centre_of_mass(design, mass)[0]
    share = (x - back) / (front - back)
    yield {"along_mm": back, "percent": 100.0 * (1.0 - share)}
    yield {"along_mm": front, "percent": 100.0 * share}


def part_name(document: Document) -> str:
    """Return the name of the page's walker that begins the names of its files."""
    return names.part_name(document.load_design())
