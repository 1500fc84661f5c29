"""A block of the RTL as a component for tools that put designs together: IP-XACT (IEEE 1685-2014), Vivado.

A component is of one configuration: its ports have the widths that these parameters give, as elaboration
finds them. Streams are AXI4-Stream, by the names of their ports. Folder of a component:

    component.xml        ports, streams, parameters, files
    rtl/                 the files, in the order in which component.xml lists them
    options.txt          what `fpga/vivado/package_ip.tcl` reads
"""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path
from typing import Any
from xml.etree.ElementTree import Element, SubElement, indent, register_namespace, tostring

from triaxis.fpga.board_build import PART, VIVADO
from triaxis.golden.errors import InputError
from triaxis.golden.outputs import make_folder, write_whole
from triaxis.sim.paths import DUT, core_sources, mesh_sources
from triaxis.sim.slang import compiled

VENDOR, LIBRARY = "triaxis", "geometry"
PACKAGE_SCRIPT = VIVADO / "package_ip.tcl"
# What may be a component, and what it is.
TOPS = {
    "triaxis_core": "near(A, B, m) for one pair of triangles a clock",
    "triaxis_certified_core": "the same, each clear shown again in other hardware",
    "triaxis_mesh": "near(A, B, m) for whole meshes, with what boxes decide skipped",
}
_NAMESPACE = "http://www.accellera.org/XMLSchema/IPXACT/1685-2014"
_LOCATION = f"{_NAMESPACE} {_NAMESPACE}/index.xsd"
_STREAM = re.compile(r"([sm]_axis\w*?)_(tvalid|tready|tdata|tuser)_[io]")
_AXIS = {"vendor": "amba.com", "library": "AMBA4", "version": "r0p0_1"}


@dataclass(frozen=True)
class Port:
    """A port: its name, whether it is an input, the numbers of its highest and lowest bit."""

    name: str
    is_input: bool
    left: int
    right: int

    @property
    def stream(self) -> tuple[str, str] | None:
        """Return the stream that it is of, and what it is there: ("s_axis", "TDATA"); None where of none."""
        found = _STREAM.fullmatch(self.name)
        return (found[1], found[2].upper()) if found else None


@dataclass(frozen=True)
class Component:
    """A module of the RTL with all its parameters, its ports, and the files of it in their order."""

    top: str
    parameters: Mapping[str, int]
    ports: Sequence[Port]
    sources: Sequence[Path]
    include: Path

    @property
    def streams(self) -> dict[str, dict[str, str]]:
        """Return the ports of each stream: {"s_axis": {"TVALID": "s_axis_tvalid_i", ..}, ..}.

        TDATA is whole bytes in AXI4-Stream; where it is not, as in the mesh engine, the ports stand alone.
        """
        return {
            name: {role: port.name for role, port in ports.items()}
            for name, ports in self._handshakes().items()
            if name not in self.ragged
        }

    @property
    def ragged(self) -> dict[str, int]:
        """Return the bits of TDATA where these are no whole bytes, by the names of what would be streams."""
        bits = {name: p["TDATA"].left + 1 for name, p in self._handshakes().items() if "TDATA" in p}
        return {name: count for name, count in bits.items() if count % 8}

    def _handshakes(self) -> dict[str, dict[str, Port]]:
        found: dict[str, dict[str, Port]] = {}
        for port in self.ports:
            if port.stream:
                found.setdefault(port.stream[0], {})[port.stream[1]] = port
        return found


def component(top: str, parameters: Mapping[str, int], dut: Path = DUT) -> Component:
    """Elaborate a module; raise InputError where it is none of `TOPS`, or does not take these parameters."""
    if top not in TOPS:
        raise InputError(f"{top}: must be one of {', '.join(TOPS)}")
    sources = core_sources(dut)
    sources += mesh_sources(dut) if top == "triaxis_mesh" else []
    compilation = compiled(sources, dut / "core", top, parameters)
    (instance,) = compilation.getRoot().topInstances
    body = instance.body
    known = {one.name: _value(one) for one in body.parameters if not one.isLocalParam}
    if unknown := sorted(parameters.keys() - known.keys()):
        raise InputError(f"{top}: parameter {unknown[0]}: must be one of {', '.join(known)}")
    for name, number in parameters.items():
        if known[name] != number:
            raise InputError(
                f"{top}: parameter {name}={number}: it has too few bits, and would be {known[name]}"
            )
    if errors := [one for one in compilation.getAllDiagnostics() if one.isError()]:
        from pyslang import DiagnosticEngine

        lines = DiagnosticEngine.reportAll(compilation.sourceManager, errors).splitlines()
        said = [line for line in lines if "$fatal" in line] or [line for line in lines if "error:" in line]
        raise InputError(f"{top}: these parameters do not fit: {said[0]}")
    ranges = [(one, one.type.fixedRange) for one in body.portList]
    ports = [Port(one.name, one.direction.name == "In", bits.left, bits.right) for one, bits in ranges]
    return Component(top, known, ports, sources, dut / "core")


