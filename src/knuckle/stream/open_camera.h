// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "knuckle/data/frame_source.h"
#include "knuckle/data/source_spec.h"
#include "knuckle/stream/camera_stream.h"

namespace knuckle {

/// A camera that is connected, or something that looks like one.
struct CameraListing {
  std::string stream;  ///< how to name it: "v4l2:/dev/video2"
  std::string device;  ///< what it calls itself
  std::string state;   ///< what can be said of it: its formats, or why it cannot be used
  bool is_usable = false;
};

/// A kind of camera.
struct CameraKind {
  std::string_view name;         ///< as written before the colon of a stream
  std::string_view description;  ///< one line for a person
  bool is_built;                 ///< whether this build has what it needs
  std::unique_ptr<CameraStream> (*open)(const SourceSpec&, UnknownIntrinsics);
  std::vector<CameraListing> (*list)();
};

/// All kinds, also those that this build lacks.
std::span<const CameraKind> camera_kinds();

/// Whether the text starts with a kind of camera and a colon.
bool names_a_camera(std::string_view text);

/// Opens and starts a camera, `KIND:[DEVICE][?key=value&...]`. Throws an Error that says what to do where
/// that cannot be.
std::unique_ptr<CameraStream> open_camera(std::string_view text,
                                          UnknownIntrinsics unknown = UnknownIntrinsics::refuse);

/// Opens a recording of OpenNI2, `oni:FILE[?camera=FILE.toml]`. Throws an Error where it cannot be read.
std::unique_ptr<FrameSource> open_oni(const SourceSpec& spec);

}  // namespace knuckle
