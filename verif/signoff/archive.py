"""The archive that is handed over: sign-off, sources, witnesses, hashes, and what verifies them anywhere.

The same sign-off, commit and witnesses give the same bytes. Two files are of public formats: an in-toto
statement (test result v0.1), which whoever hands it over signs with their own key, and a CycloneDX 1.6 bill
of all packages that the lock files hold.
"""

import argparse
import gzip
import hashlib
import io
import json
import re
import subprocess
import sys
import tarfile
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from triaxis.golden.errors import InputError
from triaxis.golden.input_file import read_input
from triaxis.golden.outputs import write_whole
from triaxis.host.cli import DONE
from triaxis.sim.build import rtl_files, rtl_hash
from triaxis.sim.paths import ROOT
from triaxis.sim.validity import git
from triaxis.verif.signoff.gate import SOURCES, refusals
from triaxis.verif.signoff.plan import RESULT

_NAME = "triaxis-evidence"
_README = """Triaxis: evidence of a sign-off.

python3 -I verify.py     checks all of it again, in a minute, with Python 3.11 or newer and nothing else

signoff/           what was found: signoff.json (source/docs/reports.schema.json tells its fields), and
                   index.html to read
source/            the checkout that was signed off: RTL, environment, documents
witnesses/         pairs of triangles, and what proves the distance of each: see source/docs/benchmarks.md
attestation.json   an in-toto statement about both; sign it with your own key
sbom.cdx.json      all packages that the lock files name, with hashes (CycloneDX)
SHA256SUMS         the hash of every other file

Verify it before anything else: what is run in here leaves files. It ends with the hash of SHA256SUMS, which
attestation.json is about: compare it with one that was signed, since who can change everything can change all
of it alike, verify.py too, of which the project has its own. That the sign-off was run as it says nobody can
prove by a file: `make signoff` in a copy of source/ runs it again.
"""
# A package of a lock file: its name, its version, and the lines of its hashes.
_LOCKED = re.compile(r"^([A-Za-z0-9._-]+)==([^\s;]+)[^\n]*((?:\n    --hash=sha256:[^\n]+)*)", re.MULTILINE)

