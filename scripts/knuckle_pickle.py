# SPDX-License-Identifier: Apache-2.0
"""Reads the arrays of a pickled model without running what is in the pickle.

A pickle may name any function of Python to be called. Here only what numpy's arrays are made of is called;
objects of scipy.sparse and chumpy (which MANO's files hold) are kept as their plain contents, without these
packages; any other name is refused.
"""
import collections
import pickle

import numpy as np
from knuckle_body import BodyError, fail

SPARSE = {f"{layout}_{kind}": layout for layout in ("csc", "csr", "coo") for kind in ("matrix", "array")}


class Stored:
    """The contents of an object whose class is not loaded."""

    class_name = ""
    state = None

    def __init__(self, *arguments):
        del arguments

    def __setstate__(self, state):
        self.state = state if isinstance(state, dict) else {}


def encode_latin1(text, encoding="latin1"):
    """How Python 3 writes bytes in older pickles."""
    if encoding not in ("latin1", "latin-1"):
        raise pickle.UnpicklingError(f"text in {encoding}, expected latin1")
    return text.encode("latin1")


def reconstruct_object(kind, base, state):
    """How objects of protocols 0 and 1 begin."""
    del base, state
    if not (isinstance(kind, type) and issubclass(kind, Stored)):
        raise pickle.UnpicklingError(f"an object of {kind}")
    return kind()


CORE = getattr(np, "_core", None) or np.core  # numpy 2 renamed it
CALLED = {
    ("numpy", "ndarray"): np.ndarray,
    ("numpy", "dtype"): np.dtype,
    ("_codecs", "encode"): encode_latin1,
    ("collections", "OrderedDict"): collections.OrderedDict,
    ("copy_reg", "_reconstructor"): reconstruct_object,
    ("copyreg", "_reconstructor"): reconstruct_object,
    ("__builtin__", "object"): object,
    ("builtins", "object"): object,
}
for package in ("numpy.core", "numpy._core"):
    CALLED[(f"{package}.multiarray", "_reconstruct")] = CORE.multiarray._reconstruct
    CALLED[(f"{package}.multiarray", "scalar")] = CORE.multiarray.scalar
    CALLED[(f"{package}.numeric", "_frombuffer")] = CORE.numeric._frombuffer


class ArrayUnpickler(pickle.Unpickler):
    def find_class(self, module, name):
        if (module, name) in CALLED:
            return CALLED[(module, name)]
        if module.split(".")[0] == "chumpy" or (module.startswith("scipy.sparse") and name in SPARSE):
            return type(name, (Stored,), {"class_name": f"{module}.{name}"})
        raise BodyError(
            f"refused: it calls {module}.{name}, expected arrays of numpy, scipy.sparse and chumpy only"
        )


def read_pickle(path):
    """The dictionary in a pickle, of Python 2 or 3."""
    with open(path, "rb") as file:
        try:
            model = ArrayUnpickler(file, encoding="latin1").load()
        except BodyError:
            raise
        except Exception as error:  # a damaged pickle can raise anything
            fail(f"no whole pickle: {type(error).__name__}: {error}")
    if not isinstance(model, dict):
        fail(f"expected a dictionary of arrays, found {type(model).__name__}")
    return model


def dense_sparse(name, layout, state):
    """The array of a scipy.sparse matrix."""
    shape = state.get("_shape", state.get("shape"))
    if layout == "coo":
        rows, columns = state["coords"] if "coords" in state else (state["row"], state["col"])
    else:
        inner = state["indices"]
        outer = np.repeat(np.arange(len(state["indptr"]) - 1), np.diff(state["indptr"]))
        rows, columns = (inner, outer) if layout == "csc" else (outer, inner)
    if len(shape) != 2 or shape[0] * shape[1] > 10**8:
        fail(f"{name} is a sparse array of {shape}")
    dense = np.zeros(shape)
    np.add.at(dense, (np.asarray(rows), np.asarray(columns)), state["data"])
    return dense


def as_array(name, value):
    """The numbers of an entry of `read_pickle`, whatever it was stored as."""
    if not isinstance(value, Stored):
        return np.asarray(value)
    state, kind = value.state or {}, value.class_name.rsplit(".", 1)[1]
    try:
        if kind in SPARSE:
            return dense_sparse(name, SPARSE[kind], state)
        if kind == "Select":  # chumpy: entries of a flattened array
            chosen = as_array(name, state["a"]).ravel()[np.asarray(state["idxs"])]
            return chosen.reshape(state["preferred_shape"]) if "preferred_shape" in state else chosen
        if kind == "Reshape":
            return as_array(name, state["a"]).reshape(state["newshape"])
        if "x" in state:  # chumpy's plain array
            return as_array(name, state["x"])
    except (KeyError, IndexError, TypeError, ValueError) as error:
        fail(f"{name} is a damaged {value.class_name}: {error}")
    fail(f"{name} is a {value.class_name}, which is computed, not stored: save it as an array")
