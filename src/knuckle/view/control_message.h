// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string_view>

namespace knuckle {

/// What the page asks of a recording.
struct RecordingRequest {
  bool on = false;  ///< true: begin one; false: end the one that is running
};

/// Reads `{"on": true}` or `{"on": false}`. Throws an Error of one line where the text is anything else: no
/// JSON, deeply nested, another key, another type.
RecordingRequest parse_recording_request(std::string_view json);

}  // namespace knuckle
