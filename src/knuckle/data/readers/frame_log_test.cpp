// SPDX-License-Identifier: Apache-2.0
#include "knuckle/data/readers/frame_log.h"

#include <algorithm>

#include "knuckle/core/parallel.h"
#include "knuckle/core/testing.h"
#include "knuckle/core/text_file.h"
#include "knuckle/data/readers/data_testing.h"

namespace fs = std::filesystem;

namespace knuckle {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using testing::error_of;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

std::vector<std::uint8_t> content_of(std::int64_t index) {
  return std::vector<std::uint8_t>(static_cast<std::size_t>(10 + index % 7),
                                   static_cast<std::uint8_t>(index));
}

std::vector<std::int64_t> sorted_indices(const FrameLog& log) {
  std::vector<std::int64_t> indices = log.indices();
  std::ranges::sort(indices);
  return indices;
}

class FrameLogTest : public ::testing::Test {
 protected:
  testing::TemporaryFolder folder;
  fs::path path = folder / "frames.log";
};

TEST_F(FrameLogTest, KeepsWhatManyThreadsBringAndHandsItBack) {
  FrameLog log(path, "run");
  parallel_for(300, [&](std::int64_t i) { log.append(i, content_of(i)); });
  EXPECT_EQ(log.indices().size(), 300u);
  for (std::int64_t i = 0; i < 300; ++i) EXPECT_EQ(log.read(i), content_of(i));
}

TEST_F(FrameLogTest, AFrameThatItLacksIsNamed) {
  FrameLog log(path, "run");
  for (const std::int64_t index : {2, 5}) log.append(index, content_of(index));
  for (const std::int64_t index : {0, 3, 6}) {
    EXPECT_THAT(error_of([&] { log.read(index); }),
                AllOf(HasSubstr("frames.log"), HasSubstr(fmt::format("frame {} is not in it", index))));
  }
}

TEST_F(FrameLogTest, CutAnywhereItKeepsTheRecordsThatAreWhole) {
  {
    FrameLog log(path, "run");
    for (const int i : {4, 2, 9}) log.append(i, content_of(i));
  }
  const std::string whole = read_text_file(path);
  std::vector<std::size_t> kept_before;
  for (std::size_t bytes = 0; bytes <= whole.size(); ++bytes) {
    write_text_file(path, whole.substr(0, bytes));
    FrameLog log(path, "run");
    const std::vector<std::int64_t> indices = sorted_indices(log);
    for (const std::int64_t index : indices) EXPECT_EQ(log.read(index), content_of(index));
    kept_before.push_back(indices.size());
    log.append(5, content_of(5));
    EXPECT_EQ(log.read(5), content_of(5));
  }
  EXPECT_TRUE(std::ranges::is_sorted(kept_before));
  EXPECT_EQ(kept_before.front(), 0u);
  EXPECT_EQ(kept_before.back(), 3u);
}

TEST_F(FrameLogTest, WhatFollowsADamagedByteIsDropped) {
  {
    FrameLog log(path, "run");
    for (const int i : {0, 1, 2}) log.append(i, content_of(i));
  }
  std::string bytes = read_text_file(path);
  bytes[bytes.rfind(std::string(8, '\1'))] ^= 4;  // in the content of frame 1
  write_text_file(path, bytes);
  {
    FrameLog log(path, "run");
    EXPECT_THAT(sorted_indices(log), ElementsAre(0));
    log.append(1, content_of(1));
  }
  EXPECT_THAT(sorted_indices(FrameLog(path, "run")), ElementsAre(0, 1));
}

TEST_F(FrameLogTest, ARecordThatClaimsMoreThanThereIsIsDropped) {
  { FrameLog(path, "run").append(0, content_of(0)); }
  std::string bytes = read_text_file(path);
  const std::uint64_t size[] = {~std::uint64_t{0}};
  bytes.append(8, '\1').append(reinterpret_cast<const char*>(size), 8).append(40, 'x');
  write_text_file(path, bytes);
  EXPECT_THAT(sorted_indices(FrameLog(path, "run")), ElementsAre(0));
}

TEST_F(FrameLogTest, AnotherRunsIsRefusedAndNotTouched) {
  { FrameLog(path, "run").append(3, content_of(3)); }
  const std::string before = read_text_file(path);
  for (const std::string identity : {"ruN", "run 2", ""}) {
    EXPECT_THAT(error_of([&] { FrameLog(path, identity); }),
                AllOf(HasSubstr("frames.log"), HasSubstr("another manifest")));
  }
  EXPECT_EQ(read_text_file(path), before);
}

TEST_F(FrameLogTest, AForeignFileIsBegunAnew) {
  testing::put_file(path, "something else that was left here, long ago");
  EXPECT_THAT(FrameLog(path, "run").indices(), IsEmpty());
}

TEST_F(FrameLogTest, AFrameThatIsNotInItIsNamed) {
  FrameLog log(path, "run");
  EXPECT_THAT(error_of([&] { log.read(0); }), HasSubstr("frames.log: frame 0 is not in it"));
  for (const int i : {2, 4}) log.append(i, content_of(i));
  for (const int i : {1, 3, 5})
    EXPECT_THAT(error_of([&] { log.read(i); }),
                HasSubstr(fmt::format("frames.log: frame {} is not in it", i)));
}

TEST_F(FrameLogTest, WhatWasCutMeanwhileIsNotReadBack) {
  FrameLog log(path, "run");
  log.append(0, content_of(0));
  fs::resize_file(path, 30);
  EXPECT_THAT(error_of([&] { log.read(0); }), HasSubstr("frames.log: frame 0 cannot be read back"));
}

TEST_F(FrameLogTest, WhatCannotBeWrittenIsNamed) {
  fs::create_directory(path);
  EXPECT_THAT(error_of([&] { FrameLog(path, "run"); }),
              HasSubstr("frames.log: cannot write: Is a directory"));
}

TEST_F(FrameLogTest, OneRunAtATime) {
  const FrameLog log(path, "run");
  EXPECT_THAT(error_of([&] { FrameLog(path, "run"); }), HasSubstr("frames.log: another run is writing it"));
}

}  // namespace
}  // namespace knuckle
