"""Styles of an SVG drawing: what its style sheets say, as attributes of its elements.

Sheets are read as a browser on a screen reads them: rules of other media do not count, selectors of
any kind do (cssselect2), later and more special rules come before others, and style="" before all.
"""

import re
import xml.etree.ElementTree as ET
from collections.abc import Iterator, Sequence
from typing import Any

import cssselect2
import tinycss2

from walkergen.errors import InputError

INHERITED = (
    "clip-rule",
    "color",
    "fill",
    "fill-opacity",
    "fill-rule",
    "font-size",
    "stroke",
    "stroke-opacity",
    "stroke-width",
    "visibility",
)
"""Properties that an element has of the one around it."""

OWN = ("clip-path", "display", "mask", "opacity", "overflow", "transform", "transform-box", "transform-origin")
GEOMETRY = ("cx", "cy", "d", "height", "r", "rx", "ry", "width", "x", "y")
READ = frozenset((*INHERITED, *OWN, *GEOMETRY))
"""Properties that decide on what is drawn and where; colours of text and the like do not."""

UNREAD = ("rotate", "scale", "translate", "offset-path", "zoom")
"""Properties that would move an element and that are not read here."""

SCREENS = re.compile(r"(only\s+)?(all|screen)?\s*", re.IGNORECASE)
"""Media whose rules count: those without a condition."""

ELSEWHERE = re.compile(r"((only\s+)?(print|speech)\b|.*prefers-color-scheme\s*:\s*dark).*", re.IGNORECASE | re.DOTALL)
"""Media whose rules do not count: paper, voices, screens in the dark."""

HARMLESS = ("charset", "counter-style", "font-face", "keyframes", "namespace", "page", "property")
"""At-rules that hide and move nothing by themselves."""


def as_attributes(root: ET.Element, source: str) -> None:
    """Write what sheets and style="" say onto the elements, in place. Raises InputError for what is not read."""
    matcher = cssselect2.Matcher()
    for element in root.iter():
        if _name(element) == "style" and _counts(element.attrib.get("media", ""), source):
            _add(matcher, tinycss2.parse_stylesheet(element.text or "", True, True), source)
    for node in cssselect2.ElementWrapper.from_xml_root(root).iter_subtree():
        element = node.etree_element
        matches = sorted(matcher.match(node), key=lambda match: match[:2])
        wanted = [pair for *_, pairs in matches for pair in pairs]
        wanted += _declared(tinycss2.parse_declaration_list(element.attrib.get("style", ""), True, True), source)
        # what is important comes last, and so holds
        element.attrib.update({key: value for key, value, _ in sorted(wanted, key=lambda each: each[2])})


def _add(matcher: Any, rules: Sequence[Any], source: str) -> None:
    """Take in the rules of a sheet that count on a screen."""
    for rule in rules:
        if rule.type == "at-rule" and rule.lower_at_keyword == "import":
            raise InputError(f"{source}: its <style> imports another file; save it as a plain SVG")
        if rule.type == "at-rule" and rule.content is not None and rule.lower_at_keyword not in HARMLESS:
            if rule.lower_at_keyword != "media":
                raise _unread(f"@{rule.lower_at_keyword[:20]}", source)
            if _counts(tinycss2.serialize(rule.prelude), source):
                _add(matcher, tinycss2.parse_rule_list(rule.content, True, True), source)
        if rule.type != "qualified-rule":
            continue
        inside = tinycss2.parse_blocks_contents(rule.content, True, True)
        if any(each.type == "qualified-rule" for each in inside):
            raise _unread("rules within rules", source)
        pairs = list(_declared(inside, source))
        try:
            selectors = cssselect2.compile_selector_list(rule.prelude)
        except cssselect2.SelectorError:
            continue  # as browsers do: a rule that cannot be read does not count
        for selector in selectors:
            if selector.pseudo_element is None:
                matcher.add_selector(selector, pairs)


def _counts(media: str, source: str) -> bool:
    """Whether rules for these media count. Raises InputError where it depends on who looks."""
    each = [medium.strip() for medium in media.split(",")]
    if any(SCREENS.fullmatch(medium) for medium in each):
        return True
    if all(ELSEWHERE.fullmatch(medium) for medium in each):
        return False
    raise _unread(f"the condition {media.strip()[:40]!r}", source)


def _unread(what: str, source: str) -> InputError:
    return InputError(f"{source}: its <style> has {what}, which walkergen does not read; save it as a plain SVG")


def _declared(declarations: Sequence[Any], source: str) -> Iterator[tuple[str, str, bool]]:
    """Properties of a list that are read here: key, value, and whether it is important."""
    for each in declarations:
        if each.type != "declaration":
            continue
        if each.lower_name in UNREAD:
            raise InputError(f"{source}: a style moves elements by {each.lower_name}; write it as a transform")
        if each.lower_name in READ:
            yield each.lower_name, tinycss2.serialize(each.value).strip(), each.important


def _name(element: ET.Element) -> str:
    return str(element.tag).rpartition("}")[2]
