// SPDX-License-Identifier: Apache-2.0
#include "knuckle/experiment/scores.h"

#include "knuckle/data/boxes_file.h"
#include "knuckle/experiment/run_summary.h"
#include "knuckle/prepare/open_source.h"

namespace knuckle {
namespace {

constexpr GalleryOptions kGallery{.even_frames = 4, .worst_frames = 1};

class SequenceScorer {
 public:
  SequenceScorer(const ExperimentPlan& plan, const PlannedSequence& sequence, const std::string& source_name,
                 const ExperimentFolder& folder)
      : plan_(plan),
        sequence_(sequence),
        folder_(folder),
        source_(open_source(source_name)),
        truth_(truth_from_source(*source_, source_name)) {}

  SequenceScores score() {
    scores_.name = sequence_.name;
    scores_.title = sequence_.title;
    for (const PlannedMethod& method : plan_.segmentation) add_segmentation(method);
    if (!plan_.estimation.empty()) add_estimations();
    return std::move(scores_);
  }

 private:
  void add_segmentation(const PlannedMethod& method) {
    const std::filesystem::path file = folder_.boxes(sequence_, method);
    const SegmentationSummary summary = read_segmentation_summary(ExperimentFolder::summary(file));
    scores_.segmentation.push_back(score_boxes(method.name, read_boxes_file(file), truth_.sequence.poses));
    scores_.mask_iou.push_back(summary.mask_iou);
    scores_.segmentation_ms.push_back(summary.median_ms);
  }

  void add_estimations() {
    std::vector<Predictions> predictions;
    for (const PlannedMethod& method : plan_.estimation) {
      const std::filesystem::path file = folder_.poses(sequence_, method);
      predictions.push_back({method.name, read_poses_file(file)});
      scores_.estimation_ms.push_back(read_inference_ms(ExperimentFolder::summary(file)));
    }
    for (HandPose& pose : truth_.sequence.poses) pose = converted(pose, plan_.convention);
    truth_.sequence.convention = plan_.convention;
    scores_.evaluation = evaluate(truth_, predictions);
    scores_.gallery = make_gallery({source_.get(), &truth_, &*scores_.evaluation, predictions}, kGallery);
  }

  const ExperimentPlan& plan_;
  const PlannedSequence& sequence_;
  const ExperimentFolder& folder_;
  std::unique_ptr<FrameSource> source_;
  Truth truth_;
  SequenceScores scores_;
};

}  // namespace

ExperimentScores scored(const ExperimentPlan& plan, std::span<const std::string> sources,
                        const ExperimentFolder& folder) {
  ExperimentScores scores;
  for (std::size_t i = 0; i < plan.sequences.size(); ++i) {
    scores.sequences.push_back(SequenceScorer(plan, plan.sequences[i], sources[i], folder).score());
  }
  for (const PlannedModel& model : plan.models) {
    scores.trainings.push_back(read_training_record(folder.model(model)));
  }
  return scores;
}

}  // namespace knuckle
