// SPDX-License-Identifier: Apache-2.0
#include "knuckle/training/detector_training.h"

#include <algorithm>
#include <cmath>

#include <torch/utils.h>

#include "knuckle/camera/projection.h"
#include "knuckle/core/parallel.h"
#include "knuckle/core/testing.h"
#include "knuckle/core/text_file.h"
#include "knuckle/segment/detector/detector_testing.h"
#include "knuckle/segment/detector/hand_detector.h"
#include "knuckle/segment/testing.h"
#include "knuckle/storage/file_io.h"
#include "knuckle/training/detector_network.h"
#include "knuckle/training/detector_training_task.h"
#include "knuckle/training/loss_gradient_testing.h"
#include "knuckle/training/training_testing.h"

namespace knuckle {
namespace {

using ::testing::AllOf;
using testing::error_of;
using ::testing::HasSubstr;
using testing::short_training;
using testing::small_detector;
using testing::TemporaryFolder;

/// A frame with a made-up hand (a palm, fingers and an arm) whose truth is its palm and three points beside
/// it.
Frame labelled_frame(std::uint64_t seed) {
  Random random(seed, 7);
  Frame frame = testing::blank_frame(testing::quarter_vga_camera());
  const Point3 palm(random.uniform(-120, 120), random.uniform(-90, 60), random.uniform(450, 800));
  testing::draw_hand(frame, palm, random);
  frame.side = HandSide::right;
  frame.truth = HandPose::missing(convention_from_name("knuckle22"));
  const Projection projection(frame.camera);
  for (const double x : {-60.0, 0.0, 60.0}) {
    frame.truth->joints[static_cast<std::size_t>(1 + x / 60.0)] = projection.to_image(palm + Point3(x, 0, 0));
  }
  return frame;
}

DetectorSamples detector_samples_of(const std::vector<Frame>& frames) {
  DetectorSamples samples(small_detector(), std::ssize(frames));
  for (std::size_t i = 0; i < frames.size(); ++i) {
    const DetectorView view(small_detector(), frames[i].camera);
    samples.set(static_cast<std::int64_t>(i), view.shrink(frames[i].depth_mm),
                hand_numbers(hands_to_detect(frames[i]), view));
  }
  return samples;
}

std::vector<Frame> labelled_frames(int count) {
  std::vector<Frame> frames;
  for (int i = 0; i < count; ++i) frames.push_back(labelled_frame(static_cast<std::uint64_t>(i)));
  frames.push_back(testing::blank_frame(testing::quarter_vga_camera()));  // without a hand
  return frames;
}

/// Two hands that count, one that does not, one place that is empty; then a frame without a hand.
torch::Tensor targets_of_two_frames() {
  torch::Tensor targets =
      torch::full({2, static_cast<int64_t>(kMostLabelledHands), kHandNumbers}, std::nan(""), torch::kDouble);
  const std::vector<std::vector<double>> hands = {{20.3, 17.1, 0.4, -0.1, 1.0, 1.0},
                                                  {41.6, 30.2, 0.1, 0.1, std::nan(""), 1.0},
                                                  {50.0, 9.0, 0.2, 0.0, 0.0, 0.0}};
  for (std::size_t i = 0; i < hands.size(); ++i) {
    targets[0][static_cast<int64_t>(i)] = torch::tensor(hands[i], torch::kDouble);
  }
  return targets;
}

TEST(DetectorLoss, HasTheGradientOfFiniteDifferences) {
  const auto network = make_detector_network(small_detector(), 1);
  network->to(torch::kDouble);
  torch::manual_seed(2);
  const torch::Tensor output = torch::randn({2, kDetectorMaps, 12, 16}, torch::kDouble);
  testing::expect_gradient_of_finite_differences(*network, {}, targets_of_two_frames(), output);
}

TEST(DetectorLoss, IsLeastWhereTheMapsSayTheTruth) {
  const auto network = make_detector_network(small_detector(), 1);
  const torch::Tensor targets = targets_of_two_frames();
  torch::Tensor output = torch::zeros({2, kDetectorMaps, 12, 16}, torch::kDouble);
  output.select(1, kHeatMap).fill_(-8.0);
  const double silent = network->loss(output, {}, targets).item<double>();
  for (const int hand : {0, 1}) {
    const auto number = [&](std::size_t which) {
      return targets[0][hand][static_cast<std::int64_t>(which)].item<double>();
    };
    const double u = (number(kHandU) - 1.5) / 4.0;
    const double v = (number(kHandV) - 1.5) / 4.0;
    for (int row = 0; row < 12; ++row) {
      for (int column = 0; column < 16; ++column) {
        if (std::hypot(column - std::round(u), row - std::round(v)) > 3.0) continue;
        output[0][kOffsetUMap][row][column] = u - column;
        output[0][kOffsetVMap][row][column] = v - row;
        output[0][kInverseDepthMap][row][column] = number(kHandInverseDepth);
        output[0][kExtentMap][row][column] = number(kHandExtent);
        output[0][kSideMap][row][column] = 8.0;
      }
    }
    output[0][kHeatMap][static_cast<int64_t>(std::round(v))][static_cast<int64_t>(std::round(u))] = 8.0;
  }
  const double told = network->loss(output, {}, targets).item<double>();
  EXPECT_LT(told, 0.01);
  EXPECT_GT(silent, 1.0);
  torch::Tensor excused = output.clone();
  excused[0][kHeatMap][2][12] = 8.0;  // the hand that does not count
  EXPECT_NEAR(network->loss(excused, {}, targets).item<double>(), told, 1e-9);
  torch::Tensor invented = output.clone();
  invented[1][kHeatMap][2][12] = 8.0;
  EXPECT_GT(network->loss(invented, {}, targets).item<double>(), told + 1.0);
}

TEST(DetectorLoss, TheSideCountsAsMuchAsIsSaid) {
  torch::manual_seed(2);
  const torch::Tensor output = torch::randn({2, kDetectorMaps, 12, 16}, torch::kDouble);
  const auto loss = [&](double weight) {
    DetectorOptions options = small_detector();
    options.side_weight = weight;
    return make_detector_network(options, 1)->loss(output, {}, targets_of_two_frames()).item<double>();
  };
  EXPECT_GT(loss(1.0), loss(0.0) + 0.01);
  EXPECT_NEAR(loss(6.0) - loss(0.0), 6.0 * (loss(1.0) - loss(0.0)), 1e-9);
}

/// Weights of half precision, and batch norms as a training leaves them.
void make_detector_like_trained(DetectorNetwork& network) {
  const torch::NoGradGuard no_gradient;
  torch::manual_seed(5);
  for (const auto& item : network.named_parameters()) {
    torch::Tensor parameter = item.value();
    if (item.key().ends_with("norm.weight")) parameter.uniform_(0.5, 1.5);
    if (item.key().ends_with(".bias")) parameter.uniform_(-0.2, 0.2);
    if (item.key() == "head.weight") parameter.normal_(0.0, 0.1);
    parameter.copy_(parameter.to(torch::kHalf).to(torch::kFloat));
  }
  for (const auto& item : network.named_buffers()) {
    torch::Tensor buffer = item.value();
    if (item.key().ends_with("running_mean")) buffer.uniform_(-0.5, 0.5);
    if (item.key().ends_with("running_var")) buffer.uniform_(0.3, 3.0);
  }
  network.eval();
}

const std::string kDemo = "synthetic:manifests/demo.toml";

/// Views are the samples themselves.
constexpr DetectorAugmentation kAsTheyAre{.mirrored_share = 0,
                                          .zoom = 0,
                                          .shift_cells = 0,
                                          .rotation_deg = 0,
                                          .noise_per_m = 0,
                                          .missing_share = 0,
                                          .erased_discs = 0,
                                          .erased_cells = 0,
                                          .cut_share = 0};

TEST(DetectorAnswers, AreTheSameInTrainingAndInUse) {
  DetectorOptions odd = small_detector();
  odd.width = 80;
  odd.height = 16;
  odd.stem_channels = 1;
  odd.eighth_channels = 17;
  odd.head_channels = 5;
  odd.blocks = 2;
  DetectorOptions with_relief = odd;
  with_relief.relief = true;
  for (const DetectorOptions& options : {DetectorOptions{}, small_detector(), odd, with_relief}) {
    const TemporaryFolder folder;
    const auto network = make_detector_network(options, 3);
    make_detector_like_trained(*network);
    const Frame frame = labelled_frame(4);
    DetectorSamples samples(options, 1);
    samples.set(0, DetectorView(options, frame.camera).shrink(frame.depth_mm), {});
    const auto views = std::make_shared<const DetectorSampleViews>(samples, kAsTheyAre);
    DetectorTrainingTask(options, {}, views, samples).save(folder / "hands.pt", *network);
    const HandDetector in_use(load_detector_weights(folder / "hands.pt"));
    torch::Tensor inputs = torch::empty({1, options.inputs(), options.height, options.width});
    LabelledHands hands;
    Random random(1);
    const auto numbers = static_cast<std::size_t>(inputs.numel());
    views->view(0, random, std::span(inputs.data_ptr<float>(), numbers), hands);
    DetectorInput input{Image<float>(options.width, options.height),
                        Image<float>(options.width, options.height)};
    std::copy_n(inputs[0][0].data_ptr<float>(), input.inverse_depth.size(), input.inverse_depth.data());
    std::copy_n(inputs[0][1].data_ptr<float>(), input.measured_share.size(), input.measured_share.data());
    const torch::NoGradGuard no_gradient;
    const DetectorMaps expected = maps_of_sample(network->forward(inputs), 0);
    const DetectorMaps found = in_use.maps_of(input);
    ASSERT_EQ(found.values.size(), expected.values.size());
    float largest = 0.0f;
    for (std::size_t i = 0; i < found.values.size(); ++i) {
      EXPECT_NEAR(found.values[i], expected.values[i], 1e-3);
      largest = std::max(largest, std::abs(found.values[i]));
    }
    EXPECT_GT(largest, 0.05f) << "it says something";
  }
}

class DetectorTraining : public ::testing::Test {
 protected:
  ~DetectorTraining() override { set_thread_count(0); }

