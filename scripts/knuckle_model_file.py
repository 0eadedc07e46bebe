# SPDX-License-Identifier: Apache-2.0
"""A model's file as Knuckle reads and writes it (src/knuckle/storage/model_file.h): a zip with a sum."""
import io
import json
import os
import secrets
import zipfile
import zlib

import numpy as np

HEADER = "model.json"
SUM_MARK = b"knuckle-sum "
SUM_DIGITS = 16


class ModelFileError(ValueError):
    """A fault of a model's file, in one line."""


def sum_of(content):
    return f"{zlib.crc32(content):08x}{zlib.adler32(content):08x}".encode()


def add_entry(archive, name, content, compact=True):
    entry = zipfile.ZipInfo(name)  # without a time: the same content makes the same bytes
    smaller = compact and len(zlib.compress(content, 9)) - 6 < len(content)
    entry.compress_type = zipfile.ZIP_DEFLATED if smaller else zipfile.ZIP_STORED
    archive.writestr(entry, content, compresslevel=9)


def description_of(array, compact=True):
    description = {"type": array.dtype.name, "shape": list(array.shape)}
    return description | ({"shuffled": True} if compact and array.dtype.itemsize > 1 else {})


def content_of(array, compact=True):
    """Little-endian numbers; where compact, the first bytes of all, then the second bytes of all, ..."""
    numbers = array.astype(array.dtype.newbyteorder("<")).tobytes()
    if not compact:
        return numbers
    return np.frombuffer(numbers, np.uint8).reshape(-1, array.dtype.itemsize).T.tobytes()


def array_of(description, content):
    number = np.dtype(description["type"]).newbyteorder("<")
    if description.get("shuffled"):
        content = np.frombuffer(content, np.uint8).reshape(number.itemsize, -1).T.tobytes()
    return np.frombuffer(content, number).reshape(description["shape"])


def file_bytes(file_format, version, values, arrays, compact=True):
    """The bytes of a file with these values (texts, numbers, lists of texts) and numpy arrays. Not compact, as networks are:
    arrays are stored as they are, for quick reading."""
    arrays = {name: np.ascontiguousarray(array) for name, array in sorted(arrays.items())}
    header = {
        "format": file_format,
        "version": version,
        "values": values,
        "arrays": {name: description_of(array, compact) for name, array in arrays.items()},
    }
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w") as archive:
        add_entry(archive, HEADER, json.dumps(header, indent=1).encode() + b"\n")
        for name, array in arrays.items():
            add_entry(archive, name, content_of(array, compact), compact)
        archive.comment = SUM_MARK + b"0" * SUM_DIGITS
    content = stream.getvalue()[:-SUM_DIGITS]
    return content + sum_of(content)


def write(path, file_format, version, values, arrays, compact=True):
    """Writes the file; it appears only when whole."""
    content = file_bytes(file_format, version, values, arrays, compact)
    temporary = f"{path}.{secrets.token_hex(8)}.partial"
    try:
        with open(temporary, "xb") as file:
            file.write(content)
            file.flush()
            os.fsync(file.fileno())
        os.replace(temporary, path)
    finally:
        if os.path.exists(temporary):
            os.remove(temporary)


def read(path, file_format, version):
    """Values and arrays of a file of this format and version."""
    with open(path, "rb") as file:
        content = file.read()
    body, found = content[:-SUM_DIGITS], content[-SUM_DIGITS:]
    if not body.endswith(SUM_MARK):
        raise ModelFileError(f"{path}: not a model's file, or cut short: its sum is missing")
    if sum_of(body) != found:
        raise ModelFileError(f"{path}: damaged: its content does not have the sum that it says")
    with zipfile.ZipFile(io.BytesIO(content)) as archive:
        header = json.loads(archive.read(HEADER))
        if header["format"] != file_format or header["version"] != version:
            raise ModelFileError(
                f"{path}: {header['format']} of version {header['version']}, "
                f"expected {file_format} of version {version}"
            )
        arrays = {
            name: array_of(description, archive.read(name))
            for name, description in header["arrays"].items()
        }
    return header["values"], arrays
