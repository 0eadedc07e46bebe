// SPDX-License-Identifier: Apache-2.0
#include "knuckle/experiment/experiment.h"

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "knuckle/core/error.h"
#include "knuckle/core/options.h"
#include "knuckle/data/poses_file.h"
#include "knuckle/experiment/check_model.h"
#include "knuckle/experiment/experiment_step.h"
#include "knuckle/experiment/layout.h"
#include "knuckle/experiment/report_page.h"
#include "knuckle/experiment/scale.h"
#include "knuckle/experiment/step_jobs.h"
#include "knuckle/experiment/training_config.h"
#include "knuckle/experiment/training_record.h"
#include "knuckle/pipeline/estimate_all.h"
#include "knuckle/pipeline/estimate_summary.h"
#include "knuckle/pipeline/segment_all.h"
#include "knuckle/pipeline/stopwatch.h"
#include "knuckle/prepare/open_source.h"
#include "knuckle/storage/file_io.h"

namespace knuckle {
namespace {

void copy_whole_file(const std::filesystem::path& from, const std::filesystem::path& to) {
  write_file_atomically(to, [&](const std::filesystem::path& temporary) {
    std::filesystem::copy_file(from, temporary, std::filesystem::copy_options::overwrite_existing);
  });
}

class Experiment {
 public:
  Experiment(const ExperimentPlan& plan, const ExperimentOptions& options)
      : plan_(plan), options_(options), folder_(options.out) {
    options_.training.cache = folder_.samples();
  }

  /// All steps, each after those that it needs. They live no longer than this.
  std::vector<ExperimentStep> steps() const {
    std::vector<ExperimentStep> steps;
    for (const PlannedMethod& method : plan_.segmentation) steps.push_back(pipeline_step(method));
    for (const PlannedMethod& method : plan_.estimation) steps.push_back(pipeline_step(method));
    // Those that are given come first: a wrong one is found before hours of training.
    for (const PlannedModel& model : plan_.models) {
      if (!given(model).empty()) steps.push_back(given_step(model));
    }
    for (const PlannedModel& model : plan_.models) {
      if (given(model).empty()) steps.push_back(training_step(model));
    }
    for (const PlannedSequence& sequence : plan_.sequences) {
      for (const PlannedMethod& method : plan_.segmentation) steps.push_back(boxes_step(sequence, method));
      for (const PlannedMethod& method : plan_.estimation) steps.push_back(poses_step(sequence, method));
    }
    std::vector<std::string> all;
    for (const ExperimentStep& step : steps) all.push_back(step.name);
    steps.push_back(report_step(std::move(all)));
    return steps;
  }

  std::filesystem::path report() const { return folder_.report(); }

 private:
  /// A step without work; it is named by its output.
  ExperimentStep step_of(const std::filesystem::path& output, std::string title) const {
    ExperimentStep step;
    step.name = output.lexically_relative(folder_.path()).string();
    step.output = output;
    step.title = std::move(title);
    return step;
  }

  /// Copies a pipeline to where its models are found as `../models/FILE`.
  ExperimentStep pipeline_step(const PlannedMethod& method) const {
    check_models_of(method);
    ExperimentStep step = step_of(folder_.pipeline(method), "");
    step.is_copy = true;
    step.inputs = [&method] { return Inputs().add_content("pipeline", method.pipeline); };
    step.work = [this, &method](StepStart) { copy_whole_file(method.pipeline, folder_.pipeline(method)); };
    return step;
  }

  /// A pipeline names models of the plan, or such as are there.
  void check_models_of(const PlannedMethod& method) const {
    const OptionTable document = OptionTable::load(method.pipeline);
    for (const char* key : {"segmentation", "estimator"}) {
      const OptionTable table = document.table(key);
      const std::filesystem::path model = table.text_or("model", "");
      if (model.empty()) continue;
      const std::filesystem::path place = (folder_.pipeline(method).parent_path() / model).lexically_normal();
      const bool is_planned = std::ranges::any_of(plan_.models, [&](const PlannedModel& planned) {
        return folder_.model(planned).lexically_normal() == place;
      });
      if (!is_planned && !std::filesystem::exists(place)) {
        table.fail_at("model",
                      fmt::format("{} is no [[model]] of the experiment {}", model.string(), plan_.name));
      }
    }
  }

  /// The trained file that is used instead of a training; empty where there is none.
  std::filesystem::path given(const PlannedModel& model) const {
    std::filesystem::path found = options_.models / model.file;
    if (!options_.models.empty() && std::filesystem::exists(found)) return found;
    return model.trained;
  }

