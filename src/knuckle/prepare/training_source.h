// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "knuckle/core/options.h"
#include "knuckle/pipeline/hand_finder.h"

namespace knuckle {

/// A set of frames that a training takes samples from. One set is a text,
///
///     source = "folder:../mine"
///     holdout = 0.1
///
/// several are tables, whose other keys are the options of this struct:
///
///     [[source]]
///     source = "folder:../mine"     # a relative path starts at the file
///     weight = 1.0
///
///     [[source]]
///     source = "synthetic:../manifests/train_network.toml"
///     weight = 3.0                  # three of four samples are its
struct TrainingSource {
  std::string source = {};  ///< as `open_source` takes it
  /// The set's part of the samples, against the other sets' weights and whatever the sets' sizes, [0.001,
  /// 1000].
  double weight = 1.0;
  std::string side = "right";  ///< right | left: which hands it shows, where the set itself does not say
  double holdout = 0.0;        ///< Share of the frames, as whole sequences, that validation keeps, [0, 0.9]
  int most = 0;                ///< Frames used at most, evenly spread, [0, 1e9]; 0: all
  int most_things = 0;         ///< Frames that things which look like hands are cut out of, [0, 1e9]; 0: none

  void visit(OptionVisitor& visitor);
};

/// The tables `[[source]]` of a configuration, each a set; none where there is one set, which is a text.
std::vector<OptionTable> source_tables_in(const OptionTable& document);
/// The one set of a configuration, its key `source`. Throws an Error that says what both forms look like
/// where it is neither.
std::string one_source_in(const OptionTable& document);

/// Reads the sets of a configuration: its key `source`, and `holdout` beside it where that is a text.
/// `defaults` are the options of a table that does not say them, and of the one set. Throws an Error that
/// names file, line and key where something is wrong.
std::vector<TrainingSource> training_sources_in(const OptionTable& document, const TrainingSource& defaults);

}  // namespace knuckle
