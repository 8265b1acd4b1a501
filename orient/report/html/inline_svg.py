"""A picture of matplotlib as an element inside a page: no style attribute, no script, no address, its own identifiers.

The page forbids inline styles (Content-Security-Policy), so each declaration becomes the attribute of the same name.
"""

import re
from html import unescape
from xml.etree import ElementTree

SVG = "http://www.w3.org/2000/svg"
XLINK = "http://www.w3.org/1999/xlink"
DROPPED = {f"{{{SVG}}}{tag}" for tag in ("metadata", "style", "script", "foreignObject", "image", "a")}
COMMENT = re.compile(r"<!--(.*?)-->", re.DOTALL)
HEAD = re.compile(r"^.*?(?=<svg)", re.DOTALL)
REFERENCE = re.compile(r"url\(#([^)]+)\)")
INHERITED = {"stroke-linejoin": "round", "stroke-linecap": "butt"}
"""What matplotlib writes into the style element that is dropped."""


def inline(svg: str, prefix: str, title: str) -> str:
    """The <svg> element with identifiers that begin with `prefix`; `title` and its words are for the blind."""
    root = ElementTree.fromstring(HEAD.sub("", COMMENT.sub("", svg)))
    safe = "".join(letter if letter.isalnum() and letter.isascii() else f"x{ord(letter):x}" for letter in prefix)
    _clean(root, safe)
    for name in ("width", "height", "version"):
        root.attrib.pop(name, None)
    root.attrib.update({**INHERITED, "role": "img", "aria-label": title, "class": "plot"})
    words = ElementTree.Element(f"{{{SVG}}}desc")
    words.text = _words(svg)
    root.insert(0, words)
    ElementTree.register_namespace("", SVG)
    return ElementTree.tostring(root, encoding="unicode")


def _words(svg: str) -> str:
    """What is written in the picture, but for the numbers at the axes: matplotlib draws letters as curves and keeps
    each text in a comment before them."""
    texts = (" ".join(unescape(text).split()) for text in COMMENT.findall(svg))
    return "; ".join(dict.fromkeys(text for text in texts if any(letter.isalpha() for letter in text)))


def _clean(element: ElementTree.Element, prefix: str) -> None:
    for child in list(element):
        if child.tag in DROPPED:
            element.remove(child)
        else:
            _clean(child, prefix)
    style = element.attrib.pop("style", "")
    for declaration in filter(None, (part.strip() for part in style.split(";"))):
        name, _, value = declaration.partition(":")
        element.set(name.strip(), value.strip())
    if f"{{{XLINK}}}href" in element.attrib:
        element.set("href", element.attrib.pop(f"{{{XLINK}}}href"))
    for name, value in list(element.attrib.items()):
        if name == "id":
            element.set(name, f"{prefix}-{value}")
        elif name == "href":
            element.set(name, f"#{prefix}-{value.removeprefix('#')}")
        elif "url(#" in value:
            element.set(name, REFERENCE.sub(rf"url(#{prefix}-\1)", value))
