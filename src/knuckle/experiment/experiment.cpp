// SPDX-License-Identifier: Apache-2.0
#include "knuckle/experiment/experiment.h"

#include <algorithm>

#include <fmt/format.h>

#include "knuckle/core/error.h"
#include "knuckle/core/options.h"
#include "knuckle/data/poses_file.h"
#include "knuckle/experiment/check_model.h"
#include "knuckle/experiment/layout.h"
#include "knuckle/experiment/report_page.h"
#include "knuckle/experiment/scale.h"
#include "knuckle/experiment/step.h"
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

  std::filesystem::path run() const {
    for (const PlannedMethod& method : plan_.segmentation) provide_pipeline(method);
    for (const PlannedMethod& method : plan_.estimation) provide_pipeline(method);
    // Those that are given come first: a wrong one is found before hours of training.
    for (const PlannedModel& model : plan_.models) {
      if (!given(model).empty()) take(model);
    }
    for (const PlannedModel& model : plan_.models) {
      if (given(model).empty()) train(model);
    }
    for (const PlannedSequence& sequence : plan_.sequences) run_on(sequence);
    return report();
  }

 private:
  /// Copies a pipeline to where its models are found as `../models/FILE`.
  void provide_pipeline(const PlannedMethod& method) const {
    check_models_of(method);
    const std::filesystem::path out = folder_.pipeline(method);
    run_step(out, Inputs().add_content("pipeline", method.pipeline),
             [&](StepStart) { copy_whole_file(method.pipeline, out); });
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

  void take(const PlannedModel& model) const {
    const std::filesystem::path from = given(model);
    const std::filesystem::path out = folder_.model(model);
    Inputs inputs;
    inputs.add("given", from.string()).add_content("model", from).add_content("config", model.config);
    inputs.add_content_if_there("metrics", ExperimentFolder::metrics(from));
    run_step(out, inputs, [&](StepStart) {
      check_model(model.kind, model.config, from);
      copy_whole_file(from, out);
      std::filesystem::remove(ExperimentFolder::metrics(out));
      if (std::filesystem::exists(ExperimentFolder::metrics(from))) {
        copy_whole_file(ExperimentFolder::metrics(from), ExperimentFolder::metrics(out));
      }
      write_given_record(out, from);
    });
  }

  void train(const PlannedModel& model) const {
    const std::filesystem::path out = folder_.model(model);
    const ScaledTraining training =
        write_scaled_training(model.kind, model.config, options_.scale, folder_.training_config(model));
    Inputs inputs;
    inputs.add("kind", model.kind).add_content("config", training.config);
    for (const std::string& source : training.sources) inputs.add_source("source", source);
    for (const std::filesystem::path& file : training.models) inputs.add_content("model", file);
    run_step(out, inputs, [&](StepStart start) {
      fmt::print("training {}\n", model.file);
      const Stopwatch watch;
      std::filesystem::remove(ExperimentFolder::training_record(out));
      train_model(model.kind, training.config, options_.training, start, out);
      write_trained_record(out, watch.milliseconds() / 1000.0);
    });
    remove_training_checkpoint(out);
  }

  void run_on(const PlannedSequence& sequence) const {
    for (const PlannedMethod& method : plan_.segmentation) segment(sequence, method);
    for (const PlannedMethod& method : plan_.estimation) estimate(sequence, method);
  }

  std::string source_of(const PlannedSequence& sequence) const {
    return scaled_test_source(sequence.source, options_.scale);
  }

  Inputs inputs_of(const PlannedSequence& sequence, const PlannedMethod& method) const {
    return Inputs().add_source("source", source_of(sequence)).add_pipeline(folder_.pipeline(method));
  }

  void segment(const PlannedSequence& sequence, const PlannedMethod& method) const {
    const std::filesystem::path out = folder_.boxes(sequence, method);
    run_step(out, inputs_of(sequence, method), [&](StepStart) {
      fmt::print("{}: segmenting by {}\n", sequence.title, method.name);
      const std::string source = source_of(sequence);
      const HandFinder finder = HandFinder::load(folder_.pipeline(method));
      const std::vector<FrameSegmentation> frames =
          segment_all(*open_source(source), finder, Start::nearest, source);
      write_text_file(ExperimentFolder::summary(out), summary_json(frames, source));
      write_text_file(out, boxes_csv(frames));
    });
  }

  void estimate(const PlannedSequence& sequence, const PlannedMethod& method) const {
    const std::filesystem::path out = folder_.poses(sequence, method);
    run_step(out, inputs_of(sequence, method), [&](StepStart) {
      fmt::print("{}: estimating by {}\n", sequence.title, method.name);
      const std::string source = source_of(sequence);
      const Pipeline pipeline = Pipeline::load(folder_.pipeline(method));
      const std::vector<FrameEstimate> frames =
          estimate_all(*open_source(source), pipeline, Start::truth, source);
      write_text_file(ExperimentFolder::summary(out), summary_json(frames, source, pipeline.convention()));
      write_poses_file(out, pipeline.convention(), poses_of(frames, pipeline.convention()));
    });
  }

  /// The page depends on all models, boxes and poses, and on the truth.
  std::filesystem::path report() const {
    Inputs inputs;
    inputs.add("title", plan_.title).add("convention", plan_.convention.name).add("claims", plan_.claims);
    inputs.add("scale", fmt::format("{}", options_.scale));
    for (const PlannedModel& model : plan_.models) {
      const std::filesystem::path file = folder_.model(model);
      inputs.add_content(model.file, ExperimentFolder::training_record(file));
      inputs.add_content_if_there(model.file + " metrics", ExperimentFolder::metrics(file));
    }
    std::vector<std::string> sources;
    for (const PlannedSequence& sequence : plan_.sequences) {
      sources.push_back(source_of(sequence));
      inputs.add_source(sequence.title, sources.back());
      for (const PlannedMethod& method : plan_.segmentation) {
        inputs.add_content(method.name, folder_.boxes(sequence, method));
      }
      for (const PlannedMethod& method : plan_.estimation) {
        inputs.add_content(method.name, folder_.poses(sequence, method));
      }
    }
    run_step(folder_.report(), inputs, [&](StepStart) {
      fmt::print("writing the report\n");
      write_experiment_report(plan_, sources, options_.scale, folder_);
    });
    return folder_.report();
  }

  const ExperimentPlan& plan_;
  ExperimentOptions options_;
  ExperimentFolder folder_;
};

}  // namespace

std::filesystem::path run_experiment(const ExperimentPlan& plan, const ExperimentOptions& options) {
  if (!(options.scale > 0.0 && options.scale <= 1.0)) {
    fail("scale is {}, expected a part of the whole in (0, 1]", options.scale);
  }
  if (!options.models.empty() && !std::filesystem::is_directory(options.models)) {
    fail("{}: not a folder of trained models", options.models.string());
  }
  return Experiment(plan, options).run();
}

}  // namespace knuckle