Files = dict[str, bytes]


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add what `triaxis evidence` takes."""
    parser.description = (
        "Pack the sign-off in build/signoff with its sources, witnesses and hashes, and a script that "
        "verifies all of it without this project. The sign-off must open the gate, and the checkout be "
        "committed."
    )
    parser.add_argument("witnesses", type=Path, metavar="SET", help="a TriTest set, of `tritest make`")
    out = "the archive, a compressed tar file"
    parser.add_argument("--out", type=Path, required=True, metavar="FILE", help=out)
    parser.set_defaults(run=run)


def run(options: argparse.Namespace) -> int:
    """Pack the evidence."""
    path = pack(options.out, options.witnesses)
    print(f"{path}: {path.stat().st_size / 1e6:.1f} MB: python3 -I verify.py in it checks everything again")
    return DONE


def pack(out: Path, witnesses: Path, result: Path = RESULT) -> Path:
    """Write the archive of a sign-off to ``out``, whole or not at all.

    ``witnesses``: a TriTest set. Raises InputError where the sign-off does not open the gate for this
    checkout, or where that has changes that no commit holds.
    """
    if refused := refusals(result, rtl_hash(), SOURCES.hash()):
        raise InputError(f"no evidence of this checkout: {refused[0]}")
    if git("status", "--porcelain") != "":
        raise InputError(
            f"{ROOT}: uncommitted changes, or no checkout: commit them before evidence is packed"
        )
    if not (witnesses / "set.json").is_file():
        raise InputError(f"{witnesses}: no TriTest set: make one by `tritest make {witnesses}`")
    source = _source()
    # There are files that git was told not to look at.
    for path in (*rtl_files(), *SOURCES.files()):
        name = path.relative_to(ROOT).as_posix()
        if source.get(name) != path.read_bytes():
            raise InputError(
                f"{path}: is not what the commit holds, though git tells of no change: commit it"
            )
    files: Files = {
        "README.txt": _README.encode(),
        "verify.py": Path(__file__).with_name("verify.py").read_bytes(),
        **{f"signoff/{path.name}": read_input(path) for path in (result, result.with_name("index.html"))},
        **{f"source/{name}": content for name, content in source.items()},
        **{f"witnesses/{name}": read_input(witnesses / name) for name in _files_of(witnesses)},
    }
    files["sbom.cdx.json"] = _json(_bill(source))
    sums = "".join(f"{_sha256(content)}  {name}\n" for name, content in sorted(files.items())).encode()
    statement = _json(_attestation(json.loads(files["signoff/signoff.json"]), sums))
    return write_whole(out, _packed(files | {"SHA256SUMS": sums, "attestation.json": statement}))


def _files_of(witnesses: Path) -> list[str]:
    """Return the files of a set; raise InputError where it is not proven."""
    checker = ROOT / "bench" / "tritest" / "recheck.py"
    words = [sys.executable, "-I", "-S", str(checker), str(witnesses)]
    ran = subprocess.run(words, capture_output=True, text=True, check=False)
    if ran.returncode:
        said = (ran.stderr or ran.stdout).splitlines() or [f"exit code {ran.returncode}"]
        raise InputError(f"{witnesses}: {said[0]}: make it anew")
    families = json.loads(read_input(witnesses / "set.json"))["families"]
    return ["set.json", *(f"{family['name']}.txt.gz" for family in families)]


def _source() -> Files:
    """Return the files of the commit."""
    with TemporaryDirectory() as folder:
        packed = Path(folder) / "source.tar"
        if git("archive", "--output", str(packed), "HEAD") is None:
            raise InputError(f"{ROOT}: git cannot pack the commit: see what `git archive HEAD` says")
        with tarfile.open(packed) as archive:
            # Of a link what it is of.
            members = [member for member in archive if not member.isdir()]
            return {member.name: _content(archive, member) for member in members}


def _content(archive: tarfile.TarFile, member: tarfile.TarInfo) -> bytes:
    file = archive.extractfile(member)
    assert file is not None
    return file.read()


def _attestation(signoff: dict[str, Any], sums: bytes) -> dict[str, Any]:
    """Return a statement about the RTL and all files of the archive but itself, by their sums."""
    parts = signoff["parts"] | signoff["beside"]
    return {
        "_type": "https://in-toto.io/Statement/v1",
        "subject": [
            {"name": "rtl", "digest": {"sha256": signoff["rtl_hash"]}},
            {"name": "SHA256SUMS", "digest": {"sha256": _sha256(sums)}},
        ],
        "predicateType": "https://in-toto.io/attestation/test-result/v0.1",
        "predicate": {
            "result": "PASSED" if signoff["passed"] else "FAILED",
            "configuration": [
                {"name": signoff["command"], "digest": {"gitCommit": signoff["git_commit"]}},
                {"name": "source", "digest": {"gitCommit": git("rev-parse", "HEAD")}},
            ],
            "passedTests": sorted(name for name, part in parts.items() if part.get("passed") is True),
        },
    }


def _bill(source: Files) -> dict[str, Any]:
    """Return the packages of all lock files, with the hashes of what may be installed of each."""
    found: dict[tuple[str, str], set[str]] = {}
    for name, content in source.items():
        if re.fullmatch(r"requirements.*\.lock", name):
            for package, version, hashes in _LOCKED.findall(content.decode()):
                found.setdefault((package, version), set()).update(re.findall(r"sha256:(\w+)", hashes))
    return {
        "bomFormat": "CycloneDX",
        "specVersion": "1.6",
        "version": 1,
        "metadata": {"component": {"type": "application", "name": "triaxis", "bom-ref": "triaxis"}},
        "components": [
            {
                "type": "library",
                "name": package,
                "version": version,
                "purl": f"pkg:pypi/{package}@{version}",
                "externalReferences": [
                    {
                        "type": "distribution",
                        "url": f"pkg:pypi/{package}@{version}",
                        "hashes": [{"alg": "SHA-256", "content": one} for one in sorted(hashes)],
                    }
                ],
            }
            for (package, version), hashes in sorted(found.items())
        ],
    }


def _json(content: dict[str, Any]) -> bytes:
    return json.dumps(content, indent=1).encode() + b"\n"


def _sha256(content: bytes) -> str:
    return hashlib.sha256(content).hexdigest()


def _packed(files: Files) -> bytes:
    packed = io.BytesIO()
    with tarfile.open(fileobj=packed, mode="w", format=tarfile.PAX_FORMAT) as archive:
        for name, content in sorted(files.items()):
            # All else of the entry stays as it begins: no owner, no time.
            entry = tarfile.TarInfo(f"{_NAME}/{name}")
            entry.size, entry.mode = len(content), 0o644
            archive.addfile(entry, io.BytesIO(content))
    return gzip.compress(packed.getvalue(), mtime=0)
