// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <limits>
#include <memory>
#include <string_view>

#include "knuckle/core/options.h"
#include "knuckle/data/frame_source.h"

namespace knuckle {

/// Which frames of a source to take: `first`, `first + step`, ..., at most `count` of them.
struct FrameSelection {
  int first = 0;                                ///< [0, inf)
  int count = std::numeric_limits<int>::max();  ///< [1, inf); a source that holds fewer gives what it has
  int step = 1;                                 ///< [1, inf)

  void visit(OptionVisitor& visitor);
  bool takes_all() const { return *this == FrameSelection{}; }
  bool operator==(const FrameSelection&) const = default;
};

/// Selected frames of another source, numbered from 0 on.
class SelectedFrames final : public FrameSource {
 public:
  /// Throws an Error where the selection is out of range or leaves no frame; it starts with `where`.
  SelectedFrames(std::unique_ptr<FrameSource> source, const FrameSelection& selection,
                 std::string_view where);

  std::int64_t size() const override { return size_; }
  Frame read(std::int64_t index) const override;
  FrameLabel read_label(std::int64_t index) const override;
  std::optional<Convention> convention() const override { return source_->convention(); }
  PixelOrigin pixel_origin() const override { return source_->pixel_origin(); }

 private:
  std::int64_t index_in_source(std::int64_t index) const;

  std::unique_ptr<FrameSource> source_;
  FrameSelection selection_;
  std::int64_t size_;
};

/// The source itself where the selection takes all of it, otherwise wrapped. Errors start with `where`.
std::unique_ptr<FrameSource> select_frames(std::unique_ptr<FrameSource> source,
                                           const FrameSelection& selection, std::string_view where);

}  // namespace knuckle
