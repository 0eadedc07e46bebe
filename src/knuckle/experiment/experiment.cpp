// SPDX-License-Identifier: Apache-2.0
#include "knuckle/experiment/experiment.h"

#include <algorithm>

#include <fmt/format.h>

#include "knuckle/core/error.h"
#include "knuckle/core/file_io.h"
#include "knuckle/core/options.h"
#include "knuckle/data/source_spec.h"
#include "knuckle/eval/poses_file.h"
#include "knuckle/experiment/experiment_report.h"
#include "knuckle/experiment/step.h"
#include "knuckle/experiment/trainers.h"
#include "knuckle/pipeline/open_source.h"
#include "knuckle/pipeline/run.h"

namespace knuckle {
namespace {

/// A source as an input: what it is called, and the content of its file or folder.
void add_source(StepInputs& inputs, const std::string& source) {
  inputs.add("source", source).add_content("source content", parse_source_spec(source).path);
}

/// A pipeline file as an input, with the models that it names.
void add_pipeline(StepInputs& inputs, const std::filesystem::path& pipeline) {
  inputs.add_content("pipeline", pipeline);
  const OptionTable document = OptionTable::load(pipeline);
  for (const char* table : {"segmentation", "estimator"}) {
    const std::string model = document.table(table).text_or("model", "");
    if (!model.empty()) inputs.add_content(fmt::format("{} model", table), document.resolved_path(model));
  }
}

class Experiment {
 public:
  Experiment(const ExperimentPlan& plan, const ExperimentOptions& options) : plan_(plan), options_(options) {}

  std::filesystem::path run() const {
    for (const PlannedModel& model : plan_.models) provide(model);
    for (const PlannedMethod& method : plan_.segmentation) provide_pipeline(method);
    for (const PlannedMethod& method : plan_.estimation) provide_pipeline(method);
    for (const PlannedSequence& sequence : plan_.sequences) run_on(sequence);
    return report();
  }

 private:
  std::filesystem::path pipeline_of(const PlannedMethod& method) const {
    return options_.out / "pipelines" / method.pipeline.filename();
  }

  void provide(const PlannedModel& model) const {
    const std::filesystem::path out = options_.out / "models" / model.file;
    const std::filesystem::path trained = options_.models / model.file;
    StepInputs inputs;
    if (!options_.models.empty() && std::filesystem::exists(trained)) {
      inputs.add_content("trained", trained);
      run_step(out, inputs, [&] { copy_file(trained, out); });
      return;
    }
    inputs.add("kind", model.kind).add("scale", fmt::format("{}", options_.scale));
    inputs.add_content("config", model.config);
    add_source(inputs, training_source(model.kind, model.config));
    run_step(out, inputs, [&] {
      fmt::print("training {}\n", model.file);
      train_model(model.kind, model.config, options_.scale, out);
    });
  }

  void provide_pipeline(const PlannedMethod& method) const {
    const std::filesystem::path out = pipeline_of(method);
    run_step(out, StepInputs().add_content("pipeline", method.pipeline),
             [&] { copy_file(method.pipeline, out); });
  }

  static void copy_file(const std::filesystem::path& from, const std::filesystem::path& to) {
    write_file_atomically(to, [&](const std::filesystem::path& temporary) {
      std::filesystem::copy_file(from, temporary, std::filesystem::copy_options::overwrite_existing);
    });
  }

  void run_on(const PlannedSequence& sequence) const {
    const std::string source = scaled_source(sequence.source, options_.scale);
    for (const PlannedMethod& method : plan_.segmentation) segment(sequence, source, method);
    for (const PlannedMethod& method : plan_.estimation) estimate(sequence, source, method);
  }

  StepInputs inputs_of(const std::string& source, const PlannedMethod& method) const {
    StepInputs inputs;
    add_source(inputs, source);
    add_pipeline(inputs, pipeline_of(method));
    return inputs;
  }

  void segment(const PlannedSequence& sequence, const std::string& source,
               const PlannedMethod& method) const {
    const std::filesystem::path out = boxes_file(options_.out, sequence, method);
    run_step(out, inputs_of(source, method), [&] {
      fmt::print("{}: segmenting by {}\n", sequence.title, method.name);
      const HandFinder finder = HandFinder::load(pipeline_of(method));
      const std::vector<FrameSegmentation> frames =
          segment_all(*open_source(source), finder, Start::nearest, source);
      write_text_file(summary_file(out), summary_json(frames, source));
      write_text_file(out, boxes_csv(frames));
    });
  }

  void estimate(const PlannedSequence& sequence, const std::string& source,
                const PlannedMethod& method) const {
    const std::filesystem::path out = poses_file(options_.out, sequence, method);
    run_step(out, inputs_of(source, method), [&] {
      fmt::print("{}: estimating by {}\n", sequence.title, method.name);
      const Pipeline pipeline = Pipeline::load(pipeline_of(method));
      const std::vector<FrameEstimate> frames =
          estimate_all(*open_source(source), pipeline, Start::truth, source);
      write_text_file(summary_file(out), summary_json(frames, source, pipeline.convention()));
      write_poses_file(out, pipeline.convention(), poses_of(frames, pipeline.convention()));
    });
  }

  /// The page depends on all boxes and poses, and on the truth.
  std::filesystem::path report() const {
    StepInputs inputs;
    std::vector<std::string> sources;
    inputs.add("title", plan_.title);
    for (const PlannedSequence& sequence : plan_.sequences) {
      sources.push_back(scaled_source(sequence.source, options_.scale));
      add_source(inputs, sources.back());
      for (const PlannedMethod& method : plan_.segmentation) {
        inputs.add_content(method.name, boxes_file(options_.out, sequence, method));
      }
      for (const PlannedMethod& method : plan_.estimation) {
        inputs.add_content(method.name, poses_file(options_.out, sequence, method));
      }
    }
    std::filesystem::path page = options_.out / "report.html";
    run_step(page, inputs, [&] { write_experiment_report(plan_, sources, options_.out); });
    return page;
  }

  const ExperimentPlan& plan_;
  const ExperimentOptions& options_;
};

}  // namespace

std::filesystem::path run_experiment(const ExperimentPlan& plan, const ExperimentOptions& options) {
  if (!(options.scale > 0.0 && options.scale <= 1.0)) {
    fail("scale is {}, expected a part of all frames in (0, 1]", options.scale);
  }
  return Experiment(plan, options).run();
}

}  // namespace knuckle