def _value(parameter: Any) -> int:
    return int(parameter.value.value)


def write_component(one: Component, folder: Path) -> Path:
    """Write the folder of a component; return its component.xml."""
    # Vivado may be called from anywhere.
    folder = folder.absolute()
    rtl = make_folder(folder / "rtl")
    headers = sorted(one.include.glob("*.svh"))
    for source in (*headers, *one.sources):
        write_whole(rtl / source.name, source.read_bytes())
    options = [
        *(f"{key}={value}" for key, value in (("part", PART), ("top", one.top), ("out", folder / "vivado"))),
        f"vendor={VENDOR}", f"library={LIBRARY}", f"version={version('triaxis')}",
        f"description={TOPS[one.top]}", f"include={rtl}",
        *(f"source={rtl / source.name}" for source in one.sources),
        *(f"generic={name}={value}" for name, value in one.parameters.items()),
        *(
            f"stream={name} {role}={port}"
            for name, ports in one.streams.items()
            for role, port in ports.items()
        ),
    ]  # fmt: skip
    write_whole(folder / "options.txt", "\n".join(options) + "\n")
    names = [header.name for header in headers], [source.name for source in one.sources]
    return write_whole(folder / "component.xml", as_xml(one, *names))


def as_xml(one: Component, headers: Sequence[str], sources: Sequence[str]) -> bytes:
    """Return the component as IP-XACT, with files of these names in rtl/."""
    register_namespace("ipxact", _NAMESPACE)
    register_namespace("xsi", "http://www.w3.org/2001/XMLSchema-instance")
    root = Element(_tag("component"))
    root.set("{http://www.w3.org/2001/XMLSchema-instance}schemaLocation", _LOCATION)
    _texts(root, vendor=VENDOR, library=LIBRARY, name=one.top, version=version("triaxis"))
    interfaces = _child(root, "busInterfaces")
    for name, ports in one.streams.items():
        _stream(interfaces, name, ports)
    model = _child(root, "model")
    view = _child(_child(model, "views"), "view")
    _texts(view, name="rtl", envIdentifier="SystemVerilog::", componentInstantiationRef="rtl")
    made = _child(_child(model, "instantiations"), "componentInstantiation")
    _texts(made, name="rtl", language="SystemVerilog", moduleName=one.top)
    parameters = _child(made, "moduleParameters")
    for name, value in one.parameters.items():
        _texts(_child(parameters, "moduleParameter", parameterId=f"parameter_{name}"), name=name, value=value)
    _texts(_child(made, "fileSetRef"), localName="rtl")
    ports = _child(model, "ports")
    for port in one.ports:
        wire = _child(_texts(_child(ports, "port"), name=port.name), "wire")
        _texts(wire, direction="in" if port.is_input else "out")
        if port.left != port.right:
            _texts(_child(_child(wire, "vectors"), "vector"), left=port.left, right=port.right)
    files = _texts(_child(_child(root, "fileSets"), "fileSet"), name="rtl")
    for name in (*headers, *sources):
        file = _texts(_child(files, "file"), name=f"rtl/{name}", fileType="systemVerilogSource")
        if name in headers:
            _texts(file, isIncludeFile="true")
    _texts(root, description=TOPS[one.top])
    indent(root)
    return tostring(root, encoding="utf-8", xml_declaration=True) + b"\n"


def _stream(interfaces: Element, name: str, ports: Mapping[str, str]) -> None:
    """Add a stream."""
    interface = _texts(_child(interfaces, "busInterface"), name=name)
    _child(interface, "busType", **_AXIS, name="AXI4Stream")
    abstraction = _child(_child(interface, "abstractionTypes"), "abstractionType")
    _child(abstraction, "abstractionRef", **_AXIS, name="AXI4Stream_rtl")
    mapped = _child(abstraction, "portMaps")
    for role, port in ports.items():
        pair = _child(mapped, "portMap")
        _texts(_child(pair, "logicalPort"), name=role)
        _texts(_child(pair, "physicalPort"), name=port)
    _child(interface, "slave" if name.startswith("s_") else "master")


def _tag(name: str) -> str:
    return f"{{{_NAMESPACE}}}{name}"


def _child(parent: Element, name: str, /, **attributes: str) -> Element:
    return SubElement(parent, _tag(name), attributes)


def _texts(parent: Element, /, **texts: object) -> Element:
    """Add an element for each text; return their parent."""
    for name, text in texts.items():
        _child(parent, name).text = str(text)
    return parent
