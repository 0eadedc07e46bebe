// SPDX-License-Identifier: Apache-2.0
#include "knuckle/training/network_training.h"

#include <algorithm>
#include <cmath>

#include <torch/cuda.h>
#include <torch/utils.h>

#include "knuckle/core/parallel.h"
#include "knuckle/core/testing.h"
#include "knuckle/core/text_file.h"
#include "knuckle/net/net_testing.h"
#include "knuckle/net/network_file.h"
#include "knuckle/net/pose_network.h"
#include "knuckle/prepare/stream_testing.h"
#include "knuckle/storage/file_io.h"
#include "knuckle/training/archive.h"
#include "knuckle/training/network_writer.h"
#include "knuckle/training/training_testing.h"

namespace knuckle {
namespace {

using ::testing::AllOf;
using testing::error_of;
using ::testing::HasSubstr;
using testing::made_up_samples;
using testing::no_augmentation;
using ::testing::Not;
using testing::short_training;
using testing::small_network;
using testing::TemporaryFolder;

using Begin = NetworkTrainingRun::Begin;

class NetworkTraining : public ::testing::Test {
 protected:
  ~NetworkTraining() override { set_thread_count(0); }

  NetworkTrainingRun run(const std::string& name = "net", Begin begin = Begin::anew) const {
    NetworkTrainingRun result = testing::run_in(folder_.path(), name);
    result.begin = begin;
    return result;
  }

  std::vector<TrainingMetrics> train(const NetworkTrainingOptions& options, const NetworkTrainingRun& files,
                                     const NetworkOptions& network = small_network()) const {
    return train_network(network, options, {}, {TrainingCrops{training_}}, validation_, files);
  }

  /// All weights and statistics of a checkpoint.
  std::vector<torch::Tensor> state_of(const std::string& name) const {
    ArchiveReader archive(folder_ / (name + ".checkpoint"), "knuckle-network-checkpoint", 2);
    std::vector<torch::Tensor> state;
    for (const char* const part : {"parameters", "buffers", "averages"}) {
      for (const torch::Tensor& tensor : archive.tensors(part)) state.push_back(tensor);
    }
    return state;
  }

  void expect_same_state(const std::string& a, const std::string& b) const {
    const std::vector<torch::Tensor> first = state_of(a);
    const std::vector<torch::Tensor> second = state_of(b);
    ASSERT_EQ(first.size(), second.size());
    for (std::size_t i = 0; i < first.size(); ++i) EXPECT_TRUE(torch::equal(first[i], second[i])) << i;
  }

