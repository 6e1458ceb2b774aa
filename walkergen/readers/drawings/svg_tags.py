"""Tags of an SVG drawing: names without a namespace, and elements that would change the drawing."""

import re
import xml.etree.ElementTree as ET

from walkergen.core.errors import InputError

SVG_NAMESPACE = "{http://www.w3.org/2000/svg}"

SHAPE_TAGS = ("circle", "ellipse", "line", "path", "polygon", "polyline", "rect")

ACTIVE_TAGS = {
    "script": "a script",
    "animate": "an animation",
    "animateTransform": "an animation",
    "animateMotion": "an animation",
    "set": "an animation",
}
"""Elements that would change the drawing."""


def element_name(element: ET.Element) -> str:
    """Return the name of an SVG element without its namespace, or "" for other elements."""
    tag = str(element.tag)
    return tag.removeprefix(SVG_NAMESPACE) if tag.startswith(SVG_NAMESPACE) or "}" not in tag else ""


def is_switch_choice(element: ET.Element) -> bool:
    """Return whether a <switch> may show an element: it requires no program, and no language but English."""
    languages = element.attrib.get("systemLanguage", "en").lower().split(",")
    return "requiredExtensions" not in element.attrib and any(re.match("en(-|$)", name.strip()) for name in languages)


def check_static(root: ET.Element, source: str) -> None:
    """Raise InputError for elements that would change the drawing: scripts and animations."""
    for element in root.iter():
        if (name := str(element.tag).rpartition("}")[2]) in ACTIVE_TAGS:
            raise InputError(f"{source}: it contains {ACTIVE_TAGS[name]} (<{name}>). Remove it, and save a plain SVG.")
        if handler := next((key for key in element.attrib if key.lower().startswith("on")), None):
            raise InputError(f"{source}: it contains a script ({handler}). Save it as a plain SVG.")
