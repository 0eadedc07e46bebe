// SPDX-License-Identifier: Apache-2.0
#include "knuckle/experiment/step_jobs.h"

#include <algorithm>

#include "knuckle/core/error.h"
#include "knuckle/core/interruption.h"
#include "knuckle/core/testing.h"
#include "knuckle/storage/file_io.h"

namespace knuckle::testing {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

/// A queue without a scheduler: `turn` is what happens between two looks at what is done.
class FakeQueue final : public JobQueue {
 public:
  struct Job {
    const ExperimentStep* step;
    std::filesystem::path log;
  };

  std::string submit(const ExperimentStep& step, const std::filesystem::path& log) override {
    jobs.push_back({&step, log});
    const std::string number = std::to_string(jobs.size());
    known[number] = {};
    on_submit(number);
    return number;
  }

  std::map<std::string, JobState> states() override {
    most_alive = std::max(most_alive, alive());
    on_ask();
    return known;
  }

  void cancel(const std::vector<std::string>& numbers) override { cancelled = numbers; }

  const Job& job(const std::string& number) const { return jobs.at(std::stoul(number) - 1); }

  /// Does the step of that job, as another process would.
  void complete(const std::string& number) {
    run_here(*job(number).step);
    known.at(number) = {JobState::Kind::ended, "COMPLETED"};
  }

  int alive() const {
    return static_cast<int>(std::ranges::count_if(
        known, [](const auto& entry) { return entry.second.kind == JobState::Kind::alive; }));
  }

  void complete_all() {
    for (auto& [number, state] : known) {
      if (state.kind == JobState::Kind::alive) complete(number);
    }
  }

  std::vector<std::string> names() const {
    std::vector<std::string> names;
    for (const Job& job : jobs) names.push_back(job.step->name);
    return names;
  }

  std::vector<Job> jobs;
  std::map<std::string, JobState> known;
  std::vector<std::string> cancelled;
  int most_alive = 0;
  std::function<void(const std::string&)> on_submit = [](const std::string&) {};
  std::function<void()> on_ask = [this] { complete_all(); };
};

class StepJobsTest : public ::testing::Test {
 protected:
  StepJobsTest() {
    options_.logs = folder_ / "logs";
    options_.look_every = options_.ask_every = std::chrono::milliseconds(1);
    options_.patience = std::chrono::milliseconds(20);
  }
  ~StepJobsTest() override { set_interrupted(false); }

  ExperimentStep& add(const std::string& name, const std::vector<std::string>& needs = {}) {
    ExperimentStep step;
    step.name = name;
    step.output = folder_ / name;
    step.needs = needs;
    step.inputs = [this, needs] {
      Inputs inputs;
      for (const std::string& need : needs) inputs.add_content(need, folder_ / need);
      return inputs;
    };
    step.work = [output = step.output](StepStart) { write_text_file(output, "made"); };
    steps_.push_back(step);
    return steps_.back();
  }

  void run() { run_as_jobs(steps_, queue_, options_); }

  TemporaryFolder folder_;
  std::vector<ExperimentStep> steps_;
  FakeQueue queue_;
  StepJobsOptions options_;
};

TEST_F(StepJobsTest, HandsOverEachStepAfterWhatItNeeds) {
  add("copy").is_copy = true;
  add("models/a", {"copy"});
  add("models/b");
  add("poses/a", {"models/a"});
  add("report", {"poses/a", "models/b"});
  run();
  EXPECT_THAT(queue_.names(), ElementsAre("models/a", "models/b", "poses/a", "report"));
  EXPECT_EQ(queue_.jobs[2].log, folder_ / "logs" / "poses_a.log");
  EXPECT_TRUE(std::filesystem::exists(folder_ / "report"));
  EXPECT_THAT(queue_.cancelled, IsEmpty());
}

TEST_F(StepJobsTest, LeavesWhatIsDone) {
  int tidied = 0;
  add("models/a").tidy = [&] { ++tidied; };
  add("report", {"models/a"});
  run();
  EXPECT_EQ(tidied, 2) << "by the job and by who waits for it";
  run();
  EXPECT_EQ(queue_.jobs.size(), 2U);
  EXPECT_EQ(tidied, 3);
}

TEST_F(StepJobsTest, HasNoMoreJobsThanItMay) {
  for (const char* name : {"a", "b", "c", "d", "e"}) add(name);
  options_.most = 2;
  run();
  EXPECT_EQ(queue_.most_alive, 2);
  EXPECT_EQ(queue_.jobs.size(), 5U);
}

TEST_F(StepJobsTest, SeesWhatIsDoneAlsoWhereTheQueueForgetsTheJob) {
  add("a");
  queue_.on_submit = [&](const std::string& number) {
    queue_.complete(number);
    queue_.known.clear();
  };
  run();
  EXPECT_TRUE(std::filesystem::exists(folder_ / "a"));
}

TEST_F(StepJobsTest, AJobThatFailsEndsAllWithItsWordsAndLog) {
  add("models/a");
  add("models/b");
  queue_.on_ask = [&] {
    write_text_file(queue_.job("1").log,
                    "work: 1 of 2\nknuckle: set.toml:3: depth: is missing\nsrun: ended\n");
    queue_.known["1"] = {JobState::Kind::failed, "FAILED"};
  };
  EXPECT_EQ(error_of([&] { run(); }),
            "models/a: job 1 failed (FAILED): set.toml:3: depth: is missing; its log is " +
                (folder_ / "logs/models_a.log").string());
  EXPECT_THAT(queue_.cancelled, ::testing::Contains("2"));
}

TEST_F(StepJobsTest, AJobThatIsEndedWithoutAWordIsNamed) {
  add("a");
  queue_.on_ask = [&] { queue_.known["1"] = {JobState::Kind::failed, "TIMEOUT"}; };
  EXPECT_THAT(error_of([&] { run(); }),
              AllOf(HasSubstr("a: job 1 failed (TIMEOUT); its log is"), Not(HasSubstr(": ;"))));
}

TEST_F(StepJobsTest, AJobThatMakesNothingHereIsNamedAfterAWhile) {
  add("a");
  queue_.on_ask = [&] { queue_.known["1"] = {JobState::Kind::ended, "COMPLETED"}; };
  EXPECT_THAT(error_of([&] { run(); }), HasSubstr("expected a folder that all machines see"));
}

TEST_F(StepJobsTest, CancelsItsJobsWhereItIsAskedToEnd) {
  add("a");
  queue_.on_ask = [] { set_interrupted(true); };
  EXPECT_THROW(run(), Interrupted);
  EXPECT_THAT(queue_.cancelled, ElementsAre("1"));
}

}  // namespace
}  // namespace knuckle::testing
