// SPDX-License-Identifier: Apache-2.0
#include "knuckle/experiment/step.h"

#include <atomic>
#include <stdexcept>
#include <thread>
#include <vector>

#include "knuckle/core/error.h"
#include "knuckle/core/testing.h"
#include "knuckle/core/text_file.h"
#include "knuckle/storage/file_io.h"

namespace knuckle::testing {
namespace {

class StepTest : public ::testing::Test {
 protected:
  /// Runs a step that writes `content`; returns whether it was done.
  bool is_done(const Inputs& inputs, const std::string& content = "made") {
    return run_step(output_, inputs, [&](StepStart) { write_text_file(output_, content); }) ==
           StepOutcome::done;
  }

  TemporaryFolder folder_;
  std::filesystem::path output_ = std::filesystem::path(folder_ / "a") / "output.txt";
};

TEST_F(StepTest, IsDoneOnceForTheSameInputs) {
  EXPECT_TRUE(is_done(Inputs().add("scale", "1")));
  EXPECT_FALSE(is_done(Inputs().add("scale", "1")));
  EXPECT_TRUE(is_done(Inputs().add("scale", "2"), "other"));
  EXPECT_EQ(read_text_file(output_), "other");
  EXPECT_TRUE(is_done(Inputs().add("scale", "1"))) << "only the last inputs are those of the output";
}

TEST_F(StepTest, IsDoneAgainWhereItsOutputIsGone) {
  EXPECT_TRUE(is_done(Inputs()));
  std::filesystem::remove(output_);
  EXPECT_TRUE(is_done(Inputs()));
}

TEST_F(StepTest, IsDoneAgainWhereAnInputFileChanged) {
  const std::filesystem::path file = folder_ / "input";
  write_text_file(file, "one");
  EXPECT_TRUE(is_done(Inputs().add_content("file", file)));
  EXPECT_FALSE(is_done(Inputs().add_content("file", file)));
  write_text_file(file, "two");
  EXPECT_TRUE(is_done(Inputs().add_content("file", file)));
}

TEST_F(StepTest, IsDoneAgainWhereAFileOfAnInputFolderChanged) {
  const std::filesystem::path set = folder_ / "set";
  make_folder(set / "depth");
  write_text_file(set / "depth/0.png", "one");
  EXPECT_TRUE(is_done(Inputs().add_content("set", set)));
  EXPECT_FALSE(is_done(Inputs().add_content("set", set)));
  std::filesystem::rename(set / "depth/0.png", set / "depth/1.png");
  EXPECT_TRUE(is_done(Inputs().add_content("set", set)));
}

TEST_F(StepTest, IsDoneAgainAfterItFailed) {
  EXPECT_TRUE(is_done(Inputs().add("scale", "1"), "old"));
  const Inputs changed = Inputs().add("scale", "2");
  EXPECT_THROW(run_step(output_, changed, [](StepStart) { throw std::runtime_error("stopped"); }),
               std::runtime_error);
  EXPECT_TRUE(is_done(changed, "new"));
  EXPECT_THROW(run_step(output_, Inputs(), [](StepStart) { throw std::runtime_error("stopped"); }),
               std::runtime_error);
  EXPECT_TRUE(is_done(changed, "new")) << "what a stopped step left counts as made from nothing known";
}

TEST_F(StepTest, KnowsWhetherARunWithTheSameInputsWasStopped) {
  const Inputs inputs = Inputs().add("scale", "1");
  const auto start_of = [&](const Inputs& of) {
    StepStart found = StepStart::anew;
    EXPECT_THROW(run_step(output_, of,
                          [&](StepStart start) {
                            found = start;
                            throw std::runtime_error("stopped");
                          }),
                 std::runtime_error);
    return found;
  };
  EXPECT_EQ(start_of(inputs), StepStart::anew);
  EXPECT_EQ(start_of(inputs), StepStart::again);
  EXPECT_EQ(start_of(Inputs().add("scale", "2")), StepStart::anew);
  EXPECT_EQ(start_of(inputs), StepStart::anew) << "what lies there now is of scale 2";
  EXPECT_TRUE(is_done(inputs));
  std::filesystem::remove(output_);
  EXPECT_EQ(start_of(inputs), StepStart::anew) << "that run came to its end";
}

TEST_F(StepTest, IsDoneByOneOfThoseThatComeToIt) {
  std::atomic<int> done = 0;
  const auto come = [&] {
    run_step(output_, Inputs(), [&](StepStart) {
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
      ++done;
      write_text_file(output_, "made");
    });
    EXPECT_TRUE(is_step_done(output_, Inputs())) << "who comes later waits for it";
  };
  {
    std::vector<std::jthread> processes;
    for (int i = 0; i < 3; ++i) processes.emplace_back(come);
  }
  EXPECT_EQ(done, 1);
}

TEST_F(StepTest, NamesAMissingInput) {
  EXPECT_THAT([&] { Inputs().add_content("model", folder_ / "none.model"); },
              ::testing::ThrowsMessage<Error>(::testing::HasSubstr("none.model")));
}

}  // namespace
}  // namespace knuckle::testing
