// SPDX-License-Identifier: Apache-2.0
#include "knuckle/core/resources.h"

#include <cstdlib>
#include <thread>
#include <vector>

#include <sys/wait.h>
#include <unistd.h>

#include "knuckle/core/testing.h"

namespace knuckle::testing {
namespace {

using ::testing::AllOf;
using ::testing::ExitedWithCode;
using ::testing::HasSubstr;

/// What is set stays set: each case runs in a process of its own, which ends with 0 where `holds` does.
template <class Condition>
void expect_in_own_process(Condition holds) {
  EXPECT_EXIT(std::_Exit(holds() ? 0 : 1), ExitedWithCode(0), "");
}

class ResourcesTest : public ::testing::Test {
 protected:
  ResourcesTest() { GTEST_FLAG_SET(death_test_style, "threadsafe"); }
};

TEST_F(ResourcesTest, ABuildHasTheFilesOfItsSourceTree) {
  ::unsetenv("KNUCKLE_HOME");
  EXPECT_TRUE(std::filesystem::exists(resource_path("pipelines/default.toml")));
  EXPECT_TRUE(std::filesystem::exists(resource_path("models/dense.pt")));
}

TEST_F(ResourcesTest, TheEnvironmentComesBeforeWhatIsInstalled) {
  expect_in_own_process([] {
    ::setenv("KNUCKLE_HOME", "/somewhere", 1);
    return resource_path("models/a.pt") == "/somewhere/models/a.pt";
  });
}

TEST_F(ResourcesTest, WhatWasSetComesBeforeTheEnvironment) {
  const TemporaryFolder folder;
  expect_in_own_process([&] {
    ::setenv("KNUCKLE_HOME", "/somewhere", 1);
    set_data_folder(folder.path());
    return resource_path("models/a.pt") == folder / "models/a.pt";
  });
}

TEST_F(ResourcesTest, WhatWasSetLastHolds) {
  const TemporaryFolder first;
  const TemporaryFolder second;
  expect_in_own_process([&] {
    set_data_folder(first.path());
    set_data_folder(second.path());
    return resource_path("a") == second / "a";
  });
}

TEST_F(ResourcesTest, ARelativeFolderKeepsItsPlace) {
  const TemporaryFolder folder;
  std::filesystem::create_directory(folder / "data");
  expect_in_own_process([&] {
    std::filesystem::current_path(folder.path());
    set_data_folder("data");
    std::filesystem::current_path("/");
    return resource_path("a") == folder / "data/a";
  });
}

TEST_F(ResourcesTest, AFolderThatIsNotThereIsAFault) {
  EXPECT_THAT(error_of([] { set_data_folder("/none/of/these"); }),
              AllOf(HasSubstr("/none/of/these"), HasSubstr("not a folder")));
  EXPECT_TRUE(std::filesystem::exists(resource_path("pipelines/default.toml"))) << "it was set all the same";
}

TEST_F(ResourcesTest, ManyThreadsMaySetAndAsk) {
  const TemporaryFolder folder;
  expect_in_own_process([&] {
    std::vector<std::thread> threads;
    for (int i = 0; i < 8; ++i) {
      threads.emplace_back([&] {
        for (int k = 0; k < 1000; ++k) {
          set_data_folder(folder.path());
          if (resource_path("a") != folder / "a") std::_Exit(1);
        }
      });
    }
    for (std::thread& thread : threads) thread.join();
    return true;
  });
}

TEST(HelperProgram, OneThatIsMissingIsNamedWithWhereItWasLookedFor) {
  EXPECT_THAT(testing::error_of([] { helper_program("knuckle-nothing"); }),
              ::testing::AllOf(::testing::HasSubstr("knuckle-nothing cannot be found"),
                               ::testing::HasSubstr("libexec/knuckle/knuckle-nothing")));
}

}  // namespace
}  // namespace knuckle::testing
