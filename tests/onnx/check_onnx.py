#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""check_onnx.py FILE...: the checker of the ONNX library itself, with inference of all shapes. Exit status 77 where the library is
missing."""
import sys

try:
    import onnx
except ImportError as error:
    print(error, file=sys.stderr)
    sys.exit(77)

for path in sys.argv[1:]:
    model = onnx.load(path)
    onnx.checker.check_model(model, full_check=True)
    print(path, "is sound")
