// SPDX-License-Identifier: Apache-2.0
#include "knuckle/training/configured_samples.h"

#include <algorithm>
#include <cmath>

#include "knuckle/core/testing.h"
#include "knuckle/core/text_file.h"
#include "knuckle/data/writers/folder_writer.h"
#include "knuckle/storage/file_io.h"
#include "knuckle/training/training_check.h"

namespace knuckle {
namespace {

using ::testing::AllOf;
using ::testing::Contains;
using ::testing::ElementsAre;
using testing::error_of;
using ::testing::HasSubstr;
using ::testing::Not;

/// A plate of a hand's size at this depth, and three joints on it.
Frame plate_frame(double depth_mm) {
  Frame frame;
  frame.camera = {.width = 80, .height = 60, .fx = 100.0, .fy = 100.0, .cx = 39.5, .cy = 29.5};
  frame.depth_mm = Image<float>(80, 60);
  for (int row = 20; row < 40; ++row) {
    for (int column = 30; column < 50; ++column) frame.depth_mm(column, row) = static_cast<float>(depth_mm);
  }
  return frame;
}

class ConfiguredSamplesTest : public ::testing::Test {
 protected:
  /// A set of frames NAME whose first is `depth_mm` away, each next 10 mm more, two a sequence.
  void write_set(const std::string& name, int count, double depth_mm, const std::string& convention) const {
    FrameWriterOptions options;
    options.count = count;
    FolderWriter writer(folder_ / name, options);
    for (int i = 0; i < count; ++i) {
      Frame frame = plate_frame(depth_mm + 10.0 * i);
      frame.sequence = i / 2;
      frame.truth = HandPose::missing(convention_from_name(convention));
      for (std::size_t j = 0; j < 3; ++j)
        frame.truth->joints[j] = {36.0 + 3.0 * static_cast<double>(j), 30.0, depth_mm + 10.0 * i};
      writer.write(i, frame);
    }
    writer.finish();
  }

  NetworkTrainingConfig config(const std::string& sources) const {
    write_text_file(folder_ / "train.toml",
                    sources +
                        "[patch]\nmode = 'cube'\nsize_px = 32\n[samples]\ncrop_px = 48\ncentre = 'joints'\n"
                        "[network]\nconvention = 'mediapipe21'\n[training]\nbatch_size = 4\n");
    return NetworkTrainingConfig::load(folder_ / "train.toml");
  }

  static std::vector<double> depths_of(const NetworkSamples& made) {
    std::vector<double> depths;
    for (std::int64_t i = 0; i < made.samples.size(); ++i)
      depths.push_back(std::round(made.samples.sample(i).centre_mm.z()));
    return depths;
  }

