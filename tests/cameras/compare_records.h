// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <vector>

#include "knuckle/data/frame_record.h"

namespace knuckle::testing {

/// The records of a file of JSON lines, in its order.
std::vector<FrameRecord> read_records(const std::filesystem::path& path);

/// That every record of `live` has the hands that the record of the same frame in `of_file` has, to the bit,
/// and that there are hands.
void expect_records_of_file(const std::vector<FrameRecord>& live, const std::vector<FrameRecord>& of_file);

}  // namespace knuckle::testing
