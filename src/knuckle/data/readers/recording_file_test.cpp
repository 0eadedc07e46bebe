// SPDX-License-Identifier: Apache-2.0
#include "knuckle/data/readers/recording_file.h"

#include "knuckle/core/testing.h"
#include "knuckle/data/readers/data_testing.h"

namespace knuckle {
namespace {

using testing::error_of;
using ::testing::HasSubstr;
using testing::put_file;

TEST(RecordingFile, ReadsNothingBeyondItsEnd) {
  const testing::TemporaryFolder folder;
  put_file(folder / "a.bag", "0123456789");
  const RecordingFile file(folder / "a.bag");
  EXPECT_EQ(file.read(4, 6).size(), 6u);
  EXPECT_THAT(error_of([&] { file.read(4, 7); }), HasSubstr("a.bag: at byte 4: 7 bytes lie beyond the end"));
  EXPECT_THAT(error_of([&] { file.read(11, 0); }),
              HasSubstr("a.bag: at byte 11: 0 bytes lie beyond the end"));
  std::filesystem::resize_file(folder / "a.bag", 5);
  EXPECT_THAT(error_of([&] { file.read(4, 6); }),
              HasSubstr("a.bag: was changed while it was read: it was cut short"));
}

}  // namespace
}  // namespace knuckle
