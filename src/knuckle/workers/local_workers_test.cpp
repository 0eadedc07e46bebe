// SPDX-License-Identifier: Apache-2.0
#include "knuckle/workers/local_workers.h"

#include <chrono>
#include <cstdlib>
#include <fstream>
#include <thread>

#include "knuckle/core/testing.h"
#include "knuckle/core/testing_variable.h"
#include "knuckle/workers/worker_place.h"

namespace knuckle {
namespace {

using testing::ChangedVariable;
using testing::TemporaryFolder;
using namespace std::chrono_literals;

constexpr const char* kReportFolder = "KNUCKLE_TEST_REPORTS";

/// What this program does in place of its tests where one of them has started it as a worker.
const bool kIsStarted = [] {
  const char* const reports = std::getenv(kReportFolder);
  if (reports == nullptr) return false;
  const std::string rank = std::getenv(kRankVariable);
  if (rank == "2") std::this_thread::sleep_for(300ms);
  std::ofstream(std::filesystem::path(reports) / rank) << std::getenv(kFolderVariable);
  std::_Exit(rank == "3" ? 1 : 0);
}();

TEST(LocalWorkers, AreWaitedForUntilTheLastOneHasEndedAndTheirFolderGoesThen) {
  const TemporaryFolder reports;
  const ChangedVariable variable(kReportFolder, reports.path().c_str());
  std::filesystem::path folder;
  {
    LocalWorkers workers({"knuckle_workers_test"}, 3);
    folder = workers.folder();
    EXPECT_TRUE(std::filesystem::is_directory(folder));
    EXPECT_FALSE(workers.fault());
  }
  EXPECT_TRUE(std::filesystem::exists(reports / "1"));
  EXPECT_TRUE(std::filesystem::exists(reports / "2")) << "which takes longer";
  EXPECT_FALSE(std::filesystem::exists(reports / "3"));
  EXPECT_FALSE(std::filesystem::exists(folder));
}

TEST(LocalWorkers, OneThatFailsIsNamed) {
  const TemporaryFolder reports;
  const ChangedVariable variable(kReportFolder, reports.path().c_str());
  LocalWorkers workers({"knuckle_workers_test"}, 4);
  std::optional<std::string> fault;
  for (int i = 0; i < 1000 && !(fault = workers.fault()); ++i) std::this_thread::sleep_for(10ms);
  EXPECT_EQ(fault.value_or(""), "worker 3 of 4 ended with status 1");
}

}  // namespace
}  // namespace knuckle