  testing::TemporaryFolder folder_;
};

TEST_F(ConfiguredSamplesTest, AreThoseOfEachSetAndOfWhatTheyHoldOut) {
  write_set("mine", 4, 500.0, "mediapipe21");
  write_set("other", 2, 700.0, "icg20");
  const auto made =
      configured_samples(config("[[source]]\nsource = 'folder:mine'\nholdout = 0.5\nweight = 3\n"
                                "[[source]]\nsource = 'folder:other'\n"),
                         {});
  ASSERT_EQ(made.sets.size(), 2u);
  EXPECT_EQ(made.sets[0].weight, 3.0);
  EXPECT_THAT(depths_of(made.sets[1].hands), ElementsAre(700.0, 710.0));
  std::vector<double> mine = depths_of(made.sets[0].hands);
  for (const double depth : depths_of(made.validation)) mine.push_back(depth);
  EXPECT_THAT(mine, ::testing::UnorderedElementsAre(500.0, 510.0, 520.0, 530.0));
  EXPECT_EQ(made.validation.samples.size(), 2);
  EXPECT_EQ(made.frames().total, 4);
}

TEST_F(ConfiguredSamplesTest, ValidateOnWhatSeveralSetsHoldOut) {
  write_set("mine", 4, 500.0, "mediapipe21");
  write_set("other", 4, 700.0, "mediapipe21");
  const auto made = configured_samples(config("[[source]]\nsource = 'folder:mine'\nholdout = 0.5\n"
                                              "[[source]]\nsource = 'folder:other'\nholdout = 0.5\n"),
                                       {});
  const std::vector<double> depths = depths_of(made.validation);
  ASSERT_EQ(depths.size(), 4u);
  EXPECT_LT(std::max(depths[0], depths[1]), 600.0);
  EXPECT_GT(std::min(depths[2], depths[3]), 600.0);
}

TEST_F(ConfiguredSamplesTest, KnowWhichLandmarksNoSetLabels) {
  write_set("mine", 2, 500.0, "mediapipe21");  // wrist, thumb_cmc, thumb_mcp
  write_set("other", 2, 700.0, "icg20");       // palm, thumb_mcp, thumb_ip
  const auto read = config(
      "validation = 'folder:mine'\n[[source]]\nsource = 'folder:mine'\n"
      "[[source]]\nsource = 'folder:other'\n");
  const std::vector<Landmark> unknown = unknown_landmarks(read, configured_samples(read, {}));
  EXPECT_EQ(unknown.size(), 17u);
  EXPECT_THAT(unknown, AllOf(Not(Contains(Landmark::wrist)), Not(Contains(Landmark::thumb_ip)),
                             Contains(Landmark::thumb_tip)));
  const TrainingCheck check = check_network_training(read);
  EXPECT_THAT(check.text,
              AllOf(HasSubstr("mine: 2 frames, weight 1, 50.0% of the samples"),
                    HasSubstr("landmarks: 3 of 21 labelled, not thumb_ip"),
                    HasSubstr("no set labels thumb_tip"), HasSubstr("begins with random weights")));
  EXPECT_GT(check.sheet.width(), 8 * 192);
  EXPECT_GT(check.sheet.height(), 6 * 192);
}

TEST_F(ConfiguredSamplesTest, ASetThatCannotBeUsedIsNamed) {
  write_set("mine", 4, 500.0, "mediapipe21");
  write_set("points", 2, 500.0, "icvl16");
  make_folder(folder_ / "empty/depth");
  write_text_file(folder_ / "empty/dataset.toml", read_text_file(folder_ / "mine/dataset.toml"));
  const auto check = [&](const std::string& second) {
    check_sources(config(
        "[[source]]\nsource = 'folder:mine'\nholdout = 0.5\n[[source]]\nsource = 'folder:" + second + "'\n"));
  };
  EXPECT_NO_THROW(check("mine"));
  EXPECT_THAT(error_of([&] { check("empty"); }), HasSubstr("empty"));
  EXPECT_THAT(error_of([&] { check("none"); }), HasSubstr("none"));
  EXPECT_THAT(error_of([&] { check("points"); }), AllOf(HasSubstr("folder:"), HasSubstr("points"),
                                                        HasSubstr("icvl16"), HasSubstr("mediapipe21")));
}

TEST_F(ConfiguredSamplesTest, AreStreamedFromTheCacheOrFromTheirFrames) {
  write_set("mine", 4, 500.0, "mediapipe21");
  write_set("other", 2, 700.0, "icg20");
  const auto read = config(
      "[[source]]\nsource = 'folder:mine'\nholdout = 0.5\nweight = 3\n"
      "[[source]]\nsource = 'folder:other'\nmost = 1\n");
  const ConfiguredSamples expected = configured_samples(read, {});
  for (const std::filesystem::path& cache : {folder_ / "cache", std::filesystem::path()}) {
    const ConfiguredSamples made = streamed_samples(read, cache);
    EXPECT_TRUE(made.sets.empty());
    ASSERT_EQ(made.streams.size(), 2u);
    EXPECT_EQ(made.streams[0].weight, 3.0);
    EXPECT_EQ(made.frames().total, expected.frames().total);
    EXPECT_EQ(depths_of(made.validation), depths_of(expected.validation));
    EXPECT_EQ(unknown_landmarks(read, made), unknown_landmarks(read, expected));
    for (std::size_t i = 0; i < 2; ++i) {
      const CubeSamples& samples = expected.sets[i].hands.samples;
      const SampleStream& stream = *made.streams[i].hands;
      ASSERT_EQ(stream.size(), samples.size());
      CubeSamples first = stream.room_for(1);
      stream.fetch(std::vector<std::int64_t>{0}, first, 0);
      first.finish();
      EXPECT_TRUE(std::ranges::equal(first.sample(0).codes, samples.sample(0).codes));
    }
  }
}

TEST_F(ConfiguredSamplesTest, TakeNoMoreMemoryThanTheyMay) {
  write_set("mine", 4, 500.0, "mediapipe21");
  write_set("other", 2, 500.0, "mediapipe21");
  auto read = config("source = 'folder:mine'\nvalidation = 'folder:other'\n");
  const auto bytes = static_cast<double>(CubeSamples::bytes(1, 21, 48));
  read.samples.memory_gb = 5.5 * bytes / 1e9;
  EXPECT_THAT(error_of([&] { check_sources(read); }),
              AllOf(HasSubstr("6 samples"), HasSubstr("stream = true")));
  read.samples.stream = true;
  const auto too_little = AllOf(HasSubstr("2 samples of the validation"), HasSubstr("two batches of 4"));
  EXPECT_THAT(error_of([&] { check_sources(read); }), too_little);
  read.samples.memory_gb = 10.5 * bytes / 1e9;
  EXPECT_NO_THROW(check_sources(read)) << "not for all at a time";
  const ConfiguredSamples made = streamed_samples(read, {});
  const CubeSamples& validation = made.validation.samples;
  EXPECT_EQ(streaming_options(read, validation).most_at_once, 4) << "twice, and the validation's 2";
  read.samples.memory_gb = 1000.0;
  EXPECT_EQ(streaming_options(read, validation).most_at_once, 16384);
  EXPECT_EQ(streaming_options(read, validation).window, 65536);
  read.samples.memory_gb = 9.5 * bytes / 1e9;
  EXPECT_THAT(error_of([&] { streaming_options(read, validation); }), too_little);
}

TEST_F(ConfiguredSamplesTest, NeedADetectorThatFindsThings) {
  write_set("mine", 4, 500.0, "mediapipe21");
  EXPECT_THAT(
      error_of([&] { config("[[source]]\nsource = 'folder:mine'\nholdout = 0.5\nmost_things = 5\n"); }),
      AllOf(HasSubstr("train.toml: most_things is 5"), HasSubstr("no 'detector' is named")));
}

TEST_F(ConfiguredSamplesTest, NeedFramesToValidateOn) {
  write_set("mine", 4, 500.0, "mediapipe21");
  const auto fault = [&](const std::string& sources) { return error_of([&] { config(sources); }); };
  EXPECT_THAT(fault("source = 'folder:mine'\n"),
              AllOf(HasSubstr("validation: is missing"), HasSubstr("holdout")));
  EXPECT_THAT(fault("source = 'folder:mine'\nholdout = 0.5\nvalidation = 'folder:mine'\n"),
              AllOf(HasSubstr("validation: stands beside"), HasSubstr("train.toml:3")));
  EXPECT_NO_THROW(config("source = 'folder:mine'\nholdout = 0.5\n"));
}

}  // namespace
}  // namespace knuckle
