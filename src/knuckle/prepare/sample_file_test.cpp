// SPDX-License-Identifier: Apache-2.0
#include "knuckle/prepare/sample_file.h"

#include <cmath>

#include "knuckle/core/testing.h"
#include "knuckle/storage/content_hash.h"
#include "knuckle/storage/hdf5/hdf5_writer.h"

namespace knuckle {
namespace {

using ::testing::AllOf;
using testing::error_of;
using ::testing::HasSubstr;
using Shape = std::vector<std::uint64_t>;

/// The arrays of a file of two samples, which are written by hand.
struct Parts {
  Shape codes = {2, 4, 4};
  Shape joints = {2, 14, 3};
  Shape centres = {2, 3};
  Shape sums = {};  ///< empty: none are written
  std::vector<double> patch = {4.0, 250.0};
  std::vector<double> frames = {5.0, 2.0, 1.0};
  float joint = 0.5F;
};

std::size_t count_of(const Shape& shape) {
  std::size_t count = 1;
  for (const std::uint64_t size : shape) count *= size;
  return count;
}

class SampleFileTest : public ::testing::Test {
 protected:
  void write(const Parts& parts) const {
    Hdf5Writer file = Hdf5Writer::create(path_);
    file.set_attribute("format", "knuckle-samples");
    file.set_attribute("version", 1.0);
    file.set_attribute("inputs", text_hash(inputs_.text()));
    file.set_attribute("patch", parts.patch);
    file.set_attribute("frames", parts.frames);
    file.write("codes", parts.codes, std::vector<std::uint8_t>(count_of(parts.codes)).data());
    file.write("joints", parts.joints, std::vector<float>(count_of(parts.joints), parts.joint).data());
    file.write("centres_mm", parts.centres, std::vector<double>(count_of(parts.centres), 500.0).data());
    if (!parts.sums.empty())
      file.write("sums", parts.sums, std::vector<std::uint64_t>(count_of(parts.sums)).data());
    file.close();
  }

  std::string fault(const std::function<void(Parts&)>& change) const {
    Parts parts;
    change(parts);
    write(parts);
    const std::string error = error_of([&] { SampleFile(path_, inputs_); });
    EXPECT_THAT(error, HasSubstr("samples.h5"));
    return error;
  }

  testing::TemporaryFolder folder_;
  std::filesystem::path path_ = folder_ / "samples.h5";
  Inputs inputs_;
};

TEST_F(SampleFileTest, AFileWithoutSumsIsRead) {
  write({});
  const NetworkSamples read = read_samples(path_, inputs_);
  EXPECT_EQ(read.samples.size(), 2);
  EXPECT_EQ(read.frames.total, 5);
}

TEST_F(SampleFileTest, ArraysThatDoNotFitTogetherAreRefused) {
  const auto misfit = AllOf(HasSubstr("the shapes of its arrays do not fit together"), HasSubstr("remove"));
  EXPECT_THAT(fault([](Parts& parts) { parts.codes = {2, 16}; }), misfit);
  EXPECT_THAT(fault([](Parts& parts) { parts.codes = {2, 4, 5}; }), misfit);
  EXPECT_THAT(fault([](Parts& parts) { parts.codes = {3, 4, 4}; }), misfit);
  EXPECT_THAT(fault([](Parts& parts) { parts.joints = {2, 14, 2}; }), misfit);
  EXPECT_THAT(fault([](Parts& parts) { parts.joints = {2, 42}; }), misfit);
  EXPECT_THAT(fault([](Parts& parts) { parts.centres = {2, 4}; }), misfit);
  EXPECT_THAT(fault([](Parts& parts) { parts.sums = {3}; }), misfit);
  EXPECT_THAT(fault([](Parts& parts) { parts.patch = {4.0}; }), misfit);
}

TEST_F(SampleFileTest, NumbersOutOfRangeAreRefused) {
  const auto out_of_range = HasSubstr("its patch or its joints are out of range");
  EXPECT_THAT(fault([](Parts& parts) { parts.patch[0] = 0.0; }), out_of_range);
  EXPECT_THAT(fault([](Parts& parts) { parts.patch[1] = std::nan(""); }), out_of_range);
  EXPECT_THAT(fault([](Parts& parts) { parts.joints[1] = 5000; }), out_of_range);
  EXPECT_THAT(fault([](Parts& parts) { parts.joint = -INFINITY; }),
              HasSubstr("a joint is infinitely far away"));
  EXPECT_THAT(fault([](Parts& parts) {
                parts.frames = {5.0, 2.0};
              }),
              HasSubstr("`frames` has 2 numbers, expected 3 numbers of frames"));
  EXPECT_THAT(fault([](Parts& parts) { parts.frames[1] = -1.0; }), HasSubstr("expected 3 numbers of frames"));
  EXPECT_THAT(fault([](Parts& parts) { parts.frames[2] = std::nan(""); }),
              HasSubstr("expected 3 numbers of frames"));
}

TEST_F(SampleFileTest, SamplesAreReadToRoomOfTheirSizes) {
  write({});
  const SampleFile file(path_, inputs_);
  CubeSamples same = file.room_for(1);
  const std::vector<std::int64_t> second = {1};
  EXPECT_NO_THROW(file.read(second, same, 0));
  CubeSamples other(1, 14, {4, 200.0}, 4);
  EXPECT_THAT(error_of([&] { file.read(second, other, 0); }),
              AllOf(HasSubstr("samples.h5"), HasSubstr("other sizes than those of other files")));
}

}  // namespace
}  // namespace knuckle
