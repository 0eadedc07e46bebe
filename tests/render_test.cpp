// SPDX-License-Identifier: Apache-2.0
// `render` as a user types it.
#include "verbs.h"

#include "knuckle/core/text_file.h"
#include "knuckle/data/readers/image_io.h"
#include "knuckle/storage/file_io.h"

namespace knuckle::testing {
namespace {

using ::testing::HasSubstr;

TEST_F(VerbsTest, WhatIsRenderedReadsBackInEveryFormat) {
  for (const std::string format : {"h5", "folder", "icg"}) {
    const std::string out = path("set_" + format);
    ASSERT_THAT(run_program({"render", "--manifest", "manifests/demo.toml", "--format", format, "--out", out,
                             "--first", "2", "--count", "3"}),
                Succeeded());
    const ProgramRun run = run_program({"inspect", "--source", format + ":" + out, "--frame", "2"});
    ASSERT_THAT(run, Succeeded());
    EXPECT_THAT(run.out, HasSubstr("frames       3"));
    EXPECT_THAT(run.out, HasSubstr("joints known"));
  }
}

TEST_F(VerbsTest, RenderWritesItsManifestWithAllDefaults) {
  write_text_file(path("short.toml"), "frames = 2\nseed = 4\n[body]\npeople = 1\n");
  ASSERT_THAT(run_program({"render", "--manifest", path("short.toml"), "--out", path("a.h5")}), Succeeded());
  const std::string resolved = read_text_file(path("a.h5.options.toml"));
  EXPECT_THAT(resolved, HasSubstr("seed = 4"));
  EXPECT_THAT(resolved, HasSubstr("sigma_mm = 3.0"));
  EXPECT_THAT(resolved, HasSubstr("wrist_deg = "));
  const auto frame_of = [&](const std::string& manifest, const std::string& png) {
    EXPECT_THAT(
        run_program({"inspect", "--source", "synthetic:" + manifest, "--frame", "1", "--png", path(png)}),
        Succeeded());
    return read_text_file(path(png));
  };
  EXPECT_TRUE(frame_of(path("short.toml"), "a.png") == frame_of(path("a.h5.options.toml"), "b.png"))
      << "the resolved manifest makes other frames";
}

TEST_F(VerbsTest, RenderMakesAContactSheetAloneOrBesideItsFrames) {
  const auto sheet = [&](const std::vector<std::string>& more) {
    std::vector<std::string> arguments = {
        "render",    "--manifest", "manifests/demo.toml", "--contact-sheet", path("sheet.png"),
        "--columns", "3"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    EXPECT_THAT(run_program(arguments), Succeeded());
    const Image<Rgb> picture = read_png_rgb(path("sheet.png"));
    return std::pair(picture.width(), picture.height());
  };
  EXPECT_EQ(sheet({"--count", "5", "--first", "3"}), std::pair(1074, 318));
  EXPECT_THAT(entries_of(folder_.path()), ::testing::ElementsAre("sheet.png"));
  EXPECT_EQ(sheet({"--count", "5", "--tiles", "2", "--out", path("a.h5")}), std::pair(718, 162));
  EXPECT_THAT(run_program({"inspect", "--source", "h5:" + path("a.h5")}), Succeeded());
  EXPECT_EQ(run_program({"render", "--manifest", "manifests/demo.toml"}).status, 2) << "nothing to make";
}

}  // namespace
}  // namespace knuckle::testing
