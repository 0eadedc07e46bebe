// SPDX-License-Identifier: Apache-2.0
#include "knuckle/experiment/train_model.h"

#include <string>
#include <string_view>
#include <vector>

#include "knuckle/core/parallel.h"
#include "knuckle/core/testing.h"
#include "knuckle/core/text.h"
#include "knuckle/core/text_file.h"
#include "knuckle/forest/forest_growth.h"
#include "knuckle/storage/file_io.h"

namespace knuckle::testing {
namespace {

using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;

/// A shell in place of the program notes what it is asked for.
class TrainModelTest : public ::testing::Test {
 protected:
  /// The arguments that the program got, without its own name; `then` is what the shell does after that.
  std::vector<std::string> arguments_of(const std::string& kind, StepStart start,
                                        TrainingOptions options = {},
                                        const std::string& then = "echo new > \"$MODEL\"") {
    const std::string script =
        "MODEL='" + model_.string() + "'; shift; printf '%s\\n' \"$@\" > '" + words_.string() + "'; " + then;
    options.starter = {"/bin/sh", "-c", script, "sh"};
    train_model(kind, "config.toml", options, start, model_);
    std::string text = read_text_file(words_);
    text.pop_back();  // the last line's end
    std::vector<std::string> arguments;
    for (const std::string_view word : split(text, '\n')) arguments.emplace_back(word);
    return arguments;
  }

  void leave(const std::string& ending) { write_text_file(model_.string() + ending, "left"); }

  TemporaryFolder folder_;
  std::filesystem::path model_ = folder_ / "hands.pt";
  std::filesystem::path words_ = folder_ / "words";
};

TEST_F(TrainModelTest, AsksForAllThatIsSaid) {
  const std::string threads = std::to_string(thread_count());
  EXPECT_THAT(arguments_of("pose-forest", StepStart::anew, {.device = "cuda:1", .cache = "kept"}),
              ElementsAre("train", "pose-forest", "--config", "config.toml", "--out", model_.string(),
                          "--threads", threads))
      << "devices and caches are of networks alone";
  EXPECT_THAT(arguments_of("network", StepStart::anew, {.device = "cuda:1", .cache = "kept", .workers = 3}),
              ElementsAre("train", "network", "--config", "config.toml", "--out", model_.string(),
                          "--threads", threads, "--device", "cuda:1", "--cache", "kept", "--workers", "3"));
}

TEST_F(TrainModelTest, GoesOnOnlyWithWhatTheSameTrainingLeft) {
  EXPECT_THAT(arguments_of("network", StepStart::again), Not(Contains("--resume"))) << "nothing was left";
  leave(".checkpoint");
  EXPECT_THAT(arguments_of("network", StepStart::again), Contains("--resume"));
  EXPECT_THAT(arguments_of("network", StepStart::anew), Not(Contains("--resume"))) << "left by another one";
  remove_training_checkpoint(model_);
  EXPECT_THAT(arguments_of("network", StepStart::again), Not(Contains("--resume")));
  write_text_file(tree_checkpoint(model_.string() + ".checkpoint"), "left");
  EXPECT_THAT(arguments_of("pose-forest", StepStart::again), Contains("--resume")) << "of a tree that grew";
}

TEST_F(TrainModelTest, AnOlderModelIsNotTakenForTheNewOne) {
  leave("");
  const std::string error = error_of([&] { arguments_of("network", StepStart::anew, {}, "true"); });
  EXPECT_THAT(error, HasSubstr("hands.pt: its training came to its end but left no model"));
  leave("");
  EXPECT_NO_THROW(arguments_of("network", StepStart::again, {}, "true"));
  EXPECT_EQ(read_text_file(model_), "left") << "it is of the same training";
}

}  // namespace
}  // namespace knuckle::testing
