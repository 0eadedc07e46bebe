// SPDX-License-Identifier: Apache-2.0
#include "knuckle/experiment/page_sections.h"

#include "knuckle/core/testing.h"

namespace knuckle::testing {
namespace {

using ::testing::HasSubstr;

TEST(PageSections, TimesOfTrainingsAreReadable) {
  ExperimentScores scores{.sequences = {SequenceScores{}}, .trainings = {}};
  const auto time_of = [&](std::optional<double> seconds) {
    scores.trainings = {{.model = "hands.pt", .given = {}, .seconds = seconds, .samples = 12345}};
    return times_section(scores);
  };
  EXPECT_THAT(time_of(99.0), HasSubstr(">99.0 s<"));
  EXPECT_THAT(time_of(150.0), HasSubstr(">2.5 min<"));
  EXPECT_THAT(time_of(5940.0), HasSubstr(">99.0 min<"));
  EXPECT_THAT(time_of(6120.0), HasSubstr(">1.7 h<"));
  const std::string unknown = time_of(std::nullopt);
  for (const char* const cell : {">hands.pt<", ">trained here<", ">12345<", ">\u2013<"})
    EXPECT_THAT(unknown, HasSubstr(cell));
}

}  // namespace
}  // namespace knuckle::testing
