// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "knuckle/core/camera.h"
#include "knuckle/core/options.h"
#include "knuckle/stream/camera_stream.h"

namespace knuckle {

/// The intrinsics that a person says, for cameras that do not know theirs.
struct IntrinsicsOptions {
  std::string camera = {};  ///< file with a [camera] table; empty: none
  double fov_deg = 0.0;     ///< horizontal field of view, [0, 175]; 0: not said

  void visit(OptionVisitor& visitor);
};

/// A camera, and where its numbers are from.
struct Intrinsics {
  Camera camera;
  std::string origin;  ///< as in CameraFacts; empty: they are a guess
};

/// A camera without distortion that looks through the middle of its image, with square pixels: what a
/// horizontal field of view in (0, 180) degrees tells.
Camera camera_of_field_of_view(int width, int height, double fov_deg);

/// The camera of the file that the options name; nothing where they name none. Throws an Error that names the
/// file where it is wrong, and where both a file and a field of view are given.
std::optional<Camera> camera_file_of(const IntrinsicsOptions& options);

/// The intrinsics of images of this size: those of the options, else those that the device reported, else a
/// guess. Throws an Error that starts with `where` where the file's camera has another size, or nothing is
/// known and that is refused.
Intrinsics find_intrinsics(const IntrinsicsOptions& options, std::optional<Intrinsics> reported, int width,
                           int height, UnknownIntrinsics unknown, std::string_view where);

}  // namespace knuckle
