"""Every mutant of dut/, from the sources alone."""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from fnmatch import fnmatch
from pathlib import Path

from triaxis.golden.errors import InputError
from triaxis.sim.build import mesh_files, rtl_files
from triaxis.sim.paths import DUT
from triaxis.verif.mutation.elaboration import elaboration_mutants
from triaxis.verif.mutation.mutant import RUNTIME, Mutant, macro_mutants
from triaxis.verif.mutation.statements import Host, hosts, input_ports, shared_enumerators
from triaxis.verif.mutation.syntax import SourceFile, read_source


@dataclass(frozen=True)
class Catalogue:
    """The sources of dut/ with the hosts of run-time mutants in each, and all mutants."""

    sources: tuple[SourceFile, ...]
    hosts: Mapping[str, tuple[Host, ...]]
    mutants: tuple[Mutant, ...]

    @property
    def by_id(self) -> dict[str, Mutant]:
        """Return the mutants by name."""
        return {mutant.id: mutant for mutant in self.mutants}

    def restricted(self, files: str | None, names: str | None) -> "Catalogue":
        """Return the catalogue of the mutants whose file and name match; InputError where there is none."""
        kept = [
            mutant
            for mutant in self.mutants
            if (files is None or any(fnmatch(name, files) for name in _file_names(mutant)))
            and (names is None or fnmatch(mutant.id, names))
        ]
        if not kept:
            asked = ", ".join(text for text in (files, names) if text)
            raise InputError(
                f"{asked}: no such mutant; names are <module>/<operator>/<hash>, files those of dut/"
            )
        return self.only({mutant.id for mutant in kept})

    def only(self, chosen: Collection[str]) -> "Catalogue":
        """Return the catalogue of the mutants of these names."""
        hosts_left = {
            file: tuple(
                host.with_mutants(tuple(mutant for mutant in host.mutants if mutant.id in chosen))
                for host in found
                if any(mutant.id in chosen for mutant in host.mutants)
            )
            for file, found in self.hosts.items()
        }
        return Catalogue(self.sources, hosts_left, tuple(one for one in self.mutants if one.id in chosen))


def _file_names(mutant: Mutant) -> tuple[str, ...]:
    """Return how a mutant's file may be called: by its name, with its folder, with dut/ as well."""
    return mutant.file.rpartition("/")[2], mutant.file, f"dut/{mutant.file}"


def catalogue(dut: Path = DUT) -> Catalogue:
    """Return all mutants of the RTL in a folder."""
    below = sorted(mesh_files(dut))
    # Those of the core come first, then the mesh engine: their numbers stay whatever is done above.
    paths = [*below, *sorted(set(rtl_files(dut)) - set(below))]
    sources = tuple(read_source(path, dut) for path in paths if path.suffix == ".sv")
    ports = input_ports(sources)
    shared = shared_enumerators(sources)
    every = {source.name: hosts(source, ports, shared) for source in sources}
    held = [mutant for source in sources for host in every[source.name] for mutant in host.mutants]
    runtime = [mutant for mutant in held if mutant.kind == RUNTIME]
    constant = [mutant for mutant in held if mutant.kind != RUNTIME]
    found = {
        name: tuple(host for host in of if host.mutants[0].kind == RUNTIME) for name, of in every.items()
    }
    elaboration = [mutant for source in sources for mutant in elaboration_mutants(source)]
    mutants = (*runtime, *constant, *elaboration, *macro_mutants(dut))
    _check_distinct(mutants)
    return Catalogue(sources, found, mutants)


def _check_distinct(mutants: Sequence[Mutant]) -> None:
    if len({mutant.short for mutant in mutants}) != len(mutants):
        raise InputError("mutants: two have one name: lengthen the hash in verif/mutation/mutant.py")


def mutant_names() -> list[str]:
    """Return the names of all mutants of dut/, in a fixed order: parses, and builds nothing."""
    return [mutant.id for mutant in catalogue().mutants]


def runtime_numbers(mutants: Sequence[Mutant]) -> dict[str, int]:
    """Return the numbers by which the run-time mutants are selected in their build, from 1 on."""
    runtime = [mutant for mutant in mutants if mutant.kind == RUNTIME]
    return {mutant.id: number for number, mutant in enumerate(runtime, 1)}