  TemporaryFolder folder_;
  CubeSamples training_ = made_up_samples(8);
  CubeSamples validation_ = made_up_samples(3);
};

class EveryArchitecture : public NetworkTraining, public ::testing::WithParamInterface<std::string_view> {
 protected:
  NetworkOptions network() const {
    NetworkOptions options = small_network();
    options.architecture = GetParam();
    return options;
  }
};

INSTANTIATE_TEST_SUITE_P(, EveryArchitecture, ::testing::ValuesIn(network_architectures()),
                         [](const auto& instance) { return std::string(instance.param); });

TEST_P(EveryArchitecture, HasTheSameWeightsForAnyNumberOfThreads) {
  set_thread_count(1);
  const auto one = train(short_training(), run("one"), network());
  set_thread_count(2);
  const auto two = train(short_training(), run("two"), network());
  expect_same_state("one", "two");
  ASSERT_EQ(one.size(), 2u);
  EXPECT_EQ(one.back().validation[kSecondLook], two.back().validation[kSecondLook]);
}

TEST_P(EveryArchitecture, GoesOnFromACheckpointToTheSameBits) {
  for (const std::string optimiser : {"adamw", "sgd"}) {
    NetworkTrainingOptions options = short_training();
    options.optimiser = optimiser;
    options.keep = "last";
    train(options, run("whole"), network());
    NetworkTrainingRun stopped = run("parts");
    stopped.stop_after_steps = 3;  // not where it validates
    EXPECT_EQ(train(options, stopped, network()).back().step, 3);
    const auto metrics = train(options, run("parts", Begin::from_checkpoint), network());
    EXPECT_EQ(metrics.back().step, 4);
    EXPECT_EQ(metrics.front().step, 2) << "what was measured before the stop is kept";
    expect_same_state("whole", "parts");
    EXPECT_EQ(read_text_file(folder_ / "whole.pt"), read_text_file(folder_ / "parts.pt"));
  }
}

TEST_P(EveryArchitecture, InBfloat16LearnsNearlyTheSame) {
  NetworkTrainingOptions options = short_training();
  const auto single = train(options, run("single"), network());
  options.precision = "bfloat16";
  const auto half = train(options, run("half"), network());
  EXPECT_NE(half.front().training_loss, single.front().training_loss) << "all numbers still have 32 bits";
  for (std::size_t i = 0; i < single.size(); ++i) {
    EXPECT_NEAR(half[i].training_loss, single[i].training_loss, 0.02 * single[i].training_loss) << i;
  }
  for (const torch::Tensor& tensor : state_of("half")) EXPECT_NE(tensor.scalar_type(), torch::kBFloat16);

  NetworkTrainingRun stopped = run("parts");
  stopped.stop_after_steps = 3;
  train(options, stopped, network());
  train(options, run("parts", Begin::from_checkpoint), network());
  expect_same_state("half", "parts");
}

TEST_P(EveryArchitecture, ItsModelGivesTheAnswersOfTheValidation) {
  const std::vector<TrainingMetrics> metrics = train(short_training(), run(), network());
  const auto best = std::ranges::min_element(
      metrics, {}, [](const TrainingMetrics& m) { return m.validation[kSecondLook]; });
  const PoseNetwork model(folder_ / "net.pt");
  EXPECT_EQ(model.options().architecture, GetParam());
  const CubeViewer viewer(validation_);
  double sum_mm = 0.0;
  for (std::int64_t i = 0; i < validation_.size(); ++i) {
    const CubeSample sample = validation_.sample(i);
    Image<float> patch(testing::kTestCube.size_px, testing::kTestCube.size_px);
    Random unused(0);
    viewer.view_pixels(sample, {}, {}, unused, patch.pixels());
    std::vector<float> truth(sample.joints.size());
    viewer.view_joints(sample, {}, truth);
    const NetworkPrediction prediction = model.predict(patch);
    ASSERT_EQ(prediction.joints.size(), 14u);
    for (std::size_t j = 0; j < prediction.joints.size(); ++j) {
      const PatchPoint& joint = prediction.joints[j];
      const float found[] = {static_cast<float>(joint.u), static_cast<float>(joint.v),
                             static_cast<float>(joint.d)};
      const std::span<const float, 3> is(truth.data() + 3 * j, 3);
      sum_mm += (viewer.in_camera(sample, {}, found) - viewer.in_camera(sample, {}, is)).norm();
    }
  }
  const double mean_mm = sum_mm / static_cast<double>(14 * validation_.size());
  EXPECT_NEAR(mean_mm, best->validation[kFirstLook], 0.01 * mean_mm) << "but for half precision";
}

TEST_F(NetworkTraining, DenseLearns32SamplesByHeart) {
  NetworkTrainingOptions options = short_training();
  options.epochs = 150;
  options.batch_size = 8;
  options.shards = 1;
  options.validate_every = 150;
  options.learning_rate.learning_rate = 1e-2;
  options.average_decay = 0.9;
  const CubeSamples samples = made_up_samples(32);
  const auto metrics =
      train_network(small_network(), options, no_augmentation(), {TrainingCrops{samples}}, samples, run());
  EXPECT_LT(metrics.back().validation[kFirstLook], 1.0);
  EXPECT_LT(metrics.back().training_loss, metrics.front().training_loss);
}

TEST_P(EveryArchitecture, BeginsWithTheWeightsOfAModel) {
  train(short_training(), run("first"), network());
  NetworkTrainingOptions still = short_training();
  still.learning_rate.learning_rate = 1e-12;
  NetworkTrainingRun second = run("second");
  second.initial = folder_ / "first.pt";
  train(still, second, network());
  const NetworkWeights expected = load_network_weights(folder_ / "first.pt");
  const NetworkWeights begun = load_network_weights(folder_ / "second.pt");
  for (const NetworkArray& array : expected.arrays()) {
    if (array.precision != NetworkArray::Precision::half) continue;
    EXPECT_EQ(begun.floats(array.name), expected.floats(array.name)) << array.name;  // -0 is 0
  }
}

TEST_F(NetworkTraining, BeginsWithTheWeightsOfAModelThatTellsLess) {
  train(short_training(), run("first"));
  NetworkOptions telling = small_network();
  telling.dense.tells_side = true;
  telling.dense.question_weight = 1.0;
  AugmentationOptions mirrors = no_augmentation();
  mirrors.mirrored_share = 0.5;
  NetworkTrainingOptions still = short_training();
  still.learning_rate.learning_rate = 1e-12;
  NetworkTrainingRun second = run("second");
  second.initial = folder_ / "first.pt";
  const CubeSamples samples = made_up_samples(8);
  train_network(telling, still, mirrors, {TrainingCrops{samples}}, samples, second);
  const NetworkWeights expected = load_network_weights(folder_ / "first.pt");
  const NetworkWeights begun = load_network_weights(folder_ / "second.pt");
  for (const NetworkArray& array : expected.arrays()) {
    if (array.precision != NetworkArray::Precision::half) continue;
    std::vector<float> first_rows = begun.floats(array.name);
    EXPECT_EQ(first_rows.size() > expected.floats(array.name).size(),
              array.name.starts_with("head.w") || array.name.starts_with("head.b"));
    first_rows.resize(expected.floats(array.name).size());
    EXPECT_EQ(first_rows, expected.floats(array.name)) << array.name;
  }
  NetworkTrainingRun third = run("third");
  third.initial = folder_ / "second.pt";
  EXPECT_THAT(error_of([&] { train(short_training(), third); }), HasSubstr("[network] or [patch] differs"));
}

TEST_F(NetworkTraining, RefusesToBeginWithAModelOfAnotherKind) {
  train(short_training(), run("first"));
  NetworkOptions other = small_network();
  other.patch.cube_mm = 300.0;
  NetworkTrainingRun second = run("second");
  second.initial = folder_ / "first.pt";
  EXPECT_THAT(error_of([&] { train(short_training(), second, other); }),
              AllOf(HasSubstr("first.pt"), HasSubstr("[network] or [patch] differs")));
  second.initial = folder_ / "none.pt";
  EXPECT_THAT(error_of([&] { train(short_training(), second); }), HasSubstr("none.pt"));
}

TEST_F(NetworkTraining, RefusesACheckpointOfAnotherTraining) {
  NetworkTrainingOptions options = short_training();
  train(options, run());
  options.seed = 2;
  const NetworkTrainingRun again = run("net", Begin::from_checkpoint);
  EXPECT_THAT(error_of([&] { train(options, again); }),
              AllOf(HasSubstr("net.checkpoint"), HasSubstr("other options")));
  options = short_training();
  const CubeSamples more = made_up_samples(9);
  EXPECT_THAT(error_of([&] {
                train_network(small_network(), options, {}, {TrainingCrops{more}}, validation_, again);
              }),
              HasSubstr("another number of samples"));
  EXPECT_THAT(error_of([&] { train(options, run("none", Begin::from_checkpoint)); }),
              AllOf(HasSubstr("none.checkpoint"), HasSubstr("no such file")));
}

TEST_F(NetworkTraining, RefusesACheckpointWithoutMetrics) {
  train(short_training(), run());
  const std::filesystem::path file = folder_ / "net.checkpoint";
  const std::string format = "knuckle-network-checkpoint";
  const auto fault_with = [&](const std::vector<torch::Tensor>& metrics) {
    ArchiveReader whole(file, format, 2);
    ArchiveWriter changed(format, 2);
    changed.write("identity", whole.text("identity"));
    changed.write("step", whole.number("step"));
    for (const char* const part : {"parameters", "buffers", "averages", "moments"})
      changed.write(part, whole.tensors(part));
    changed.write("metrics", metrics);
    changed.save(file);
    return error_of([&] { train(short_training(), run("net", Begin::from_checkpoint)); });
  };
  const auto names_it = AllOf(HasSubstr("net.checkpoint"), HasSubstr("the metrics are missing"));
  EXPECT_THAT(fault_with({torch::zeros({1, 2}, torch::kDouble)}), names_it);
  EXPECT_THAT(fault_with({torch::zeros({9}, torch::kDouble)}), names_it);
  EXPECT_THAT(fault_with({}), names_it);
}

/// A worker that cannot reach the others.
class LonelyWorker final : public WorkerGroup {
 public:
  int rank() const override { return 0; }
  int size() const override { return 3; }
  std::vector<std::byte> exchange(Messages, const std::vector<std::int64_t>&) override {
    throw std::runtime_error("the others are lost");
  }
  double seconds_in_exchange() const override { return 0.0; }
  std::int64_t bytes_sent() const override { return 0; }
};

TEST_F(NetworkTraining, RefusesMoreWorkersThanShards) {
  LonelyWorker workers;
  NetworkTrainingRun shared = run();
  shared.workers = &workers;
  EXPECT_THAT(error_of([&] { train(short_training(), shared); }),
              HasSubstr("there are 3 workers for 2 shards"));
}

class TwoSetsOfSamples : public NetworkTraining, public ::testing::WithParamInterface<std::string_view> {
 protected:
  std::vector<TrainingMetrics> train(const NetworkTrainingRun& files, double weight = 0.5) const {
    NetworkOptions network = small_network();
    network.architecture = GetParam();
    return train_network(network, short_training(), {},
                         {TrainingCrops{training_}, TrainingCrops{own_, nullptr, weight}}, validation_,
                         files);
  }

