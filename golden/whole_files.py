"""Files that are written whole or not at all."""

import os
from pathlib import Path

from triaxis.golden.errors import InputError


def write_whole(path: Path, content: str | bytes) -> Path:
    """Write a file, and the folder where there is none; raise InputError where that cannot be done.

    Text is written as UTF-8.
    """
    whole = content.encode() if isinstance(content, str) else content
    partial = path.with_name(f".{path.name}-{os.getpid()}.partial")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        try:
            partial.write_bytes(whole)
            partial.replace(path)
        finally:
            partial.unlink(missing_ok=True)
    except OSError as error:
        raise InputError(f"{path}: cannot write: {error.strerror or error}") from error
    return path
