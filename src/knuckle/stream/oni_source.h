// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <filesystem>
#include <map>
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

/// A recording that OpenNI2 wrote: the first depth stream of an .oni file. OpenNI2 reads it from its start
/// on, in a process of its own: where that crashes or hangs, frames from there on are faulty. Going on is
/// fast; going back by more frames than are kept begins anew. One frame is read at a time, whatever the
/// number of threads.
class OniSource final : public FrameSource {
 public:
  /// Throws an Error that names the file where it is missing or no such recording, holds no depth, or its
  /// camera is not known.
  explicit OniSource(const std::filesystem::path& path, const OniOptions& options = {});
  /// The same with another program in place of camera_program(): for tests.
  OniSource(std::filesystem::path path, const OniOptions& options, std::filesystem::path program);

  std::int64_t size() const override { return description_.frames; }
  Frame read(std::int64_t index) const override;
  std::optional<Convention> convention() const override { return std::nullopt; }

 private:
  using Messages = std::map<std::int64_t, ReceivedMessage>;

  PipedDescription begin() const;
  const ReceivedMessage& message_of(std::int64_t index) const;
  void read_on() const;
  void keep(std::int64_t number, ReceivedMessage message) const;

  std::filesystem::path path_;
  std::string where_;
  std::filesystem::path program_;
  PipedDescription description_;
  Camera camera_;

  mutable std::mutex mutex_;                        ///< of what follows
  mutable std::unique_ptr<CameraProcess> process_;  ///< null: one has to be started
  mutable std::int64_t next_ = 0;                   ///< frame that comes next
  mutable Messages kept_;                           ///< the last that came: threads ask for neighbours
  mutable std::size_t kept_bytes_ = 0;
  mutable std::int64_t faulty_ = 0;  ///< nothing comes from this frame on
  mutable std::string fault_;        ///< why; empty: nothing is wrong yet
};

}  // namespace knuckle
