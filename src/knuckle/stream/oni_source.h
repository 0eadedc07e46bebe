// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <memory>
#include <mutex>
#include <string>

#include "knuckle/core/options.h"
#include "knuckle/data/frame_source.h"
#include "knuckle/stream/camera_process.h"
#include "knuckle/stream/intrinsics.h"

namespace knuckle {

/// Settings of an `oni:` source.
struct OniOptions {
  IntrinsicsOptions intrinsics;

  void visit(OptionVisitor& visitor) { intrinsics.visit(visitor); }
};

/// A recording that OpenNI2 wrote: the first depth stream of an .oni file. OpenNI2 reads it, in a process of its
/// own: where that crashes or hangs on a frame, the frame is at fault, and the next one gets another process.
/// Frames are read one at a time, whatever the number of threads.
class OniSource final : public FrameSource {
 public:
  /// Throws an Error that names the file where it is missing or no such recording, holds no depth, or its camera
  /// is not known.
  explicit OniSource(const std::filesystem::path& path, const OniOptions& options = {});
  /// The same with another program in place of camera_program(): for tests.
  OniSource(std::filesystem::path path, const OniOptions& options, std::filesystem::path program);

  std::int64_t size() const override { return description_.frames; }
  Frame read(std::int64_t index) const override;
  std::optional<Convention> convention() const override { return std::nullopt; }

 private:
  PipedDescription begin() const;
  Frame read_anew(std::int64_t index) const;

  std::filesystem::path path_;
  std::string where_;
  std::filesystem::path program_;
  mutable std::mutex mutex_;
  mutable std::unique_ptr<CameraProcess> process_;  ///< null: one has to be started
  mutable std::optional<std::pair<std::int64_t, Frame>> last_;  ///< who asks for a label asks for the frame next
  PipedDescription description_;
  Camera camera_;
};

}  // namespace knuckle
