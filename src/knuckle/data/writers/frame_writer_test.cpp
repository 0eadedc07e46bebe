// SPDX-License-Identifier: Apache-2.0
// What all writers have in common.
#include "knuckle/data/writers/frame_writer.h"

#include <csignal>
#include <memory>

#include <sys/resource.h>

#include "knuckle/core/parallel.h"
#include "knuckle/core/testing.h"
#include "knuckle/data/readers/data_testing.h"
#include "knuckle/data/readers/open_dataset.h"
#include "knuckle/data/writers/index_set.h"

namespace fs = std::filesystem;

namespace knuckle {
namespace {

using ::testing::AllOf;
using testing::error_of;
using ::testing::HasSubstr;
using testing::noise_frame;
using testing::small_camera;

FrameWriterOptions four_frames() {
  FrameWriterOptions options;
  options.first = 2;
  options.count = 4;
  return options;
}

Frame frame_number(std::int64_t index) {
  return noise_frame(small_camera(), convention_from_name("icg20"), static_cast<std::uint64_t>(index));
}

/// All names below a folder, to see that nothing half-written stays.
std::vector<std::string> names_below(const fs::path& folder) {
  std::vector<std::string> names;
  for (const auto& entry : fs::recursive_directory_iterator(folder))
    if (entry.is_regular_file()) names.push_back(entry.path().filename());
  return names;
}

struct Writers : ::testing::TestWithParam<std::string_view> {
  std::unique_ptr<FrameWriter> writer(const FrameWriterOptions& options = four_frames()) const {
    return create_frame_writer(GetParam(), path(), options);
  }
  fs::path path() const { return folder / "set"; }

  testing::TemporaryFolder folder;
};

TEST_P(Writers, TheReaderOfTheSameNameReadsThemInOrder) {
  const auto target = writer();
  parallel_for(4, [&](std::int64_t i) { target->write(5 - i, frame_number(5 - i)); });
  target->finish();
  const auto source = open_dataset(fmt::format("{}:{}", GetParam(), path().string()));
  ASSERT_EQ(source->size(), 4);
  for (std::int64_t i = 0; i < 4; ++i)
    testing::expect_near(source->read(i).depth_mm, frame_number(2 + i).depth_mm, 0.0501);
}

TEST_P(Writers, NoReaderTakesAnUnfinishedSet) {
  { writer()->write(2, frame_number(2)); }
  EXPECT_THAT(error_of([&] { open_dataset(fmt::format("{}:{}", GetParam(), path().string())); }),
              HasSubstr(path().string()));
}

TEST_P(Writers, RefuseFramesThatDoNotBelong) {
  const auto target = writer();
  target->write(2, frame_number(2));
  EXPECT_THAT(error_of([&] { target->write(2, frame_number(2)); }), HasSubstr("frame 2 comes twice"));
  EXPECT_THAT(error_of([&] { target->write(1, frame_number(1)); }), HasSubstr("frame 1 is out of range"));
  EXPECT_THAT(error_of([&] { target->write(6, frame_number(6)); }), HasSubstr("frame 6 is out of range"));
  Frame other_camera = frame_number(3);
  other_camera.camera.distortion[0] = 0.01;
  EXPECT_THAT(error_of([&] { target->write(3, other_camera); }), HasSubstr("another camera"));
  Frame no_mask = frame_number(3);
  no_mask.mask = {};
  EXPECT_THAT(error_of([&] { target->write(3, no_mask); }), HasSubstr("other images"));
  Frame small = frame_number(3);
  small.depth_mm = Image<float>(3, 3);
  EXPECT_THAT(error_of([&] { target->write(3, small); }), AllOf(HasSubstr("frame 3"), HasSubstr("3x3")));
}

TEST_P(Writers, MissingFramesAreAnError) {
  const auto target = writer();
  EXPECT_THAT(error_of([&] { target->finish(); }), HasSubstr("no frame was written"));
  target->write(3, frame_number(3));
  EXPECT_THAT(error_of([&] { target->finish(); }), HasSubstr("3 of 4 frames were not written"));
}

TEST_P(Writers, NameAPlaceThatCannotBeWritten) {
  testing::put_file(folder / "file", "in the way");
  EXPECT_THAT(error_of([&] { create_frame_writer(GetParam(), folder / "file" / "set", four_frames()); }),
              HasSubstr((folder / "file").string()));
}

TEST_P(Writers, AFullDiskIsAnErrorAndLeavesNothingHalfWritten) {
  // A limit on the size of files stands for the full disk: a write beyond it fails in the same way.
  rlimit before{};
  ASSERT_EQ(getrlimit(RLIMIT_FSIZE, &before), 0);
  ASSERT_NE(std::signal(SIGXFSZ, SIG_IGN), SIG_ERR);
  std::string message;
  {
    auto target = writer();
    const rlimit tight{600, before.rlim_max};
    ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &tight), 0);
    message = error_of([&] {
      for (std::int64_t i = 2; i < 6; ++i) target->write(i, frame_number(i));
      target->finish();
    });
    target.reset();
    ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &before), 0);
  }
  EXPECT_THAT(message, HasSubstr(path().string()));
  for (const std::string& name : names_below(folder.path())) EXPECT_EQ(name, "set.partial");
}

INSTANTIATE_TEST_SUITE_P(Formats, Writers, ::testing::ValuesIn(frame_writer_formats()),
                         [](const auto& instance) { return std::string(instance.param); });

TEST(FrameWriter, ListsTheFormatsWhereOneIsUnknown) {
  EXPECT_THAT(error_of([] { create_frame_writer("zip", "/tmp/x", {}); }),
              AllOf(HasSubstr("'zip'"), HasSubstr("folder, h5, icg")));
}

TEST(FrameWriter, ChecksItsOptions) {
  FrameWriterOptions options = four_frames();
  options.depth_unit_mm = 0;
  EXPECT_THAT(error_of([&] { create_frame_writer("folder", "/tmp/x", options); }),
              HasSubstr("depth_unit_mm"));
  options = four_frames();
  options.count = -1;
  EXPECT_THAT(error_of([&] { create_frame_writer("h5", "/tmp/x", options); }), HasSubstr("-1 more"));
}

TEST(IndexSet, HoldsWhatCameInAnyOrder) {
  IndexSet set(10);
  EXPECT_TRUE(set.empty());
  for (const std::int64_t index : {12, 10, 14, 11}) EXPECT_TRUE(set.insert(index));
  for (const std::int64_t index : {10, 11, 12, 14}) EXPECT_FALSE(set.insert(index));
  EXPECT_EQ(set.size(), 4);
  for (const std::int64_t index : {9, 13, 15}) EXPECT_FALSE(set.contains(index));
  EXPECT_TRUE(set.insert(13));
  EXPECT_EQ(set.size(), 5);
  for (std::int64_t index = 10; index < 15; ++index) EXPECT_TRUE(set.contains(index));
}

TEST(FrameWriter, DoesNotMixSets) {
  for (const std::string_view format : {"folder", "icg"}) {
    const testing::TemporaryFolder folder;
    {
      const auto writer = create_frame_writer(format, folder / "set", {});
      writer->write(0, frame_number(0));
      writer->finish();
    }
    EXPECT_THAT(error_of([&] { create_frame_writer(format, folder / "set", {}); }),
                HasSubstr("already holds"));
  }
}

}  // namespace
}  // namespace knuckle
