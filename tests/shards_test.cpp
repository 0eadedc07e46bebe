// SPDX-License-Identifier: Apache-2.0
// One data set made in parts, as by many machines, of which some are killed.
#include "program.h"

#include <cstdlib>
#include <map>

#include "knuckle/core/text_file.h"
#include "knuckle/data/readers/h5_source.h"
#include "knuckle/data/writers/h5_writer.h"
#include "knuckle/storage/file_io.h"
#include "knuckle/storage/hdf5/hdf5_file.h"

namespace fs = std::filesystem;

namespace knuckle::testing {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::StartsWith;

constexpr const char* kDemoManifest = "manifests/demo.toml";

class ShardsTest : public ::testing::Test {
 protected:
  void SetUp() override { fs::create_directory(folder_ / "parts"); }

  std::string path(const std::string& name) const { return folder_ / name; }
  std::string part(int number) const { return path("parts/" + std::to_string(number) + ".h5"); }
  std::vector<std::string> rendering(int number, int count) const {
    return {"render", "--manifest", kDemoManifest, "--shard", fmt::format("{}/{}", number, count),
            "--out",  part(number)};
  }
  ProgramRun join(int count) const {
    std::vector<std::string> arguments = {"join", "--out", path("joined.h5")};
    for (int i = count - 1; i >= 0; --i) arguments.push_back(part(i));
    return run_program(arguments);
  }

