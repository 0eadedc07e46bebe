// SPDX-License-Identifier: Apache-2.0
// Conventions of one's own: a file names the landmarks, and the program knows them from then on. All
// functions may be called from many threads.
#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "knuckle/core/landmarks.h"
#include "knuckle/core/options.h"

namespace knuckle {

/// Landmarks that the program knows by itself: the enumeration's.
inline constexpr std::size_t kKnownLandmarks = static_cast<std::size_t>(Landmark::nyu_wrist_2) + 1;

/// Whether a landmark is none of the enumeration.
bool is_own(Landmark landmark);
/// The landmark of the enumeration that has this name.
std::optional<Landmark> known_landmark(std::string_view name);

/// The landmark of that name: one of the enumeration, or one of one's own, which is made where it is new.
/// `near`: the landmark of the 22 that it lies near to, which drawings of skeletons go by. The name is one to
/// 64 small letters, digits and underscores, and begins with a letter. Throws an Error that quotes another
/// one.
Landmark own_landmark(std::string_view name, Landmark near);
/// Its name, as long as the program runs. `landmark` is one of one's own.
std::string_view own_landmark_name(Landmark landmark);
/// That of the 22 which it lies near to.
Landmark own_landmark_is_near(Landmark landmark);

/// Makes a convention known under its name, for the rest of the program. The same landmarks under the same
/// name again change nothing. Throws an Error where the name is taken by others, or is none (as of a
/// landmark), or a landmark is there twice or none is.
const Convention& register_convention(std::string_view name, const std::vector<Landmark>& landmarks);
/// The one that was registered under that name.
const Convention& registered_convention(std::string_view name);
/// A convention as a text that tells another program all of it: the name of one that every program knows; of
/// one's own also its landmarks, and those of the 22 that its own lie near to, as in
/// "glove3: wrist, glove_knob~index_mcp, index_tip".
std::string convention_text(const Convention& convention);
/// The convention of such a text; one's own is registered. Throws an Error where a name is unknown or wrong.
const Convention& convention_from_text(std::string_view text);
/// All that were registered, in their order.
std::vector<Convention> own_conventions();

/// Reads the file of a definition of landmarks (docs/landmarks.md) as far as it names a convention and its
/// landmarks, and registers it. Throws an Error that names file and line where something is wrong.
const Convention& convention_from_file(const std::filesystem::path& path);

/// What an option says: a convention's name, or the file (*.toml) of one's own.
const Convention& convention_from_option(const std::string& text);

/// The same of a key of a document, `otherwise` where it is missing; the file's path starts from the
/// document's folder. Throws an Error that names file, line and key.
const Convention& convention_from_key(const OptionTable& document, std::string_view key,
                                      std::string_view otherwise);

/// What a file of data says: a convention's name, or the name of the file of one's own, which lies in the
/// same folder: data are whole by themselves, and name nothing elsewhere.
const Convention& convention_in_folder(const std::string& text, const std::filesystem::path& folder);

}  // namespace knuckle