  ExperimentStep given_step(const PlannedModel& model) const {
    ExperimentStep step = step_of(folder_.model(model), "");
    step.is_copy = true;
    const std::filesystem::path from = given(model);
    step.inputs = [&model, from] {
      Inputs inputs;
      inputs.add("given", from.string()).add_content("model", from).add_content("config", model.config);
      return inputs.add_content_if_there("metrics", ExperimentFolder::metrics(from));
    };
    step.work = [this, &model](StepStart) { take(model); };
    return step;
  }

  void take(const PlannedModel& model) const {
    const std::filesystem::path from = given(model);
    const std::filesystem::path out = folder_.model(model);
    check_model(model.kind, model.config, from);
    copy_whole_file(from, out);
    std::filesystem::remove(ExperimentFolder::metrics(out));
    if (std::filesystem::exists(ExperimentFolder::metrics(from))) {
      copy_whole_file(ExperimentFolder::metrics(from), ExperimentFolder::metrics(out));
    }
    write_given_record(out, from);
  }

  ExperimentStep training_step(const PlannedModel& model) const {
    const std::filesystem::path out = folder_.model(model);
    const ScaledTraining training =
        write_scaled_training(model.kind, model.config, options_.scale, folder_.training_config(model));
    ExperimentStep step = step_of(out, fmt::format("training {}", model.file));
    step.is_training = true;
    step.needs = steps_that_make(training.models);
    step.inputs = [&model, training] {
      Inputs inputs;
      inputs.add("kind", model.kind).add_content("config", training.config);
      for (const std::string& source : training.sources) inputs.add_source("source", source);
      for (const std::filesystem::path& file : training.models) inputs.add_content("model", file);
      return inputs;
    };
    step.work = [this, &model, training](StepStart start) { train(model, training, start); };
    step.tidy = [out] { remove_training_checkpoint(out); };
    return step;
  }

  void train(const PlannedModel& model, const ScaledTraining& training, StepStart start) const {
    const std::filesystem::path out = folder_.model(model);
    const Stopwatch watch;
    std::filesystem::remove(ExperimentFolder::training_record(out));
    train_model(model.kind, training.config, options_.training, start, out);
    write_trained_record(out, watch.milliseconds() / 1000.0);
  }

  /// The names of the steps that make those of the files that the experiment makes.
  std::vector<std::string> steps_that_make(const std::vector<std::filesystem::path>& models) const {
    std::vector<std::string> names;
    for (const PlannedModel& planned : plan_.models) {
      const std::filesystem::path out = folder_.model(planned);
      const bool is_named = std::ranges::any_of(models, [&](const std::filesystem::path& model) {
        return std::filesystem::absolute(model).lexically_normal() ==
               std::filesystem::absolute(out).lexically_normal();
      });
      if (is_named) names.push_back(step_of(out, "").name);
    }
    return names;
  }

  /// The copy of the pipeline, and the models that it names.
  std::vector<std::string> needs_of(const PlannedMethod& method) const {
    const std::filesystem::path copy = folder_.pipeline(method);
    std::vector<std::filesystem::path> models;
    for (const PipelineModel& model : models_named_in(OptionTable::load(method.pipeline)))
      models.push_back(copy.parent_path() / model.file);
    std::vector<std::string> needs = steps_that_make(models);
    needs.push_back(step_of(copy, "").name);
    return needs;
  }

  std::string source_of(const PlannedSequence& sequence) const {
    return scaled_test_source(sequence.source, options_.scale);
  }

  Inputs inputs_of(const PlannedSequence& sequence, const PlannedMethod& method) const {
    return Inputs().add_source("source", source_of(sequence)).add_pipeline(folder_.pipeline(method));
  }

  ExperimentStep boxes_step(const PlannedSequence& sequence, const PlannedMethod& method) const {
    ExperimentStep step = step_of(folder_.boxes(sequence, method),
                                  fmt::format("{}: segmenting by {}", sequence.title, method.name));
    step.needs = needs_of(method);
    step.inputs = [this, &sequence, &method] { return inputs_of(sequence, method); };
    step.work = [this, &sequence, &method](StepStart) { segment(sequence, method); };
    return step;
  }

  void segment(const PlannedSequence& sequence, const PlannedMethod& method) const {
    const std::filesystem::path out = folder_.boxes(sequence, method);
    const std::string source = source_of(sequence);
    const HandFinder finder = HandFinder::load(folder_.pipeline(method));
    const std::vector<FrameSegmentation> frames =
        segment_all(*open_source(source), finder, Start::nearest, source);
    write_text_file(ExperimentFolder::summary(out), summary_json(frames, source));
    write_text_file(out, boxes_csv(frames));
  }

