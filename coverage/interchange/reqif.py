"""ReqIF 1.2 (OMG), for tools that manage requirements: what is promised, and the testpoints that verify it.

Requirements and testpoints are objects of two types, in the order of the testplan; a relation leads from a
testpoint to each requirement that it serves. A testpoint holds its stage, what it says, and what it names:
tests, proofs, faults, bins, mutants. The same plan gives the same bytes: the date is that which is given.

Our own writer: the format is small, and none of its libraries is needed for anything else.
"""

from collections.abc import Mapping
from datetime import datetime
from pathlib import Path
from xml.etree.ElementTree import Element, SubElement, indent, tostring

from triaxis.coverage.testplan import KINDS, PARTS, Testplan
from triaxis.golden.outputs import write_whole

_SPACE = "http://www.omg.org/spec/ReqIF/20110401/reqif.xsd"
# The attributes of each type; those of ReqIF.* are what tools show as a name and a text.
_REQUIREMENT = ("ReqIF.ForeignID", "ReqIF.Text")
_TESTPOINT = ("ReqIF.ForeignID", "ReqIF.Text", "stage", *KINDS)
_STRING = "string"


def write_reqif(path: Path, plan: Testplan, when: datetime) -> Path:
    """Write a testplan, whole or not at all."""
    date = when.isoformat(timespec="seconds")

    def add(parent: Element, tag: str, name: str, **more: str) -> Element:
        return SubElement(parent, tag, {"IDENTIFIER": name, "LAST-CHANGE": date, **more})

    def add_type(parent: Element, tag: str, name: str, attributes: tuple[str, ...] = ()) -> None:
        of = add(parent, tag, name, **{"LONG-NAME": name})
        holder = SubElement(of, "SPEC-ATTRIBUTES") if attributes else of
        for key in attributes:
            one = add(holder, "ATTRIBUTE-DEFINITION-STRING", f"{name}.{key}", **{"LONG-NAME": key})
            SubElement(SubElement(one, "TYPE"), "DATATYPE-DEFINITION-STRING-REF").text = _STRING

    def add_object(name: str, of: str, values: Mapping[str, str]) -> None:
        one = add(objects, "SPEC-OBJECT", name)
        holder = SubElement(one, "VALUES")
        for key, value in values.items():
            text = SubElement(holder, "ATTRIBUTE-VALUE-STRING", {"THE-VALUE": value})
            reference = SubElement(SubElement(text, "DEFINITION"), "ATTRIBUTE-DEFINITION-STRING-REF")
            reference.text = f"{of}.{key}"
        SubElement(SubElement(one, "TYPE"), "SPEC-OBJECT-TYPE-REF").text = of
        placed = add(children, "SPEC-HIERARCHY", f"place.{name}")
        SubElement(SubElement(placed, "OBJECT"), "SPEC-OBJECT-REF").text = name

    root = Element("REQ-IF", {"xmlns": _SPACE})
    header = SubElement(SubElement(root, "THE-HEADER"), "REQ-IF-HEADER", {"IDENTIFIER": plan.name})
    for tag, text in (
        ("CREATION-TIME", date), ("REQ-IF-TOOL-ID", "triaxis"), ("REQ-IF-VERSION", "1.0"),
        ("SOURCE-TOOL-ID", "triaxis"), ("TITLE", f"{plan.name}: requirements and testpoints"),
    ):  # fmt: skip
        SubElement(header, tag).text = text
    content = SubElement(SubElement(root, "CORE-CONTENT"), "REQ-IF-CONTENT")
    longest = {"LONG-NAME": _STRING, "MAX-LENGTH": "65535"}
    add(SubElement(content, "DATATYPES"), "DATATYPE-DEFINITION-STRING", _STRING, **longest)
    types = SubElement(content, "SPEC-TYPES")
    add_type(types, "SPEC-OBJECT-TYPE", "requirement", _REQUIREMENT)
    add_type(types, "SPEC-OBJECT-TYPE", "testpoint", _TESTPOINT)
    add_type(types, "SPEC-RELATION-TYPE", "serves")
    add_type(types, "SPECIFICATION-TYPE", "testplan")
    objects, relations = SubElement(content, "SPEC-OBJECTS"), SubElement(content, "SPEC-RELATIONS")
    specification = add(SubElement(content, "SPECIFICATIONS"), "SPECIFICATION", "plan")
    SubElement(SubElement(specification, "TYPE"), "SPECIFICATION-TYPE-REF").text = "testplan"
    children = SubElement(specification, "CHILDREN")
    for one in plan.requirements:
        add_object(one.id, "requirement", {"ReqIF.ForeignID": one.id, "ReqIF.Text": one.text})
    for point in plan.testpoints:
        text = "\n".join(f"{part.capitalize()}: {getattr(point, part)}" for part in PARTS)
        named = {kind: ", ".join(point.entries(kind)) for kind in KINDS if point.entries(kind)}
        values = {"ReqIF.ForeignID": point.name, "ReqIF.Text": text, "stage": point.stage, **named}
        add_object(point.name, "testpoint", values)
        for name in point.requirements:
            relation = add(relations, "SPEC-RELATION", f"{point.name}.{name}")
            SubElement(SubElement(relation, "TARGET"), "SPEC-OBJECT-REF").text = name
            SubElement(SubElement(relation, "SOURCE"), "SPEC-OBJECT-REF").text = point.name
            SubElement(SubElement(relation, "TYPE"), "SPEC-RELATION-TYPE-REF").text = "serves"
    indent(root)
    return write_whole(path, tostring(root, encoding="utf-8", xml_declaration=True) + b"\n")