  TemporaryFolder folder_;
};

TEST_F(ShardsTest, PartsMakeTheBytesOfTheWholeThoughOneIsKilled) {
  ASSERT_THAT(run_program({"render", "--manifest", kDemoManifest, "--out", path("whole.h5")}), Succeeded());
  constexpr int kCount = 3;
  for (const int number : {2, 0, 1}) {
    if (number == 0) {
      const auto has_begun = [&] {
        std::error_code missing;
        return fs::file_size(part(0) + ".partial", missing) > 30000 && !missing;
      };
      EXPECT_EQ(run_program_until(has_begun, rendering(0, kCount)).status, 128 + SIGKILL);
      EXPECT_THAT(join(1), FailedWith("0.h5")) << "a part that is not whole is no part";
    }
    ASSERT_THAT(run_program(rendering(number, kCount)), Succeeded());
  }
  const fs::file_time_type written = fs::last_write_time(part(1));
  const std::string options = part(1) + ".options.toml";
  ASSERT_TRUE(fs::remove(options)) << "as where it was stopped just before";
  const ProgramRun again = run_program(rendering(1, kCount));
  ASSERT_THAT(again, Succeeded());
  EXPECT_THAT(again.out, HasSubstr("was there"));
  EXPECT_EQ(fs::last_write_time(part(1)), written);
  EXPECT_TRUE(fs::exists(options)) << "what is missing beside a part is made";

  const ProgramRun joined = join(kCount);
  ASSERT_THAT(joined, Succeeded());
  EXPECT_THAT(joined.out, HasSubstr("40 frames of 3 parts"));
  EXPECT_TRUE(read_text_file(path("joined.h5")) == read_text_file(path("whole.h5")));

  const auto poses_of = [&](const std::string& source, const std::string& out) {
    EXPECT_THAT(run_program({"estimate", "--source", source, "--pipeline", "pipelines/free_hand.toml",
                             "--out", path(out)}),
                Succeeded());
    return read_text_file(path(out));
  };
  EXPECT_EQ(poses_of("h5:" + path("parts/*.h5"), "a.txt"), poses_of("h5:" + path("whole.h5"), "b.txt"));
}

TEST_F(ShardsTest, WhatIsMissingIsNamedAndMadeAgainAlone) {
  for (const int number : {0, 1, 3}) ASSERT_THAT(run_program(rendering(number, 4)), Succeeded());
  const std::vector<std::string> others = {"join", "--out", path("joined.h5"), part(0), part(1), part(3)};
  EXPECT_THAT(run_program(others), FailedWith("frames 20 to 29 are missing"));
  EXPECT_FALSE(fs::exists(path("joined.h5")));
  ASSERT_THAT(run_program(rendering(2, 4)), Succeeded());
  EXPECT_THAT(join(4), Succeeded());
}

/// What is damaged is set aside and made anew; what is whole is left, whatever else is in the folder.
TEST_F(ShardsTest, ABrokenPartIsMadeAnew) {
  ASSERT_THAT(run_program(rendering(0, 8)), Succeeded());
  const std::string whole = read_text_file(part(0));
  const std::vector<float> joints = Hdf5File::open(part(0)).read<float>("joints_mm").values;
  const std::size_t place = whole.find(reinterpret_cast<const char*>(joints.data()), 0, 66 * sizeof(float));
  ASSERT_NE(place, std::string::npos);
  std::string damaged = whole;
  damaged[place + 5] = static_cast<char>(damaged[place + 5] ^ 1);
  for (const std::string& broken : {damaged, whole.substr(0, whole.size() / 2), std::string("nothing")}) {
    write_text_file(part(0), broken);
    const ProgramRun again = run_program(rendering(0, 8));
    ASSERT_EQ(again.status, 0) << again.error;
    EXPECT_THAT(again.error, AllOf(StartsWith("warning: " + part(0)), HasSubstr("is rendered again")));
    EXPECT_EQ(error_lines(again).size(), 1U);
    EXPECT_THAT(again.out, Not(HasSubstr("was there")));
    EXPECT_TRUE(read_text_file(part(0)) == whole);
    EXPECT_TRUE(read_text_file(part(0) + ".broken") == broken);
  }
}

TEST_F(ShardsTest, APartByAnotherVersionIsRefused) {
  ASSERT_THAT(run_program(rendering(0, 8)), Succeeded());
  const H5Source source(part(0));
  FrameWriterOptions options;
  options.first = source.facts().frames.first;
  options.count = source.facts().frames.count;
  options.part_of = source.facts().part_of;
  options.manifest = source.facts().manifest;
  options.generator = "knuckle 0.1, generator 0";
  {
    H5Writer writer(path("parts/old.h5"), options);
    for (std::int64_t i = 0; i < source.size(); ++i) writer.write(options.first + i, source.read(i));
    writer.finish();
  }
  EXPECT_THAT(source.facts().generator, StartsWith("knuckle "));
  ASSERT_THAT(run_program(rendering(1, 8)), Succeeded());
  EXPECT_THAT(run_program({"join", "--out", path("joined.h5"), path("parts/old.h5"), part(1)}),
              FailedWith("was made by another program"));
  fs::rename(path("parts/old.h5"), part(0));
  EXPECT_THAT(run_program(rendering(0, 8)), FailedWith("was rendered by knuckle 0.1, generator 0, this is"));
  EXPECT_TRUE(fs::exists(part(0)));
}

TEST_F(ShardsTest, PartsOfOtherSetsAreRefused) {
  ASSERT_THAT(run_program(rendering(0, 2)), Succeeded());
  write_text_file(path("other.toml"), read_text_file(kDemoManifest) + "\n# another\n");
  ASSERT_THAT(run_program({"render", "--manifest", path("other.toml"), "--shard", "1/2", "--out", part(1)}),
              Succeeded());
  EXPECT_THAT(join(2), FailedWith("was made from another manifest"));
  // A part that is there, but of another cut, whole or manifest, is not overwritten.
  const std::string before = read_text_file(part(0));
  const std::string frames = std::to_string(H5Source(part(0)).size());
  const auto render_again = [&](const std::string& manifest, const std::vector<std::string>& more) {
    std::vector<std::string> arguments = {"render", "--manifest", manifest, "--out", part(0)};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return run_program(arguments);
  };
  EXPECT_THAT(render_again(kDemoManifest, {"--shard", "0/3"}), FailedWith("0.h5: is another part"));
  EXPECT_THAT(render_again(kDemoManifest, {"--shard", "0/1", "--count", frames}),
              FailedWith("0.h5: is another part, or of another set"))
      << "the same frames";
  EXPECT_THAT(render_again(path("other.toml"), {"--shard", "0/2"}),
              FailedWith("0.h5: is another part, or of another set"));
  EXPECT_TRUE(read_text_file(part(0)) == before);
}

TEST_F(ShardsTest, WrongShardsAreRefused) {
  const auto shard = [&](const std::string& text) {
    return run_program({"render", "--manifest", kDemoManifest, "--shard", text, "--out", part(0)});
  };
  EXPECT_THAT(shard("4/4"), FailedWith("expected I/N"));
  EXPECT_THAT(shard("0/41"), FailedWith("there are 40 frames"));
  EXPECT_THAT(shard("auto"), FailedWith("no task of a Slurm job array"));
  EXPECT_THAT(run_program({"render", "--manifest", kDemoManifest, "--shard", "0/2", "--format", "folder",
                           "--out", path("set")}),
              FailedWith("expected --format h5"));
}

TEST_F(ShardsTest, ATaskOfAnArrayKnowsItsPart) {
  const auto render_as_task = [&](const std::map<std::string, std::string>& variables) {
    for (const auto& [name, value] : variables)
      ::setenv(("SLURM_ARRAY_TASK_" + name).c_str(), value.c_str(), 1);
    const ProgramRun run =
        run_program({"render", "--manifest", kDemoManifest, "--shard", "auto", "--out", part(1)});
    for (const auto& [name, value] : variables) ::unsetenv(("SLURM_ARRAY_TASK_" + name).c_str());
    return run;
  };
  EXPECT_THAT(render_as_task({{"ID", "2"}, {"MIN", "2"}, {"MAX", "5"}, {"COUNT", "2"}, {"STEP", "1"}}),
              FailedWith("expected an array 0-(N-1)"));
  EXPECT_FALSE(fs::exists(part(1)));
  ASSERT_THAT(render_as_task({{"ID", "1"}, {"MIN", "0"}, {"MAX", "7"}, {"COUNT", "8"}, {"STEP", "1"}}),
              Succeeded());
  ASSERT_THAT(run_program({"render", "--manifest", kDemoManifest, "--shard", "1/8", "--out", part(2)}),
              Succeeded());
  EXPECT_TRUE(read_text_file(part(1)) == read_text_file(part(2)));
}

}  // namespace
}  // namespace knuckle::testing
