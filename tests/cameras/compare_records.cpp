// SPDX-License-Identifier: Apache-2.0
#include "compare_records.h"

#include <algorithm>
#include <sstream>
#include <string>

#include <gtest/gtest.h>

#include "knuckle/core/text_file.h"

namespace knuckle::testing {

std::vector<FrameRecord> read_records(const std::filesystem::path& path) {
  std::istringstream lines(read_text_file(path));
  std::vector<FrameRecord> records;
  for (std::string line; std::getline(lines, line);) records.push_back(parse_frame_record(line));
  return records;
}

void expect_records_of_file(const std::vector<FrameRecord>& live, const std::vector<FrameRecord>& of_file) {
  std::size_t hands = 0;
  for (const FrameRecord& record : live) {
    const auto expected = std::ranges::find(of_file, record.frame, &FrameRecord::frame);
    ASSERT_NE(expected, of_file.end()) << record.frame;
    ASSERT_EQ(record.hands.size(), expected->hands.size()) << record.frame;
    for (std::size_t i = 0; i < record.hands.size(); ++i)
      EXPECT_EQ(record.hands[i].landmarks_mm, expected->hands[i].landmarks_mm) << record.frame;
    hands += record.hands.size();
  }
  EXPECT_GT(hands, 0U);
}

}  // namespace knuckle::testing
