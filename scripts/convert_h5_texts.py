# SPDX-License-Identifier: Apache-2.0
"""Gives the texts of `.h5` sets that Knuckle 0.1 wrote a fixed length, in place; their frames stay as they are.

    python3 scripts/convert_h5_texts.py FILE.h5...
"""
import sys

import h5py
import numpy as np


def convert(path):
    changed = 0
    with h5py.File(path, "r+") as file:
        for name in list(file.attrs):
            value = file.attrs[name]
            if h5py.check_string_dtype(file.attrs.get_id(name).dtype) is None or not isinstance(value, str):
                continue
            content = value.encode()
            file.attrs.create(name, np.bytes_(content), dtype=h5py.string_dtype("utf-8", max(1, len(content))))
            changed += 1
    print(f"{path}: {changed} texts")


for argument in sys.argv[1:]:
    convert(argument)
