// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>

#include "knuckle/hand/body.h"

namespace knuckle {

class ModelFile;

/// Writes a body (storage/model_file.h; format "knuckle-body", version 2); the file appears only when whole.
/// Arrays, after
/// SMPL's and MANO's: `v_template` V x 3 [mm], `faces` F x 3, `is_hand` F, `weights` V x B, `names` B,
/// `parents` B, `sections` S x 2 (vertices, faces). Sparse rows, where row i is entries starts[i] to starts[i
/// + 1]: `shapedirs_names` K, `shapedirs_starts`, `shapedirs_vertices`, `shapedirs_offsets` N x 3 [mm];
/// `joint_regressor_starts`, `..._vertices`,
/// `..._weights`; the same of `landmark_regressor`, whose 22 rows `landmark_names` names and `landmark_bones`
/// carry.
void save_body(const Body& body, const std::filesystem::path& path);

/// A hash of all that makes a body: another body has another one.
std::string body_hash(const Body& body);

/// Reads such a file. Throws an Error that names the file and the fault where it is missing, cut short, of
/// another format or version, or where its arrays make no body (see `check`).
Body load_body(const std::filesystem::path& path);
/// The same of a file that is open.
Body read_body(const ModelFile& file);

}  // namespace knuckle
