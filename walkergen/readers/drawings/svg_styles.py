"""Styles of an SVG drawing: its style sheets, as attributes of its elements.

Sheets are read as a browser on a screen reads them: rules of other media do not count, selectors of
any kind do (cssselect2), later and more specific rules prevail over others, and style="" over all.
"""

import re
import xml.etree.ElementTree as ET
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import cssselect2
import tinycss2

from walkergen.core.errors import InputError

INHERITED_PROPERTIES = (
    "clip-rule",
    "color",
    "fill",
    "fill-opacity",
    "fill-rule",
    "font-size",
    "paint-order",
    "stroke",
    "stroke-dasharray",
    "stroke-linecap",
    "stroke-linejoin",
    "stroke-miterlimit",
    "stroke-opacity",
    "stroke-width",
    "visibility",
)
"""Properties that an element inherits from the element around it."""

NON_INHERITED_PROPERTIES = (
    "clip-path",
    "display",
    "filter",
    "mask",
    "mask-type",
    "opacity",
    "overflow",
    "stop-color",
    "stop-opacity",
    "transform",
    "transform-box",
    "transform-origin",
)
GEOMETRY_PROPERTIES = ("cx", "cy", "d", "height", "r", "rx", "ry", "width", "x", "y")
SUPPORTED_PROPERTIES = frozenset((*INHERITED_PROPERTIES, *NON_INHERITED_PROPERTIES, *GEOMETRY_PROPERTIES))
"""Properties that affect what is drawn and where."""

UNSUPPORTED_PROPERTIES = ("rotate", "scale", "translate", "offset-path", "zoom")
"""Properties that would move an element and that are not read here."""

NEUTRAL_VALUES = ("none", "normal", "1", "100%")
"""Values of unsupported properties that move nothing."""

INITIAL_VALUES = {
    "fill": "black",
    "stroke": "none",
    "fill-rule": "nonzero",
    "clip-rule": "nonzero",
    "visibility": "visible",
}
INITIAL_VALUES |= {
    "color": "black",
    "font-size": "medium",
    "stroke-width": "1",
    "fill-opacity": "1",
    "stroke-opacity": "1",
    "stroke-dasharray": "none",
    "stroke-linecap": "butt",
    "stroke-linejoin": "miter",
    "stroke-miterlimit": "4",
    "paint-order": "normal",
}
"""Initial values of inherited properties."""

MAX_VARIABLE_DEPTH = 8
"""Levels of custom properties within others."""

SCREEN_MEDIA = re.compile(r"(only\s+)?(all|screen)?\s*", re.IGNORECASE)
"""Media whose rules count: those without a condition."""

IGNORED_MEDIA = re.compile(
    r"((only\s+)?(print|speech)\b|.*prefers-color-scheme\s*:\s*dark).*", re.IGNORECASE | re.DOTALL
)
"""Media whose rules do not count: paper, voices, screens in the dark."""

SKIP_OPTIONS: dict[str, bool] = {"skip_comments": True, "skip_whitespace": True}
IGNORED_AT_RULES = ("charset", "counter-style", "font-face", "keyframes", "namespace", "page", "property")
"""At-rules that neither hide nor move an element."""


def apply_styles(root: ET.Element, source: str) -> None:
    """Write the styles of sheets and style="" into attributes, in place. Raises InputError for unsupported styles."""
    matcher = cssselect2.Matcher()
    for element in root.iter():
        css = element.attrib.get("type", "").strip().lower() in ("", "text/css")
        if (
            str(element.tag).rpartition("}")[2] == "style"
            and css
            and _is_screen_media(element.attrib.get("media", ""), source)
        ):
            _add_rules(matcher, tinycss2.parse_stylesheet(element.text or "", **SKIP_OPTIONS), {}, source)
    custom: dict[ET.Element | None, dict[str, str]] = {None: {}}
    for node in cssselect2.ElementWrapper.from_xml_root(root).iter_subtree():
        element = node.etree_element
        matches = sorted(matcher.match(node), key=lambda match: match[:2])
        declarations = [pair for *_, pairs in matches for pair in pairs]
        declarations += _parse_declarations(
            tinycss2.parse_declaration_list(element.attrib.get("style", ""), **SKIP_OPTIONS), source
        )
        # important declarations come last, and so prevail
        values = {key: value for key, value, _ in sorted(declarations, key=lambda triple: triple[2])}
        custom_values = {key: values.pop(key) for key in [*values] if key.startswith("--")}
        custom[element] = {**custom[node.parent.etree_element if node.parent else None], **custom_values}
        element.attrib.update(values)
        for key in SUPPORTED_PROPERTIES & element.attrib.keys():
            _resolve_value(element.attrib, key, custom[element])


