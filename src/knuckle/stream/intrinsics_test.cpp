// SPDX-License-Identifier: Apache-2.0
#include "knuckle/stream/intrinsics.h"

#include <cmath>
#include <numbers>

#include "knuckle/core/testing.h"
#include "knuckle/storage/file_io.h"

namespace knuckle {
namespace {

using ::testing::AllOf;
using testing::error_of;
using ::testing::HasSubstr;

Intrinsics found(const IntrinsicsOptions& options, std::optional<Intrinsics> reported = {},
                 UnknownIntrinsics unknown = UnknownIntrinsics::refuse) {
  return find_intrinsics(options, std::move(reported), 640, 480, unknown, "v4l2:/dev/video2");
}

TEST(Intrinsics, TheOuterEdgesOfTheImageSpanTheFieldOfView) {
  const Camera camera = camera_of_field_of_view(640, 480, 87.0);
  const double left = std::atan((-0.5 - camera.cx) / camera.fx);
  const double right = std::atan((639.5 - camera.cx) / camera.fx);
  EXPECT_NEAR((right - left) * 180.0 / std::numbers::pi, 87.0, 1e-9);
  EXPECT_DOUBLE_EQ(-left, right);
  EXPECT_DOUBLE_EQ(camera.cy, 239.5);
}

TEST(Intrinsics, WhatIsSaidCountsMoreThanWhatTheDeviceReports) {
  const Intrinsics reported{camera_of_field_of_view(640, 480, 58.0), "reported by the device"};
  EXPECT_EQ(found({}, reported).camera, reported.camera);
  EXPECT_EQ(found({}, reported).origin, "reported by the device");
  EXPECT_EQ(found({.fov_deg = 70.0}, reported).camera, camera_of_field_of_view(640, 480, 70.0));
}

TEST(Intrinsics, AFileSaysThemAndHasToFit) {
  const testing::TemporaryFolder folder;
  const auto file = [&](int width, int height = 480) {
    write_text_file(
        folder / "c.toml",
        fmt::format("[camera]\nwidth={}\nheight={}\nfx=500\nfy=501\ncx=320\ncy=240\n", width, height));
    return IntrinsicsOptions{.camera = (folder / "c.toml").string()};
  };
  EXPECT_EQ(found(file(640)).camera.fy, 501.0);
  EXPECT_THAT(found(file(640)).origin, HasSubstr("c.toml"));
  EXPECT_THAT(error_of([&] { found(file(848)); }),
              AllOf(HasSubstr("v4l2:/dev/video2: sends images of 640x480"), HasSubstr("c.toml has 848x480")));
  EXPECT_THAT(error_of([&] { found(file(640, 360)); }), HasSubstr("c.toml has 640x360"));
  EXPECT_THAT(error_of([&] { found({.camera = "c.toml", .fov_deg = 60.0}); }), HasSubstr("leave one out"));
  EXPECT_THAT(error_of([&] { found({.camera = "none.toml"}); }), HasSubstr("none.toml"));
}

TEST(Intrinsics, WithoutAnyTheErrorSaysWhatToDo) {
  EXPECT_THAT(error_of([] { found({}); }), AllOf(HasSubstr("v4l2:/dev/video2: its intrinsics are not known"),
                                                 HasSubstr("?camera=FILE.toml"), HasSubstr("?fov_deg=")));
  EXPECT_EQ(found({}, std::nullopt, UnknownIntrinsics::guess).origin, "");
}

}  // namespace
}  // namespace knuckle
