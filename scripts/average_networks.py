#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The mean of the weights of two networks, of which the second was trained on from the first: often better than either,
as what a training forgets and what it learns differ (Wortsman et al., "Robust fine-tuning of zero-shot models", 2022).

    average_networks.py FIRST.pt SECOND.pt SHARE OUT.pt

SHARE is the weight of the second, from 0 to 1. Needs numpy.
"""
import sys
import tomllib

import numpy as np

import knuckle_model_file as model_file

FORMAT = ("knuckle-network", 3)


def mean_of(first, second, share):
    """Of arrays of equal shapes: "weights" in half precision, as bits (src/knuckle/net/network_file.h), and "norms"."""
    def mixed(one, other):
        return (1.0 - share) * one.astype(np.float64) + share * other.astype(np.float64)

    weights = mixed(first["weights"].view(np.float16), second["weights"].view(np.float16))
    return {
        "weights": weights.astype(np.float16).view(np.uint16),
        "norms": mixed(first["norms"], second["norms"]).astype(np.float32),
    }


def options_of(values):
    """What a model's options say, key by key."""
    tables = tomllib.loads(values["options"])
    return {f"{name}.{key}": value for name, table in tables.items() for key, value in table.items()}


def are_alike(first, second):
    """Whether two models have the same options; one may say more than the other, which an older program wrote."""
    one, other = options_of(first), options_of(second)
    return all(one[key] == other[key] for key in one.keys() & other.keys())


def main(arguments):
    if len(arguments) != 4:
        return __doc__
    first_path, second_path, share_text, out = arguments
    try:
        share = float(share_text)
        if not 0.0 <= share <= 1.0:
            return f"the share is {share_text}, expected 0 to 1"
        values, first = model_file.read(first_path, *FORMAT)
        other_values, second = model_file.read(second_path, *FORMAT)
        if not are_alike(values, other_values):
            return f"{second_path}: a network with other options than {first_path}; only one trained on from it has a mean"
        model_file.write(out, *FORMAT, other_values, mean_of(first, second, share), compact=False)
    except (OSError, ValueError, KeyError) as error:
        return f"average_networks: {error}"
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
