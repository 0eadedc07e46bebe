// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "knuckle/core/landmarks.h"

namespace knuckle {

/// Frames to be tested on.
struct PlannedSequence {
  std::string name;    ///< of its folder
  std::string title;   ///< for readers
  std::string source;  ///< as the program takes it; a relative path has been made absolute
};

/// A model that has to be there, or is trained.
struct PlannedModel {
  std::string file;               ///< its name in the folder of models
  std::string kind;               ///< what `knuckle train` is told: pose-forest, segmentation-forest, network
  std::filesystem::path config;   ///< of its training
  std::filesystem::path trained;  ///< a file to use instead of training; empty: none
};

/// A method under test.
struct PlannedMethod {
  std::string name;                ///< stands in tables and legends
  std::filesystem::path pipeline;  ///< pipeline file; its models are named `../models/FILE`

  std::string stem() const;  ///< of its files: "mean shift" becomes "mean_shift"
};

/// A whole evaluation as a file describes it:
///
///     title = "..."
///     convention = "icg20"
///     claims = "scia15"                               # optional: whose claims the report judges
///     [[sequence]]
///     name = "creative"
///     title = "Creative GestureCam"
///     source = "synthetic:../manifests/test_creative.toml"
///     [[model]]
///     file = "pose_forest.model"
///     kind = "pose-forest"
///     config = "../pipelines/train_pose_forest.toml"
///     trained = "../models/pose_forest.model"           # optional: used instead of training
///     [[segmentation]]
///     name = "mean shift"
///     pipeline = "scia15/mean_shift.toml"
///     [[estimation]]
///     name = "forest"
///     pipeline = "scia15/forest.toml"
struct ExperimentPlan {
  std::string name;   ///< of the file, without extension
  std::string title;  ///< of the report
  Convention convention;
  std::string claims;  ///< whose claims the report compares with the results: scia15 | none
  std::vector<PlannedSequence> sequences;  ///< at least one
  std::vector<PlannedModel> models;
  std::vector<PlannedMethod> segmentation;
  std::vector<PlannedMethod> estimation;

  /// Throws an Error that names file, line and key where the file is wrong, a name stands twice or is none
  /// for a file, or a kind of model is not known.
  static ExperimentPlan load(const std::filesystem::path& path);
};

/// The plan of a published evaluation that comes with Knuckle, as in "scia15", or of a file. Throws an Error
/// that lists the known ones.
ExperimentPlan find_plan(const std::string& name);

}  // namespace knuckle