  CubeSamples own_ = made_up_samples(2, 10.0);
};

INSTANTIATE_TEST_SUITE_P(, TwoSetsOfSamples, ::testing::Values("dense", "regression"),
                         [](const auto& instance) { return std::string(instance.param); });

TEST_P(TwoSetsOfSamples, GoOnFromACheckpointToTheSameBits) {
  EXPECT_EQ(train(run("whole")).back().step, 5) << "2 epochs of 10 samples, 4 a step";
  NetworkTrainingRun stopped = run("parts");
  stopped.stop_after_steps = 3;
  train(stopped);
  train(run("parts", Begin::from_checkpoint));
  expect_same_state("whole", "parts");
  EXPECT_THAT(error_of([&] { train(run("parts", Begin::from_checkpoint), 0.25); }),
              AllOf(HasSubstr("parts.checkpoint"), HasSubstr("other options")));
}

TEST_F(NetworkTraining, JointsThatAreNotKnownCountInNoValidation) {
  const auto with_changed_joint = [&](float value) {
    CubeSamples samples(3, testing::kTestJoints, testing::kTestCube, testing::kTestCropPx);
    for (std::int64_t i = 0; i < 3; ++i) {
      const CubeSample sample = validation_.sample(i);
      std::vector<float> joints(sample.joints.begin(), sample.joints.end());
      joints[3] = value;
      samples.set(i, {sample.codes, joints, sample.centre_mm});
    }
    samples.finish();
    return samples;
  };
  const auto validated = [&](const CubeSamples& validation, const std::string& name) {
    return train_network(small_network(), short_training(), {}, {TrainingCrops{training_}}, validation,
                         run(name))
        .front()
        .validation[kFirstLook];
  };
  const double whole = validated(validation_, "whole");
  const double without = validated(with_changed_joint(static_cast<float>(kNaN)), "without");
  const double wrong = validated(with_changed_joint(40.0F), "wrong");
  EXPECT_TRUE(std::isfinite(without));
  EXPECT_NEAR(without, whole, 0.2 * whole) << "the mean of the other 13";
  EXPECT_NE(without, whole);
  EXPECT_GT(wrong, 1.05 * whole);
}

TEST_F(NetworkTraining, TellsHowGoodItsBeginningIsAndHowLongItTakes) {
  const auto first = train(short_training(), run("first"));
  NetworkTrainingRun second = run("second");
  second.initial = folder_ / "first.pt";
  std::vector<double> begun;
  std::vector<double> left;
  second.report_initial = [&](const std::vector<double>& validation) { begun = validation; };
  second.report = [&](const std::vector<TrainingMetrics>&, double seconds_left) {
    left.push_back(seconds_left);
  };
  train(short_training(), second);
  const auto best =
      std::ranges::min_element(first, {}, [](const TrainingMetrics& m) { return m.validation[kSecondLook]; });
  ASSERT_EQ(begun.size(), 2u);
  EXPECT_NEAR(begun[kSecondLook], best->validation[kSecondLook], 0.05) << "in half precision";
  ASSERT_EQ(left.size(), 2u);
  EXPECT_GT(left[0], 0.0);
  EXPECT_EQ(left[1], 0.0);
}

TEST_F(NetworkTraining, ACheckpointThatIsCutShortIsRefusedByName) {
  train(short_training(), run());
  const std::string bytes = read_text_file(folder_ / "net.checkpoint");
  for (const double part : {0.0, 0.01, 0.5, 0.999}) {
    write_text_file(folder_ / "net.checkpoint",
                    bytes.substr(0, static_cast<std::size_t>(part * static_cast<double>(bytes.size()))));
    const std::string error = error_of([&] { train(short_training(), run("net", Begin::from_checkpoint)); });
    EXPECT_THAT(error, AllOf(HasSubstr("net.checkpoint"), HasSubstr("cut short"), Not(HasSubstr("\n"))))
        << part;
  }
}

TEST_F(NetworkTraining, ALossThatIsNotFiniteEndsItAndKeepsTheStateBefore) {
  NetworkTrainingOptions options = short_training();
  options.validate_every = 1;
  options.optimiser = "sgd";
  options.gradient_clip = 0.0;
  options.epochs = 1000;
  options.learning_rate = {.learning_rate = 5.0, .schedule = "constant", .warm_up = 0.0};
  NetworkOptions network = small_network();
  network.architecture = "regression";  // no batch norms, which would hold it together
  const std::string error = error_of([&] { train(options, run(), network); });
  const std::string mark = "keeps the state of step ";
  const std::size_t place = error.find(mark);
  ASSERT_NE(place, std::string::npos) << error;
  const std::string kept_step = error.substr(place + mark.size());
  EXPECT_GE(std::stoi(kept_step), 2);
  EXPECT_THAT(error, AllOf(HasSubstr("the loss is"), HasSubstr("at step " + kept_step + ","),
                           HasSubstr("net.checkpoint " + mark), Not(HasSubstr("\n"))));
  for (const torch::Tensor& tensor : state_of("net")) EXPECT_TRUE(torch::isfinite(tensor).all().item<bool>());
  EXPECT_NO_THROW(PoseNetwork(folder_ / "net.pt"));
}

TEST_F(NetworkTraining, StopsWhereValidationGetsNoBetter) {
  NetworkTrainingOptions options = short_training();
  options.epochs = 1000;
  options.validate_every = 1;
  options.patience = 2;
  options.learning_rate = {.learning_rate = 5.0, .schedule = "constant", .warm_up = 0.0};
  const auto metrics = train(options, run());
  ASSERT_LT(metrics.size(), 1000u);
  const auto best = std::ranges::min_element(
      metrics, {}, [](const TrainingMetrics& m) { return m.validation[kSecondLook]; });
  EXPECT_EQ(metrics.end() - best, 3) << "the best, and two that are no better";
  EXPECT_EQ(train(options, run("net", Begin::from_checkpoint)).size(), metrics.size()) << "it stays ended";
}

TEST_F(NetworkTraining, ReportsOnceMoreWhereItHasEnded) {
  train(short_training(), run());
  std::vector<std::int64_t> reported;
  NetworkTrainingRun again = run("net", Begin::from_checkpoint);
  again.report = [&](const std::vector<TrainingMetrics>& metrics, double seconds_left) {
    EXPECT_EQ(seconds_left, 0.0);
    for (const TrainingMetrics& m : metrics) reported.push_back(m.step);
  };
  train(short_training(), again);
  EXPECT_THAT(reported, ::testing::ElementsAre(2, 4)) << "it may have been killed before it reported step 4";
}

TEST_F(NetworkTraining, KeepsTheBestOrTheLastAsAsked) {
  NetworkTrainingOptions options = short_training();
  options.epochs = 1000;
  options.validate_every = 1;
  options.patience = 2;
  options.learning_rate = {.learning_rate = 5.0, .schedule = "constant", .warm_up = 0.0};
  for (const std::string keep : {"best", "last"}) {
    options.keep = keep;
    const auto metrics = train(options, run(keep));
    const auto best = std::ranges::min_element(
        metrics, {}, [](const TrainingMetrics& m) { return m.validation[kSecondLook]; });
    const TrainingMetrics& kept = keep == "last" ? metrics.back() : *best;
    ASSERT_GT(metrics.back().validation[kSecondLook], 1.1 * best->validation[kSecondLook]);
    NetworkTrainingRun next = run("next");
    next.initial = folder_ / (keep + ".pt");
    next.stop_after_steps = 1;
    std::vector<double> begun;
    next.report_initial = [&](const std::vector<double>& validation) { begun = validation; };
    train(short_training(), next);
    ASSERT_EQ(begun.size(), kept.validation.size());
    const double expected = kept.validation[kSecondLook];
    EXPECT_NEAR(begun[kSecondLook], expected, 0.01 * expected) << "but for half precision";
  }
}

TEST_F(NetworkTraining, EndsInTheTimeItIsGiven) {
  NetworkTrainingOptions options = short_training();
  options.epochs = 1e6;
  NetworkTrainingRun timed = run();
  timed.minutes = 0.5 / 60.0;
  const auto metrics = train(options, timed);
  EXPECT_GT(metrics.back().step, 0);
  EXPECT_LT(metrics.back().learning_rate, 0.05 * options.learning_rate.learning_rate);
}

TEST_F(NetworkTraining, ABatchMayBeLargerThanTheSetAndOneShardToo) {
  NetworkTrainingOptions options = short_training();
  options.batch_size = 20;
  options.epochs = 1;
  const auto metrics = train(options, run());
  ASSERT_EQ(metrics.size(), 1u);
  EXPECT_EQ(metrics.front().samples, 20);
}

TEST_F(NetworkTraining, RefusesOptionsThatDoNotFitTogether) {
  const auto fault = [&](auto change) {
    NetworkTrainingOptions options = short_training();
    change(options);
    return error_of([&] { train(options, run()); });
  };
  EXPECT_THAT(fault([](auto& o) { o.shards = 3; }),
              HasSubstr("batch_size is 4, expected a multiple of shards, 3"));
  EXPECT_THAT(fault([](auto& o) { o.batch_size = 0; }), HasSubstr("batch_size"));
  EXPECT_THAT(fault([](auto& o) { o.optimiser = "lion"; }), HasSubstr("lion"));
  EXPECT_THAT(fault([](auto& o) { o.precision = "half"; }), HasSubstr("half"));
  EXPECT_THAT(fault([](auto& o) { o.epochs = kNaN; }), HasSubstr("epochs"));
  EXPECT_THAT(fault([](auto& o) { o.learning_rate.warm_up = 2; }), HasSubstr("warm_up"));
  const CubeSamples none = made_up_samples(0);
  EXPECT_THAT(error_of([&] {
                train_network(small_network(), short_training(), {}, {TrainingCrops{none}}, validation_,
                              run());
              }),
              HasSubstr("no sample to train on"));
  EXPECT_THAT(error_of([&] {
                train_network(small_network(), short_training(), {}, {TrainingCrops{training_}}, none, run());
              }),
              HasSubstr("no sample to validate on"));
  EXPECT_FALSE(std::filesystem::exists(folder_ / "net.pt"));
}

/// Eight samples as if they were on a disk, in four runs.
class StreamedTraining : public NetworkTraining {
 protected:
  std::vector<TrainingMetrics> stream(const NetworkTrainingRun& files,
                                      const StreamingOptions& streaming) const {
    const std::vector<StreamedCrops> sets{
        {std::make_shared<testing::MemoryStream>(training_, std::vector<std::int64_t>{2, 3, 1, 2}), nullptr,
         1.0}};
    return train_network(small_network(), short_training(), {}, sets, streaming, validation_, files);
  }
};

TEST_F(StreamedTraining, HasTheWeightsOfMemoryWhereOneWindowHoldsTheSet) {
  train(short_training(), run("memory"));
  stream(run("streamed"), {.window = 8, .most_at_once = 4});
  expect_same_state("memory", "streamed");
  train(short_training(), run("memory", Begin::from_checkpoint));  // one and the same training
  stream(run("memory", Begin::from_checkpoint), {.window = 8});
}

TEST_F(StreamedTraining, GoesOnToTheSameBitsHoweverManySamplesAreReadAtOnce) {
  stream(run("whole"), {.window = 3, .most_at_once = 100});
  NetworkTrainingRun stopped = run("parts");
  stopped.stop_after_steps = 3;
  stream(stopped, {.window = 3, .most_at_once = 4});
  EXPECT_EQ(stream(run("parts", Begin::from_checkpoint), {.window = 3, .most_at_once = 1}).back().step, 4);
  expect_same_state("whole", "parts");
  stream(run("other"), {.window = 8});
  EXPECT_FALSE(torch::equal(state_of("other").front(), state_of("whole").front())) << "another order";
  EXPECT_THAT(error_of([&] { stream(run("parts", Begin::from_checkpoint), {.window = 4}); }),
              HasSubstr("other options"));
}

TEST_F(NetworkTraining, NamesADeviceThatIsNotThereAndAFileThatCannotBeWritten) {
  NetworkTrainingRun elsewhere = run();
  elsewhere.device = "abacus";
  EXPECT_THAT(error_of([&] { train(short_training(), elsewhere); }), HasSubstr("abacus"));
  if (!torch::cuda::is_available()) {
    elsewhere.device = "cuda";
    EXPECT_THAT(error_of([&] { train(short_training(), elsewhere); }), HasSubstr("device cuda:"));
  }
  NetworkTrainingRun nowhere = run();
  nowhere.model = "/proc/knuckle/net.pt";
  EXPECT_THAT(error_of([&] { train(short_training(), nowhere); }),
              AllOf(HasSubstr("/proc/knuckle"), Not(HasSubstr("\n"))));
}

TEST(MetricsCsv, HasOneLinePerValidation) {
  const std::vector<TrainingMetrics> metrics = {{.step = 2,
                                                 .samples = 8,
                                                 .learning_rate = 0.5,
                                                 .training_loss = 0.25,
                                                 .validation = {12.0, 11.5},
                                                 .samples_per_second = 100.0,
                                                 .waiting_share = 0.125}};
  EXPECT_EQ(
      metrics_csv(metrics, kPoseScoreNames),
      "step,samples,learning_rate,training_loss,validation_first_mm,validation_second_mm,samples_per_second,"
      "waiting_share\n2,8,0.5,0.25,12.000,11.500,100.0,0.1250\n");
}

}  // namespace
}  // namespace knuckle
