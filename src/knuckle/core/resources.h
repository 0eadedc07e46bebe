// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string_view>

namespace knuckle {

/// From now on the files that come with Knuckle (models, pipelines, manifests, the body) are looked for in
/// `folder`, which has to be there. For programs that bring these files themselves: a folder like the
/// installed share/knuckle, or a part of it. Call it before the first use of what lies there: a pipeline that
/// is loaded already keeps what it read. May be called from any thread at any time. Throws an Error where
/// there is no such folder.
void set_data_folder(const std::filesystem::path& folder);

/// The place of a file that comes with Knuckle, as in resource_path("pipelines/default.toml"). It is below
/// the first of these that is there:
///
/// 1. the folder of the last call of set_data_folder,
/// 2. the environment's KNUCKLE_HOME,
/// 3. share/knuckle, in the folder of the shared library (or program) that contains this function or up to
///    four folders above it: so an installed Knuckle may be moved as a whole.
///
/// The other places are not tried where the file is missing there: that is for its reader to say. Throws an
/// Error that says where it looked where none of the three is there. May be called from any thread.
std::filesystem::path resource_path(std::string_view relative);

/// A program that Knuckle starts by itself: libexec/knuckle/NAME in the folder of the shared library (or
/// program) that contains this function or up to four folders above it. Throws an Error where it is missing.
/// May be called from any thread.
std::filesystem::path helper_program(std::string_view name);

}  // namespace knuckle
