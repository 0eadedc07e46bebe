// SPDX-License-Identifier: Apache-2.0
// What messages of the live page and of the page for labelling have in common; for this module alone.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include <nlohmann/json.hpp>

#include "knuckle/core/frame.h"
#include "knuckle/core/landmarks.h"
#include "knuckle/data/frame_record.h"

namespace knuckle {

/// Keys keep their order.
using Json = nlohmann::ordered_json;

/// One line; bytes that are not UTF-8 are replaced.
std::string text_of(const Json& json);

/// The keys of a folder set's [camera]; pixel coordinates start at the centre of the first pixel.
Json camera_json(const Camera& camera);
/// The landmarks' names, in their order.
Json landmarks_json(const Convention& convention);
/// Pairs of names.
Json bones_json(const Convention& convention);
/// The flesh around a hand (`fitted_flesh`): a piece of eight numbers per cone, x, y, z and radius of one
/// end, then of the other [mm].
Json flesh_json(const HandRecord& hand);

/// A frame as bytes: the length of a JSON header as uint32 LE; the header, which holds `fields` (the inside
/// of an object), the camera, the size, unit and kind of the images, and is filled up with blanks to a
/// multiple of 4 bytes; depth as uint16 LE in `depth_unit_mm`, row by row, 0 = no measurement; infrared, also
/// uint16 LE, where the frame has it.
std::vector<std::uint8_t> image_message(const Frame& frame, std::string_view fields);

}  // namespace knuckle