  ExperimentStep poses_step(const PlannedSequence& sequence, const PlannedMethod& method) const {
    ExperimentStep step = step_of(folder_.poses(sequence, method),
                                  fmt::format("{}: estimating by {}", sequence.title, method.name));
    step.needs = needs_of(method);
    step.inputs = [this, &sequence, &method] { return inputs_of(sequence, method); };
    step.work = [this, &sequence, &method](StepStart) { estimate(sequence, method); };
    return step;
  }

  void estimate(const PlannedSequence& sequence, const PlannedMethod& method) const {
    const std::filesystem::path out = folder_.poses(sequence, method);
    const std::string source = source_of(sequence);
    const Pipeline pipeline = Pipeline::load(folder_.pipeline(method));
    const std::vector<FrameEstimate> frames =
        estimate_all(*open_source(source), pipeline, Start::truth, source);
    write_text_file(ExperimentFolder::summary(out), summary_json(frames, source, pipeline.convention()));
    write_poses_file(out, pipeline.convention(), poses_of(frames, pipeline.convention()));
  }

  ExperimentStep report_step(std::vector<std::string> all_others) const {
    ExperimentStep step = step_of(folder_.report(), "writing the report");
    step.needs = std::move(all_others);
    step.inputs = [this] { return inputs_of_report(); };
    step.work = [this](StepStart) {
      write_experiment_report(plan_, test_sources(), options_.scale, folder_);
    };
    return step;
  }

  std::vector<std::string> test_sources() const {
    std::vector<std::string> sources;
    for (const PlannedSequence& sequence : plan_.sequences) sources.push_back(source_of(sequence));
    return sources;
  }

  /// The page depends on all models, boxes and poses, and on the truth.
  Inputs inputs_of_report() const {
    Inputs inputs;
    inputs.add("title", plan_.title).add("convention", plan_.convention.name).add("claims", plan_.claims);
    inputs.add("scale", fmt::format("{}", options_.scale));
    for (const PlannedModel& model : plan_.models) {
      const std::filesystem::path file = folder_.model(model);
      inputs.add_content(model.file, ExperimentFolder::training_record(file));
      inputs.add_content_if_there(model.file + " metrics", ExperimentFolder::metrics(file));
    }
    for (const PlannedSequence& sequence : plan_.sequences) {
      inputs.add_source(sequence.title, source_of(sequence));
      for (const PlannedMethod& method : plan_.segmentation) {
        inputs.add_content(method.name, folder_.boxes(sequence, method));
      }
      for (const PlannedMethod& method : plan_.estimation) {
        inputs.add_content(method.name, folder_.poses(sequence, method));
      }
    }
    return inputs;
  }

  const ExperimentPlan& plan_;
  ExperimentOptions options_;
  ExperimentFolder folder_;
};

void check(const ExperimentOptions& options) {
  if (!(options.scale > 0.0 && options.scale <= 1.0)) {
    fail("scale is {}, expected a part of the whole in (0, 1]", options.scale);
  }
  if (!options.models.empty() && !std::filesystem::is_directory(options.models)) {
    fail("{}: not a folder of trained models", options.models.string());
  }
  if (options.training.workers < 1) {
    fail("workers is {}, expected at least 1", options.training.workers);
  }
}

}  // namespace

std::filesystem::path run_experiment(const ExperimentPlan& plan, const ExperimentOptions& options) {
  check(options);
  const Experiment experiment(plan, options);
  for (const ExperimentStep& step : experiment.steps()) run_here(step);
  return experiment.report();
}

std::filesystem::path run_experiment_as_jobs(const ExperimentPlan& plan, const ExperimentOptions& options,
                                             JobQueue& queue, int most_jobs) {
  check(options);
  const Experiment experiment(plan, options);
  StepJobsOptions jobs;
  jobs.most = most_jobs;
  jobs.logs = ExperimentFolder(options.out).logs();
  run_as_jobs(experiment.steps(), queue, jobs);
  return experiment.report();
}

void run_experiment_step(const ExperimentPlan& plan, const ExperimentOptions& options,
                         const std::string& name) {
  check(options);
  const Experiment experiment(plan, options);
  const std::vector<ExperimentStep> steps = experiment.steps();
  const auto step = std::ranges::find(steps, name, &ExperimentStep::name);
  if (step == steps.end()) {
    fail("no step '{}' in the experiment {}; steps are named by what they make in its folder, as in {}", name,
         plan.name, steps.front().name);
  }
  run_here(*step);
}

}  // namespace knuckle
