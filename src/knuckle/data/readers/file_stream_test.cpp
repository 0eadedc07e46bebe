// SPDX-License-Identifier: Apache-2.0
#include "knuckle/data/readers/file_stream.h"

#include <string>

#include "knuckle/core/testing.h"
#include "knuckle/data/readers/data_testing.h"
#include "knuckle/data/readers/recording_testing.h"

namespace knuckle {
namespace {

using testing::error_of;
using ::testing::HasSubstr;
using testing::packed;
using testing::put_file;

const std::string kContent = "what lies in the part";

class FileStreamTest : public ::testing::Test {
 protected:
  /// Reads the content from a part of these bytes, in which nothing may be left.
  void read(const std::string& bytes, FileStream::Packing packing) {
    put_file(path_, "before" + bytes + "behind");
    const RecordingFile file(path_);
    FileStream stream(file, 6, bytes.size(), packing);
    std::vector<std::uint8_t> read(kContent.size());
    stream.read(read);
    EXPECT_EQ(std::string(read.begin(), read.end()), kContent);
    stream.require_end();
  }
  std::string fault_of(const std::string& bytes, FileStream::Packing packing) {
    return error_of([&] { read(bytes, packing); });
  }

  testing::TemporaryFolder folder_;
  std::filesystem::path path_ = folder_ / "a.bin";
};

TEST_F(FileStreamTest, EndsWithItsPart) {
  read(kContent, FileStream::Packing::none);
  read(packed(kContent, "zlib"), FileStream::Packing::zlib);
}

TEST_F(FileStreamTest, WhatIsLeftInThePartIsAFault) {
  EXPECT_THAT(fault_of(kContent + "more", FileStream::Packing::none),
              HasSubstr("a.bin: at byte 6: holds more than it says"));
  EXPECT_THAT(fault_of(packed(kContent, "zlib") + "more", FileStream::Packing::zlib),
              HasSubstr("holds more than it says"));
  EXPECT_THAT(fault_of(packed(kContent + "more", "zlib"), FileStream::Packing::zlib),
              HasSubstr("holds more than it says"));
}

TEST_F(FileStreamTest, PackedBytesEndWithTheirSum) {
  const std::string bytes = packed(kContent, "zlib");
  for (const std::size_t cut : {1, 2, 4}) {
    EXPECT_THAT(fault_of(bytes.substr(0, bytes.size() - cut), FileStream::Packing::zlib),
                HasSubstr("a.bin: at byte 6: is cut short or damaged"))
        << cut;
  }
}

}  // namespace
}  // namespace knuckle
