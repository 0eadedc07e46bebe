// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "knuckle/core/options.h"
#include "knuckle/data/frame_source.h"
#include "knuckle/data/readers/nyu_truth.h"

namespace knuckle {

/// Settings of a `nyu:` source.
struct NyuOptions {
  int view = 1;  ///< which of the three cameras, [1, 3]

  void visit(OptionVisitor& visitor) { visitor.integer("view", view, closed(1, 3)); }
};

/// The NYU hand pose set (Tompson et al. 2014), 640x480: `depth_V_NNNNNNN.png`, 8-bit RGB with depth in mm as
/// G * 256 + B, 2001 = no measurement; truth in `joint_data.mat` (its u, v are kept, whose y axis runs down).
/// A folder without that file gives frames without truth.
class NyuSource final : public FrameSource {
 public:
  NyuSource(std::filesystem::path folder, const NyuOptions& options);

  std::int64_t size() const override { return static_cast<std::int64_t>(names_.size()); }
  Frame read(std::int64_t index) const override;
  FrameLabel read_label(std::int64_t index) const override;
  std::optional<Convention> convention() const override;

 private:
  std::optional<HandPose> read_truth(const std::string& name) const;

  std::filesystem::path folder_;
  std::string prefix_;              ///< "depth_V_"
  std::vector<std::string> names_;  ///< of the images of the view
  std::optional<NyuTruth> truth_;
};

}  // namespace knuckle
