# SPDX-License-Identifier: Apache-2.0
"""Sources as Python sequences."""

import collections.abc
import operator

from . import _knuckle


class Source(collections.abc.Sequence):
    """The frames of a source: a sequence that reads a Frame each time one is asked for.

    `source[3]`, `source[-1]`, `len(source)`, loops; `source[10:20]` is a Source of these frames, of which none is read yet.
    Safe to use from many threads.
    """

    def __init__(self, frames, name, numbers=None):
        self._frames = frames
        self._name = name
        self._numbers = range(len(frames)) if numbers is None else numbers

    @property
    def name(self):
        """What it was opened by."""
        return self._name

    @property
    def convention(self):
        """Name of the convention of its truth; None where it has none."""
        return self._frames.convention

    def __len__(self):
        return len(self._numbers)

    def __getitem__(self, key):
        if isinstance(key, slice):
            return Source(self._frames, self._name, self._numbers[key])
        index = operator.index(key)
        try:
            number = self._numbers[index]
        except IndexError:
            raise IndexError(f"frame {index} of {len(self)}: {self._name}") from None
        return self._frames.read(number)

    def __repr__(self):
        return f"<knuckle.Source {self._name!r}, {len(self)} frames>"


def open_source(text):
    """Opens a data set or recording: `KIND:PATH[?key=value&...]`, as `knuckle estimate --source` takes it.

    Returns a Source. Raises knuckle.Error where there is no such kind, or the source is wrong.
    """
    return Source(_knuckle.open_source(text), text)
