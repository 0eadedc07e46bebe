// SPDX-License-Identifier: Apache-2.0
// The verbs as a user types them: what all have in common, and those that show what is there.
#include "verbs.h"

#include <algorithm>
#include <iterator>
#include <sstream>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

#include "knuckle/core/text_file.h"
#include "knuckle/data/readers/image_io.h"

namespace knuckle::testing {
namespace {

using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::MatchesRegex;
using ::testing::StartsWith;

/// The verbs that `knuckle VERB... --help` lists, each as it is typed.
std::vector<std::vector<std::string>> verbs_below(const std::vector<std::string>& verb) {
  std::vector<std::string> arguments = verb;
  arguments.emplace_back("--help");
  const std::string help = run_program(arguments).out;
  const std::size_t begin = help.find("\nSubcommands:\n");
  std::vector<std::vector<std::string>> verbs;
  if (begin == std::string::npos) return {verb};
  std::istringstream lines(help.substr(begin + 1));
  std::string line;
  std::getline(lines, line);
  while (std::getline(lines, line) && line.starts_with("  ") && line[2] != ' ') {
    std::vector<std::string> below = verb;
    below.push_back(line.substr(2, line.find(' ', 2) - 2));
    std::ranges::move(verbs_below(below), std::back_inserter(verbs));
  }
  return verbs;
}

TEST_F(VerbsTest, EveryVerbHasHelpWithAnExampleAndThreads) {
  const std::vector<std::vector<std::string>> verbs = verbs_below({});
  EXPECT_THAT(verbs, ::testing::IsSupersetOf(std::vector<std::vector<std::string>>{
                         {"info"}, {"train", "network"}, {"labels", "export"}, {"live"}, {"demo"}}));
  for (std::vector<std::string> arguments : verbs) {
    SCOPED_TRACE(fmt::format("{}", fmt::join(arguments, " ")));
    const std::string typed = fmt::format("\n  knuckle {}", fmt::join(arguments, " "));
    arguments.emplace_back("--help");
    const ProgramRun run = run_program(arguments);
    EXPECT_THAT(run, Succeeded());
    EXPECT_THAT(run.out, HasSubstr("Example:\n"));
    EXPECT_THAT(run.out, HasSubstr(typed));
    EXPECT_THAT(run.out, HasSubstr("--threads"));
  }
}

TEST_F(VerbsTest, WrongUsageEndsWithStatusTwo) {
  for (const std::vector<std::string>& arguments :
       {std::vector<std::string>{},
        {"paint"},
        {"segment"},
        {"info", "--colour"},
        {"train"},
        {"segment", "--source", kSixFrames, "--out", "x", "--init", "somewhere"},
        {"info", "--threads", "-1"},
        {"info", "--threads", "many"}}) {
    const ProgramRun run = run_program(arguments);
    EXPECT_EQ(run.status, 2) << ::testing::PrintToString(arguments) << run.error;
    EXPECT_FALSE(run.error.empty());
  }
}

TEST_F(VerbsTest, MistypedWordsAreNamedWithTheNearestThatIsKnown) {
  const std::pair<std::vector<std::string>, std::string> cases[] = {
      {{"estimat", "--source", "x"}, "unknown verb 'estimat' (did you mean 'estimate'?); `knuckle --help`"},
      {{"estimate", "--sorce", "x"},
       "unknown option '--sorce' (did you mean '--source'?); `knuckle estimate --help`"},
      {{"estimate", "--sorce=x", "--out", "y"}, "unknown option '--sorce' (did you mean '--source'?)"},
      {{"train", "netwrk"}, "unknown verb 'netwrk' (did you mean 'network'?); `knuckle train --help`"},
      {{"info", "--colour"}, "unknown option '--colour'; `knuckle info --help`"},
      {{"info", "everything"}, "unknown argument 'everything'; `knuckle info --help`"},
      {{"qwertz"}, "unknown verb 'qwertz'; `knuckle --help`"}};
  for (const auto& [arguments, message] : cases) {
    const ProgramRun run = run_program(arguments);
    EXPECT_EQ(run.status, 2) << ::testing::PrintToString(arguments);
    EXPECT_THAT(run.error, StartsWith("knuckle: " + message));
    EXPECT_EQ(std::ranges::count(run.error, '\n'), 1) << run.error;
  }
}

TEST_F(VerbsTest, TheVersionIsASemanticOne) {
  const ProgramRun run = run_program({"--version"});
  EXPECT_THAT(run, Succeeded());
  EXPECT_THAT(run.out, MatchesRegex("knuckle [0-9]+\\.[0-9]+\\.[0-9]+\n"));
}

TEST_F(VerbsTest, InfoListsEveryMethodByKind) {
  const ProgramRun run = run_program({"info", "--json"});
  ASSERT_THAT(run, Succeeded());
  const auto info = nlohmann::json::parse(run.out);
  EXPECT_THAT(info["cameras"].get<std::vector<std::string>>(), Contains("v4l2"));
  EXPECT_THAT(info["segmenters"].get<std::vector<std::string>>(), Contains("mean_shift"));
  EXPECT_THAT(info["estimators"].get<std::vector<std::string>>(), Contains("forest"));
  EXPECT_THAT(info["refiners"].get<std::vector<std::string>>(), Contains("depth_lookup"));
  EXPECT_THAT(info["sources"].get<std::vector<std::string>>(), Contains("synthetic"));
  EXPECT_EQ(info["conventions"].size(), 7u);
}

TEST_F(VerbsTest, InspectDrawsAFrame) {
  const ProgramRun run =
      run_program({"inspect", "--source", kSixFrames, "--frame", "2", "--png", path("frame.png")});
  ASSERT_THAT(run, Succeeded());
  EXPECT_THAT(run.out, HasSubstr("frames       6"));
  EXPECT_THAT(run.out, HasSubstr("knuckle22"));
  EXPECT_FALSE(read_png_rgb(path("frame.png")).empty());
}

TEST_F(VerbsTest, InspectMeasuresTheHandsOfASource) {
  const ProgramRun run =
      run_program({"inspect", "--source", kSixFrames, "--statistics", "--panels", path("panels.png")});
  ASSERT_THAT(run, Succeeded());
  EXPECT_THAT(run.out, HasSubstr("found in 6 of 6 frames"));
  EXPECT_THAT(run.out, HasSubstr("surface noise"));
  EXPECT_FALSE(read_png_rgb(path("panels.png")).empty());
}

TEST_F(VerbsTest, DemoMakesAReport) {
  const ProgramRun run = run_program({"demo", "--out", path("demo")});
  ASSERT_THAT(run, Succeeded());
  EXPECT_THAT(run.out, HasSubstr(path("demo/report.html")));
  EXPECT_THAT(read_text_file(path("demo/report.html")), HasSubstr("data:image/png;base64,"));
}

}  // namespace
}  // namespace knuckle::testing