def _resolve_value(attributes: dict[str, str], key: str, custom: Mapping[str, str]) -> None:
    """Replace custom properties and "initial" in attribute `key` by their values, or delete it if "unset", in place."""
    text = attributes[key]
    if "var(" in text:
        attributes[key] = text = _substitute_variables(text, custom)
    word = text.strip().lower()
    if word == "initial" and key in INITIAL_VALUES:
        attributes[key] = INITIAL_VALUES[key]
    elif word in ("initial", "revert", "revert-layer", "unset"):
        del attributes[key]


def _substitute_variables(text: str, custom: Mapping[str, str], depth: int = 0) -> str:
    """Replace var(--name, other) by the values of custom properties, or "unset" without a value."""
    parts = []
    for token in tinycss2.parse_component_value_list(text):
        if token.type == "function" and token.lower_name == "var":
            name, _, other = tinycss2.serialize(token.arguments).partition(",")
            value = custom.get(name.strip(), other).strip()
            if not value or depth > MAX_VARIABLE_DEPTH:
                return "unset"
            parts.append(_substitute_variables(value, custom, depth + 1))
        else:
            parts.append(token.serialize())
    return "".join(parts).strip()


def _add_rules(matcher: Any, rules: Sequence[Any], spaces: dict[str | None, str], source: str) -> None:
    """Add a sheet's rules for screens to a matcher. `spaces` are namespaces by prefix: @namespace rules add to them."""
    for rule in rules:
        if rule.type == "at-rule":
            _add_at_rule(matcher, rule, spaces, source)
        if rule.type != "qualified-rule":
            continue
        inside = tinycss2.parse_blocks_contents(rule.content, **SKIP_OPTIONS)
        if any(part.type == "qualified-rule" for part in inside):
            raise _unsupported_error("rules within rules", source)
        pairs = list(_parse_declarations(inside, source))
        try:
            selectors = cssselect2.compile_selector_list(rule.prelude, spaces)
        except cssselect2.SelectorError:
            continue  # as browsers do: a rule that cannot be read does not count
        for selector in selectors:
            if selector.pseudo_element is None:
                matcher.add_selector(selector, pairs)


def _add_at_rule(matcher: Any, rule: Any, spaces: dict[str | None, str], source: str) -> None:
    """Add the rules in an @media rule, or the namespace of an @namespace rule. Raises InputError for other rules."""
    word = rule.lower_at_keyword
    if word == "import":
        raise InputError(f"{source}: its <style> imports another file. Save it as a plain SVG.")
    if word == "namespace":
        names = [token.value for token in rule.prelude if token.type in ("ident", "string", "url")]
        spaces[names[0] if len(names) > 1 else None] = names[-1] if names else ""
    elif rule.content is not None and word == "media":
        if _is_screen_media(tinycss2.serialize(rule.prelude), source):
            _add_rules(matcher, tinycss2.parse_rule_list(rule.content, **SKIP_OPTIONS), spaces, source)
    elif rule.content is not None and word not in IGNORED_AT_RULES:
        raise _unsupported_error(f"@{word[:20]}", source)


def _is_screen_media(media: str, source: str) -> bool:
    """Return whether rules for these media apply on a screen. Raises InputError if that depends on the viewer."""
    media_list = [medium.strip() for medium in media.split(",")]
    if any(SCREEN_MEDIA.fullmatch(medium) for medium in media_list):
        return True
    if all(IGNORED_MEDIA.fullmatch(medium) for medium in media_list):
        return False
    raise _unsupported_error(f"the condition {media.strip()[:40]!r}", source)


def _unsupported_error(what: str, source: str) -> InputError:
    return InputError(f"{source}: its <style> has {what}, which walkergen cannot read. Save it as a plain SVG.")


def _parse_declarations(declarations: Sequence[Any], source: str) -> Iterator[tuple[str, str, bool]]:
    """Yield the supported properties of a list: key, value, and whether it is important."""
    for item in declarations:
        if item.type != "declaration":
            continue
        value = tinycss2.serialize(item.value).strip()
        if item.lower_name in UNSUPPORTED_PROPERTIES and value.lower() not in NEUTRAL_VALUES:
            raise InputError(f"{source}: a style moves elements by {item.lower_name}. Write it as a transform.")
        if item.name.startswith("--"):
            yield item.name, value, item.important
        if item.lower_name in SUPPORTED_PROPERTIES:
            yield item.lower_name, value, item.important
        if item.lower_name == "font":  # its first length is the size; weights are plain numbers
            sizes = [token for token in item.value if token.type in ("dimension", "percentage")]
            yield from [("font-size", sizes[0].serialize(), item.important)] if sizes else []