  std::vector<TrainingMetrics> train(const NetworkTrainingOptions& options,
                                     const NetworkTrainingRun& run) const {
    return train_detector(small_detector(), options, {}, samples_, samples_, run);
  }
  std::string bytes_of(const std::string& name) const { return read_text_file(folder_ / name); }

  TemporaryFolder folder_;
  DetectorSamples samples_ = detector_samples_of(labelled_frames(7));
};

TEST_F(DetectorTraining, GivesTheSameBytesOnAnyNumberOfThreadsAndAfterAStop) {
  set_thread_count(1);
  train(short_training(), testing::run_in(folder_.path(), "one"));
  set_thread_count(2);
  train(short_training(), testing::run_in(folder_.path(), "two"));
  EXPECT_EQ(bytes_of("one.pt"), bytes_of("two.pt"));
  NetworkTrainingRun stopped = testing::run_in(folder_.path(), "parts");
  stopped.stop_after_steps = 3;
  EXPECT_EQ(train(short_training(), stopped).back().step, 3);
  NetworkTrainingRun resumed = testing::run_in(folder_.path(), "parts");
  resumed.begin = NetworkTrainingRun::Begin::from_checkpoint;
  const auto metrics = train(short_training(), resumed);
  EXPECT_EQ(metrics.back().step, 4);
  ASSERT_EQ(metrics.front().validation.size(), std::size_t{kDetectorScores}) << "kept from before the stop";
  // The best model may be an earlier one, so the last states are compared by going on from them.
  EXPECT_THAT(metrics.back().validation,
              ::testing::Pointwise(::testing::NanSensitiveDoubleEq(),
                                   train(short_training(), resumed).back().validation));
}

TEST_F(DetectorTraining, OfFramesThatAreReadWhenNeededGivesTheBytesOfMemory) {
  const DetectorFrames frames(std::vector<DetectorSource>{{kDemo, 7}}, small_detector());
  const DetectorSamples in_memory = samples_of(frames);
  train_detector(small_detector(), short_training(), {}, in_memory, samples_,
                 testing::run_in(folder_.path(), "memory"));
  for (const int at_once : {1, 3, 100}) {
    const std::string name = fmt::format("streamed_{}", at_once);
    train_detector(small_detector(), short_training(), {}, frames, at_once, samples_,
                   testing::run_in(folder_.path(), name));
    EXPECT_EQ(bytes_of(name + ".pt"), bytes_of("memory.pt")) << at_once;
  }
}

TEST(StreamedDetectorViews, AreThoseOfMemoryWhereverTheyAreAskedFor) {
  const DetectorFrames frames(std::vector<DetectorSource>{{kDemo, 5}}, small_detector());
  const DetectorSamples in_memory = samples_of(frames);
  const DetectorSampleViews expected(in_memory, {});
  const StreamedDetectorViews streamed(frames, {}, 2);
  EXPECT_EQ(streamed.size(), 5);
  EXPECT_EQ(streamed.most_at_once(), 2);
  const std::vector<std::int64_t> asked = {4, 1, 1};
  const std::shared_ptr<const SampleViews> some = streamed.fetched(asked);
  EXPECT_EQ(some->size(), 2);
  const auto view_of = [&](const SampleViews& views, std::int64_t index) {
    std::vector<float> numbers(kMeasuredInputs * 64 * 48 + kMostLabelledHands * kHandNumbers);
    const std::size_t inputs = numbers.size() - kMostLabelledHands * kHandNumbers;
    Random random(9);
    views.view(index, random, std::span(numbers).first(inputs), std::span(numbers).subspan(inputs));
    return numbers;
  };
  for (const std::int64_t index : {1, 4}) {
    EXPECT_THAT(view_of(*some, index),
                ::testing::Pointwise(::testing::NanSensitiveFloatEq(), view_of(expected, index)));
    EXPECT_THAT(view_of(streamed, index),
                ::testing::Pointwise(::testing::NanSensitiveFloatEq(), view_of(expected, index)));
  }
  EXPECT_THAT(error_of([&] { view_of(*some, 2); }), HasSubstr("sample 2 was not fetched"));
}

TEST_F(DetectorTraining, LearnsToFindMadeUpHands) {
  NetworkTrainingOptions options = short_training();
  options.epochs = 250;
  options.batch_size = 8;
  options.shards = 1;
  options.validate_every = 125;
  options.learning_rate.learning_rate = 1e-2;
  options.average_decay = 0.9;
  const auto metrics = train_detector(small_detector(), options, kAsTheyAre, samples_, samples_,
                                      testing::run_in(folder_.path(), "hands"));
  EXPECT_LT(metrics.back().training_loss, metrics.front().training_loss);
  EXPECT_GE(metrics.back().validation[kRecall], 0.99);
  EXPECT_LE(metrics.back().validation[kFalsePositives], 0.01);
  const HandDetector detector(load_detector_weights(folder_ / "hands.pt"));
  const Frame frame = labelled_frame(2);
  const std::vector<DetectedHand> hands = detector.detect(frame, {});
  ASSERT_EQ(hands.size(), 1u);
  const HandToDetect truth = hands_to_detect(frame).at(0);
  EXPECT_LT((hands[0].centre - truth.centre).norm(), 40.0);
  EXPECT_NEAR(hands[0].extent_mm, truth.extent_mm, 20.0);
}

TEST_F(DetectorTraining, BeginsWithAModelOfItsKindAlone) {
  train(short_training(), testing::run_in(folder_.path(), "first"));
  NetworkTrainingRun second = testing::run_in(folder_.path(), "second");
  second.initial = folder_ / "first.pt";
  EXPECT_NO_THROW(train(short_training(), second));
  DetectorOptions other = small_detector();
  other.side_weight = 3.0;
  EXPECT_NO_THROW(train_detector(other, short_training(), {}, samples_, samples_, second));
  other.head_channels = 24;
  EXPECT_THAT(error_of([&] { train_detector(other, short_training(), {}, samples_, samples_, second); }),
              AllOf(HasSubstr("first.pt"), HasSubstr("[network] differs")));
  second.initial = "models/dense.pt";
  EXPECT_THAT(error_of([&] { train(short_training(), second); }),
              AllOf(HasSubstr("dense.pt"), HasSubstr("knuckle-network"), HasSubstr("knuckle-detector")));
}

TEST_F(DetectorTraining, NeedsSamplesAndRoomForThem) {
  const DetectorSamples none(small_detector(), 0);
  const NetworkTrainingRun run = testing::run_in(folder_.path(), "none");
  EXPECT_THAT(error_of([&] { train_detector(small_detector(), short_training(), {}, none, samples_, run); }),
              HasSubstr("no sample to train on"));
  EXPECT_THAT(error_of([&] { train_detector(small_detector(), short_training(), {}, samples_, none, run); }),
              HasSubstr("no sample to validate on"));
  DetectorTrainingConfig config;
  config.sources = {{kDemo, 1}, {kDemo, 1}};
  config.validation = {kDemo, 1};
  config.samples.memory_gb = 1e-6;
  EXPECT_THAT(error_of([&] { run_detector_training(config, run); }),
              AllOf(HasSubstr("3 samples take"), HasSubstr("more than memory_gb, 1e-06")));
  config.samples.stream = true;
  EXPECT_THAT(error_of([&] { run_detector_training(config, run); }),
              HasSubstr("1 samples of the validation and two batches of"));
}

TEST(DetectionCounts, OfHandsFoundMissedAndInvented) {
  const DetectorOptions options;
  const DetectorView view(options, camera_of_picture(options));
  EXPECT_EQ(view.scale(), 1.0);
  const std::vector<HandToDetect> truth = {{Point3(-100, 0, 600), 80.0, HandSide::right, true},
                                           {Point3(120, 0, 600), 80.0, HandSide::left, true},
                                           {Point3(0, 150, 700), 80.0, std::nullopt, false}};
  const LabelledHands hands = hand_numbers(truth, view);
  const auto seen = [](const Point3& centre, HandSide side) {
    return DetectedHand{.centre = centre, .extent_mm = 80.0, .score = 0.9, .side = side};
  };
  const DetectionCounts counts = counts_of({seen({-80, 0, 600}, HandSide::right),   // found
                                            seen({-100, 30, 600}, HandSide::left),  // the same once more
                                            seen({120, 0, 590}, HandSide::right),   // the wrong side
                                            seen({0, 160, 760}, HandSide::left),    // excused
                                            seen({0, 0, 1500}, HandSide::left)},    // nothing
                                           hands, view);
  EXPECT_EQ(counts.hands, 2);
  EXPECT_EQ(counts.found, 2);
  EXPECT_EQ(counts.invented, 2);
  EXPECT_EQ(counts.sides_known, 2);
  EXPECT_EQ(counts.sides_right, 1);
  EXPECT_NEAR(counts.distance_mm, 30.0, 1e-3);
  const std::vector<double> scores = counts.scores();
  EXPECT_EQ(scores[kRecall], 1.0);
  EXPECT_EQ(scores[kFalsePositives], 2.0);
  EXPECT_EQ(scores[kSideAccuracy], 0.5);
  EXPECT_EQ(scores[kMistakes], 1.5);
  EXPECT_EQ(DetectionCounts{}.scores()[kMistakes], 0.0) << "finite without any hand";
}

TEST(DetectorTrainingConfig, IsReadStrictly) {
  EXPECT_TRUE(is_of_detector("pipelines/train_detector.toml"));
  EXPECT_FALSE(is_of_detector("pipelines/train_dense.toml"));
  EXPECT_NO_THROW(DetectorTrainingConfig::load("pipelines/train_detector.toml"));
  const TemporaryFolder folder;
  const auto fault = [&](const std::string& text) {
    write_text_file(folder / "c.toml",
                    "source = 'synthetic:a.toml'\nvalidation = 'synthetic:a.toml'\n" + text);
    return error_of([&] { DetectorTrainingConfig::load(folder / "c.toml"); });
  };
  EXPECT_THAT(fault("[network]\narchitecture = 'detector'\nwidth = 40"), HasSubstr("multiples of 16"));
  EXPECT_THAT(fault("[network]\nkernel = 2"), AllOf(HasSubstr("c.toml:4"), HasSubstr("kernel")));
  EXPECT_THAT(fault("[augmentation]\nzoom = 3"), HasSubstr("zoom"));
  EXPECT_THAT(fault("[patch]\nsize_px = 3"), HasSubstr("patch"));
}

TEST(DetectorTrainingConfig, TakesSeveralSources) {
  const TemporaryFolder folder;
  const auto load = [&](const std::string& text) {
    write_text_file(folder / "c.toml", text);
    return DetectorTrainingConfig::load(folder / "c.toml");
  };
  const std::string validation = "validation = 'synthetic:v.toml'\n";
  const std::string most = "[samples]\nmost = 9\nmost_validation = 4\n";
  const DetectorTrainingConfig config =
      load(validation +
           "[[source]]\nsource = 'folder:a'\n[[source]]\nsource = 'synthetic:b.toml'\nmost = 3\n" + most);
  ASSERT_EQ(config.sources.size(), 2U);
  EXPECT_THAT(config.sources[0].source, ::testing::EndsWith("/a"));
  EXPECT_EQ(config.sources[0].most, 9);
  EXPECT_THAT(config.sources[1].source, ::testing::EndsWith("/b.toml"));
  EXPECT_EQ(config.sources[1].most, 3);
  EXPECT_EQ(config.validation.most, 4);
  const DetectorTrainingConfig one = load("source = 'folder:a'\n" + validation + most);
  ASSERT_EQ(one.sources.size(), 1U);
  EXPECT_EQ(one.sources[0].most, 9);
  EXPECT_THAT(error_of([&] { load(validation); }), HasSubstr("source"));
  EXPECT_THAT(error_of([&] { load("source = 3\n" + validation); }), HasSubstr("a table [[source]] for each"));
  EXPECT_THAT(error_of([&] { load(validation + "[[source]]\nsource = 'folder:a'\nmost = -1\n"); }),
              HasSubstr("most"));
  EXPECT_THAT(error_of([&] { load(validation + "[[source]]\nsource = 'folder:a'\nweight = 2\n"); }),
              HasSubstr("weight"))
      << "each frame counts once";
}

}  // namespace
}  // namespace knuckle
