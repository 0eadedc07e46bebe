// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>
#include <string>

#include <pybind11/pybind11.h>

#include "knuckle/core/landmarks.h"
#include "knuckle/estimate/estimator.h"
#include "knuckle/patch/patch_extractor.h"

namespace knuckle::python {

/// A function of the user's, and what it must be known by: `knuckle.Estimator`.
struct OwnEstimator {
  pybind11::object function;
  Convention convention;
  PatchOptions patch;
  int passes;
  double sure_confidence;
};

/// What a pipeline asks.
struct AskedEstimator {
  std::unique_ptr<Estimator> estimator;  ///< null where there is none of the user's
  pybind11::object* function = nullptr;  ///< where it holds the user's function; null as well
};

/// Needs the interpreter's lock here alone.
AskedEstimator estimator_of(const std::optional<OwnEstimator>& own);

}  // namespace knuckle::python
