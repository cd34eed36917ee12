"""Precomputed tables on disk, so that a second start need not compute them again.

A file is named by the content it depends on (parameters, sizes, shader text, format version) and carries a checksum
over its header and its data. Whatever is wrong with a file, it counts as missing: the table is computed again and the
file is replaced, atomically, so that a reader never sees half of one.
"""

import contextlib
import hashlib
import json
import logging
import os
import sys
import tempfile
from pathlib import Path

import numpy as np

FORMAT_VERSION = 1
MAGIC = b"shadowatmo table\n"
FOLDER_VARIABLE = "SHADOWATMO_CACHE_DIR"

log = logging.getLogger("shadowatmo")


def default_folder() -> Path:
    """Return the user's cache folder: SHADOWATMO_CACHE_DIR where that is set, else the system's usual place."""
    if os.environ.get(FOLDER_VARIABLE):
        return Path(os.environ[FOLDER_VARIABLE])
    if sys.platform == "win32":
        return Path(os.environ.get("LOCALAPPDATA", Path.home() / "AppData" / "Local")) / "shadowatmo" / "Cache"
    if sys.platform == "darwin":
        return Path.home() / "Library" / "Caches" / "shadowatmo"
    return Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "shadowatmo"


class TableCache:
    """Arrays by content key in one folder.

    Parameters
    ----------
    folder : path, optional
        Made when the first table is saved. None: `default_folder()`.
    """

    def __init__(self, folder=None):
        self.folder = default_folder() if folder is None else Path(folder)

    @staticmethod
    def key(*parts) -> str:
        """Return the key of what a table depends on; `parts` need a `repr` that tells them apart."""
        return hashlib.sha256(repr((FORMAT_VERSION, *parts)).encode("utf-8")).hexdigest()

    def path(self, key) -> Path:
        """Return the file of a key."""
        return self.folder / f"{key}.table"

    def load(self, key) -> dict[str, np.ndarray] | None:
        """Return the arrays saved under a key, or None where there are none or the file is not sound."""
        try:
            content = self.path(key).read_bytes()
        except OSError:
            return None
        try:
            return _decode(content, key)
        except ValueError as error:
            log.warning("the cached table %s is not sound (%s); it will be computed again", self.path(key).name, error)
            return None

    def save(self, key, arrays) -> bool:
        """Save arrays under a key; return whether that worked. A full or read-only disk is no error, only no cache."""
        try:
            self.folder.mkdir(parents=True, exist_ok=True)
            handle, name = tempfile.mkstemp(dir=self.folder, suffix=".part")
            try:
                with os.fdopen(handle, "wb") as file:
                    file.write(_encode(arrays, key))
                os.replace(name, self.path(key))
            except BaseException:
                with contextlib.suppress(OSError):
                    os.unlink(name)
                raise
        except OSError as error:
            log.warning("the table could not be kept in %s: %s", self.folder, error)
            return False
        return True


def _encode(arrays, key) -> bytes:
    """Return a file's content: magic, checksum of the rest, length of the header, header, data."""
    arrays = {name: np.ascontiguousarray(array) for name, array in arrays.items()}
    entries = [[name, array.dtype.str, list(array.shape)] for name, array in arrays.items()]
    header = json.dumps({"version": FORMAT_VERSION, "key": key, "arrays": entries}).encode("utf-8")
    body = len(header).to_bytes(8, "little") + header + b"".join(array.tobytes() for array in arrays.values())
    return MAGIC + hashlib.sha256(body).digest() + body


def _decode(content, key) -> dict[str, np.ndarray]:
    """Return the arrays of a file's content; ValueError says what is wrong with it."""
    digest_end = len(MAGIC) + hashlib.sha256().digest_size
    if not content.startswith(MAGIC):
        raise ValueError("it is of another kind")
    body = content[digest_end:]
    if hashlib.sha256(body).digest() != content[len(MAGIC) : digest_end]:
        raise ValueError("its checksum does not match")
    size = int.from_bytes(body[:8], "little")
    header = json.loads(body[8 : 8 + size])
    if header["version"] != FORMAT_VERSION or header["key"] != key:
        raise ValueError("it was made for something else")
    arrays, offset = {}, 8 + size
    for name, dtype, shape in header["arrays"]:
        count = int(np.prod(shape)) * np.dtype(dtype).itemsize
        arrays[name] = np.frombuffer(body[offset : offset + count], dtype).reshape(shape)
        offset += count
    return arrays
