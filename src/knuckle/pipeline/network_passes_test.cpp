// SPDX-License-Identifier: Apache-2.0
// A second look is a look around the joints that the first one found.
#include "knuckle/core/testing.h"
#include "knuckle/net/net_testing.h"
#include "knuckle/net/network_file.h"
#include "knuckle/net/pose_network.h"
#include "knuckle/pipeline/pipeline.h"
#include "knuckle/storage/file_io.h"

namespace knuckle {
namespace {

/// A slanted slanted_plate of 80 mm, half a metre away.
Frame slanted_plate() {
  Frame frame;
  frame.camera.width = 320;
  frame.camera.height = 240;
  frame.camera.fx = frame.camera.fy = 240.0;
  frame.camera.cx = 160.0;
  frame.camera.cy = 120.0;
  frame.depth_mm = Image<float>(320, 240);
  for (int row = 100; row < 140; ++row) {
    for (int column = 140; column < 180; ++column) {
      frame.depth_mm(column, row) = static_cast<float>(500 + (column - 160));
    }
  }
  return frame;
}

ImagePoint mean_of(const HandPose& pose) {
  ImagePoint mean{0.0, 0.0, 0.0};
  const auto count = static_cast<double>(pose.joints.size());
  for (const ImagePoint& joint : pose.joints) {
    mean = {mean.u + joint.u / count, mean.v + joint.v / count, mean.depth_mm + joint.depth_mm / count};
  }
  return mean;
}

class NetworkPasses : public ::testing::Test {
 protected:
  /// What these weights see lies beside the middle of the first look.
  NetworkPasses() { save_network_weights(folder_ / "small.pt", random_weights(testing::small_network(), 2)); }

  FrameEstimate estimate(int passes) const {
    write_text_file(folder_ / "p.toml", fmt::format("[hand]\nsure_confidence = 0.0\n[estimator]\nmethod = "
                                                    "\"dense\"\nmodel = \"small.pt\"\npasses = {}\n",
                                                    passes));
    return Pipeline::load(folder_ / "p.toml").estimate(slanted_plate());
  }

  testing::TemporaryFolder folder_;
};

TEST_F(NetworkPasses, TheSecondLooksAroundTheJointsOfTheFirst) {
  const FrameEstimate once = estimate(1);
  const FrameEstimate twice = estimate(2);
  ASSERT_EQ(once.hands.size(), 1u) << once.status;
  const PoseNetwork network(folder_ / "small.pt");
  const auto patch = extract_cube(slanted_plate(), mean_of(once.hands[0].pose), testing::kTestCube);
  ASSERT_TRUE(patch);
  const NetworkPrediction expected = network.predict(patch->pixels);
  for (std::size_t j = 0; j < expected.joints.size(); ++j) {
    const ImagePoint at = patch->geometry.to_image(expected.joints[j]);
    EXPECT_NEAR(twice.hands[0].pose.joints[j].u, at.u, 1e-9);
    EXPECT_NEAR(twice.hands[0].pose.joints[j].depth_mm, at.depth_mm, 1e-9);
  }
  EXPECT_NE(once.hands[0].pose.joints[0].u, twice.hands[0].pose.joints[0].u);
  EXPECT_EQ(twice.hands[0].pose.confidence.size(), 14u);
}

}  // namespace
}  // namespace knuckle
