// SPDX-License-Identifier: Apache-2.0
#include "knuckle/prepare/source_fingerprint.h"

#include <array>
#include <chrono>

#include "knuckle/core/testing.h"
#include "knuckle/core/testing_variable.h"
#include "knuckle/hand/body_file.h"
#include "knuckle/hand/testing_body.h"
#include "knuckle/storage/file_io.h"
#include "knuckle/synth/makehuman/makehuman_import.h"

namespace knuckle {
namespace {

namespace fs = std::filesystem;

class SourceFingerprintTest : public ::testing::Test {
 protected:
  void SetUp() override {
    make_folder(folder_ / "set/depth");
    write_text_file(folder_ / "set/dataset.toml", "a");
    write_text_file(folder_ / "set/depth/0.png", "image");
  }

  std::string of(const std::string& settings = "") const {
    return source_fingerprint("folder:" + (folder_ / "set").string() + settings);
  }

  testing::TemporaryFolder folder_;
};

TEST_F(SourceFingerprintTest, ItChangesWithFilesSelectionAndSettings) {
  const std::string before = of();
  EXPECT_EQ(of(), before);
  EXPECT_NE(of("?count=1"), before);
  EXPECT_NE(of("?view=2"), before);
  const auto written = fs::last_write_time(folder_ / "set/depth/0.png");
  fs::last_write_time(folder_ / "set/depth/0.png", written + std::chrono::seconds(1));
  EXPECT_NE(of(), before);
  fs::last_write_time(folder_ / "set/depth/0.png", written);
  EXPECT_EQ(of(), before);
  write_text_file(folder_ / "set/depth/1.png", "image");
  EXPECT_NE(of(), before);
}

TEST_F(SourceFingerprintTest, WhereTheSetLiesAndWhatIsWrittenIntoItDoNotMatter) {
  const std::string before = of();
  write_text_file(folder_ / "set/poses.txt.partial", "1 2 3");
  write_text_file(folder_ / "set/.temporary", "1 2 3");
  const std::array except{folder_ / "set/poses.txt.partial"};
  EXPECT_EQ(source_fingerprint("folder:" + (folder_ / "set").string(), except), before);
  EXPECT_NE(of(), before);
  fs::rename(folder_ / "set", folder_ / "moved");
  fs::remove(folder_ / "moved/poses.txt.partial");
  EXPECT_EQ(source_fingerprint("folder:" + (folder_ / "moved").string()), before);
}

TEST_F(SourceFingerprintTest, OfASyntheticSourceTheManifestCounts) {
  const auto of_manifest = [&](const std::string& text) {
    write_text_file(folder_ / "m.toml", text);
    return source_fingerprint("synthetic:" + (folder_ / "m.toml").string());
  };
  const std::string one = of_manifest("frames = 3\nseed = 1\n");
  EXPECT_EQ(of_manifest("# again\nframes = 3\nseed = 1\n"), one);
  EXPECT_NE(of_manifest("frames = 3\nseed = 2\n"), one);
}

TEST_F(SourceFingerprintTest, OfASyntheticSourceTheBodyCounts) {
  write_text_file(folder_ / "m.toml", "frames = 3\n[body]\nfile = 'body.model'\n");
  const auto with_body = [&](const std::string& content) {
    write_text_file(folder_ / "body.model", content);
    return source_fingerprint("synthetic:" + (folder_ / "m.toml").string());
  };
  EXPECT_NE(with_body("one body"), with_body("another body"));
}

TEST_F(SourceFingerprintTest, OfASyntheticSourceWithoutABodyOfItsOwnMakeHumansCounts) {
  write_text_file(folder_ / "m.toml", "frames = 3\n");
  const testing::ChangedVariable package("KNUCKLE_MAKEHUMAN", folder_.path().string());
  const auto with_body = [&](const Body& body) {
    save_body(body, kept_makehuman_body(folder_.path()));
    return source_fingerprint("synthetic:" + (folder_ / "m.toml").string());
  };
  Body body = testing::box_hand_body();
  const std::string one = with_body(body);
  EXPECT_EQ(with_body(body), one);
  body.v_template[0].x() += 1.0f;
  EXPECT_NE(with_body(body), one);
}

TEST_F(SourceFingerprintTest, WhatIsMissingIsNamed) {
  EXPECT_THAT(testing::error_of([] { source_fingerprint("h5:none.h5"); }), ::testing::HasSubstr("none.h5"));
}

}  // namespace
}  // namespace knuckle
