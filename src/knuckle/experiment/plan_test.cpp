// SPDX-License-Identifier: Apache-2.0
#include "knuckle/experiment/plan.h"

#include "knuckle/core/error.h"
#include "knuckle/core/testing.h"
#include "knuckle/storage/file_io.h"

namespace knuckle::testing {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

constexpr std::string_view kSequence = "[[sequence]]\nname = \"one\"\nsource = \"folder:set\"\n";

class PlanTest : public ::testing::Test {
 protected:
  ExperimentPlan load(std::string_view toml) const {
    const std::filesystem::path path = folder_ / "plan.toml";
    write_text_file(path, toml);
    return ExperimentPlan::load(path);
  }

  TemporaryFolder folder_;
};

TEST_F(PlanTest, PathsStartAtThePlan) {
  const ExperimentPlan plan =
      load(std::string(kSequence) +
           "[[model]]\nfile = \"m.model\"\nkind = \"pose-forest\"\nconfig = \"../c.toml\"\n"
           "[[estimation]]\nname = \"forest\"\npipeline = \"p/forest.toml\"\n");
  const std::filesystem::path base = std::filesystem::path(folder_ / "plan.toml").parent_path();
  EXPECT_EQ(plan.name, "plan");
  EXPECT_EQ(plan.sequences.at(0).source, "folder:" + (base / "set").string());
  EXPECT_EQ(plan.sequences.at(0).title, "one");
  EXPECT_EQ(plan.models.at(0).config.lexically_normal(), (base / "../c.toml").lexically_normal());
  EXPECT_EQ(plan.estimation.at(0).pipeline, base / "p/forest.toml");
  EXPECT_TRUE(plan.segmentation.empty());
}

TEST_F(PlanTest, NamesTheFault) {
  const auto faults = [&](const std::string& toml, const std::string& part) {
    EXPECT_THAT([&] { load(toml); }, ThrowsMessage<Error>(AllOf(HasSubstr("plan.toml"), HasSubstr(part))))
        << toml;
  };
  faults("title = \"x\"\n", "at least one [[sequence]]");
  faults(std::string(kSequence) + std::string(kSequence), "\"one\" stands twice");
  faults(std::string(kSequence) + "colour = 1\n", "colour");
  faults("[[sequence]]\nname = \"one\"\n", "source");
  faults(std::string(kSequence) + "[[model]]\nfile = \"m.model\"\nkind = \"pose-forest\"\n", "config");
  faults(std::string(kSequence) + "[[model]]\nfile = \"m.model\"\nkind = \"tree\"\nconfig = \"c\"\n",
         "segmentation-forest");
  faults(std::string(kSequence) + "[[model]]\nfile = \"a/m.model\"\nkind = \"network\"\nconfig = \"c\"\n",
         "\"a/m.model\" is not a name for a file");
  faults("[[sequence]]\nname = \"..\"\nsource = \"folder:set\"\n", "\"..\" is not a name for a file");
  for (const std::string name : {"", ".hidden", "a b", "a/../b"}) {
    faults("[[sequence]]\nname = \"" + name + "\"\nsource = \"folder:set\"\n",
           "\"" + name + "\" is not a name for a file");
  }
  faults("[[sequence]]\nname = \"models\"\nsource = \"folder:set\"\n", "a folder of the experiment itself");
  faults("convention = \"abc\"\n" + std::string(kSequence), "convention");
  faults("claims = \"all\"\n" + std::string(kSequence), "scia15");
  faults(std::string(kSequence) +
             "[[estimation]]\nname = \"a b\"\npipeline = \"p.toml\"\n"
             "[[estimation]]\nname = \"a_b\"\npipeline = \"q.toml\"\n",
         "shares its file name");
  faults(std::string(kSequence) +
             "[[segmentation]]\nname = \"a\"\npipeline = \"one/p.toml\"\n"
             "[[estimation]]\nname = \"a\"\npipeline = \"two/p.toml\"\n",
         "has the file name of");
}

TEST_F(PlanTest, AnUnknownNameListsTheKnownOnes) {
  EXPECT_THAT([] { find_plan("nonsense"); },
              ThrowsMessage<Error>(AllOf(HasSubstr("nonsense"), HasSubstr("scia15"))));
}

}  // namespace
}  // namespace knuckle::testing
