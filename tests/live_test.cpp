// SPDX-License-Identifier: Apache-2.0
// `knuckle live` on sources that are played.
#include "program.h"

#include <fstream>
#include <sstream>

#include "knuckle/core/text_file.h"
#include "knuckle/data/frame_record.h"
#include "knuckle/storage/file_io.h"

namespace knuckle::testing {
namespace {

using ::testing::HasSubstr;

constexpr const char* kPlayedDemo = "synthetic:manifests/demo.toml?rate=30&count=8";

std::vector<FrameRecord> live_records(const std::string& text) {
  std::vector<FrameRecord> records;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) records.push_back(parse_frame_record(line));
  return records;
}

class LiveTest : public ::testing::Test {
 protected:
  std::string path(const std::string& name) const { return folder_ / name; }

  TemporaryFolder folder_;
};

TEST_F(LiveTest, RecordsComeInOrderWithTheirLatency) {
  const ProgramRun run = run_program({"live", "--source", kPlayedDemo, "--records", "-"});
  ASSERT_THAT(run, Succeeded());
  const std::vector<FrameRecord> records = live_records(run.out);
  ASSERT_FALSE(records.empty());
  std::int64_t before = -1;
  for (const FrameRecord& record : records) {
    EXPECT_GT(record.frame, before);
    before = record.frame;
    EXPECT_NEAR(record.time_s.value(), static_cast<double>(record.frame) / 30.0, 1e-6);
    EXPECT_GT(record.latency_ms.value(), 0.0);
  }
  EXPECT_EQ(records.back().frame, 7) << "the newest wins, so the last one is always looked at";
  EXPECT_THAT(run.error, HasSubstr("8 frames came, "));
}

TEST_F(LiveTest, AFileHasItsNameOnceItIsWhole) {
  const ProgramRun run = run_program({"live", "--source", "synthetic:manifests/demo.toml?rate=20&loop=1",
                                      "--frames", "5", "--records", path("r.jsonl")});
  ASSERT_THAT(run, Succeeded());
  EXPECT_EQ(live_records(read_text_file(folder_ / "r.jsonl")).size(), 5U);
  EXPECT_THAT(entries_of(folder_.path()), ::testing::ElementsAre("r.jsonl"));
  EXPECT_THAT(run.out, HasSubstr("a hand in 5 of 5; from a frame to its record "));
}

TEST_F(LiveTest, EndsCleanlyOnCtrlC) {
  const std::string partial = path("r.jsonl.partial");
  const ProgramRun run = run_program_until(
      [&] { return std::filesystem::exists(partial) && std::filesystem::file_size(partial) > 3000; },
      {"live", "--source", "synthetic:manifests/demo.toml?rate=100&loop=1", "--records", path("r.jsonl")},
      SIGINT);
  EXPECT_THAT(run, Succeeded());
  EXPECT_GE(live_records(read_text_file(folder_ / "r.jsonl")).size(), 1U);
}

TEST_F(LiveTest, ALinkUnderTheNameOfWhatIsNotYetWholeIsNotFollowed) {
  write_text_file(folder_ / "others", "of another person");
  std::filesystem::create_symlink(folder_ / "others", folder_ / "r.jsonl.partial");
  EXPECT_THAT(run_program({"live", "--source", kPlayedDemo, "--records", path("r.jsonl")}),
              FailedWith("r.jsonl.partial: cannot write"));
  EXPECT_EQ(read_text_file(folder_ / "others"), "of another person");
}

TEST_F(LiveTest, FaultsAreOneLine) {
  EXPECT_THAT(run_program({"live", "--source", "synthetic:manifests/demo.toml?rate=abc"}),
              FailedWith("rate"));
  EXPECT_THAT(run_program({"live", "--source", "folder:" + path("none")}), FailedWith("none"));
  EXPECT_THAT(run_program({"live", "--source", kPlayedDemo, "--records", path("none/r.jsonl")}),
              FailedWith("none/r.jsonl"));
  EXPECT_THAT(run_program({"live", "--source", kPlayedDemo, "--pipeline", path("p.toml")}),
              FailedWith("p.toml"));
  const ProgramRun full = run_program_on_full_disk(
      4, {"live", "--source", "synthetic:manifests/demo.toml?rate=200&loop=1", "--records", path("r.jsonl")});
  EXPECT_THAT(full, FailedWith("r.jsonl: cannot be written"));
  EXPECT_FALSE(std::filesystem::exists(path("r.jsonl")));
}

}  // namespace
}  // namespace knuckle::testing
