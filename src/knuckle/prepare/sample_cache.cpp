// SPDX-License-Identifier: Apache-2.0
#include "knuckle/prepare/sample_cache.h"

#include <fmt/format.h>

#include "knuckle/core/own_convention.h"
#include "knuckle/prepare/fresh_samples.h"
#include "knuckle/prepare/sample_blocks.h"
#include "knuckle/prepare/sample_file.h"
#include "knuckle/prepare/thing_samples.h"
#include "knuckle/segment/detector/detector_file.h"
#include "knuckle/storage/content_hash.h"
#include "knuckle/storage/file_io.h"
#include "knuckle/storage/work_claim.h"

namespace knuckle {
namespace {

Inputs inputs_of(const std::string& source, const Inputs& segmentation, const SampleOptions& options) {
  Inputs inputs = segmentation;
  inputs.add_source("source", source)
      .add("convention", convention_text(options.convention))
      .add("patch", fmt::format("{} px, {} mm", options.patch.size_px, options.patch.side_mm))
      .add("crop", fmt::format("{} px", options.crop_px))
      .add("start", kStartNames[static_cast<std::size_t>(options.start)])
      .add("centre", options.around_joints ? "joints" : "segmentation")
      .add("most", fmt::format("{}", options.most));
  // What most trainings do not ask for has no line, so that their files are found again.
  if (options.definition) inputs.add("definition", options.definition->as_toml());
  if (options.side) inputs.add("side", *options.side == HandSide::left ? "left" : "right");
  if (options.holdout.share > 0.0) {
    const bool is_training = options.holdout.part == Holdout::Part::training;
    inputs.add("holdout",
               fmt::format("{}, {}", options.holdout.share, is_training ? "training" : "validation"));
  }
  return inputs;
}

Inputs inputs_of_things(const std::string& source, const std::filesystem::path& detector,
                        const SampleOptions& options) {
  Inputs inputs;
  inputs.add("what", "things").add_content("detector", detector);
  return inputs_of(source, inputs, options);
}

}  // namespace

SampleCache::SampleCache(std::filesystem::path folder) : folder_(std::move(folder)) {
  if (!folder_.empty()) make_folder(folder_);
}

std::filesystem::path SampleCache::place_of(const Inputs& inputs) const {
  return folder_ / fmt::format("samples_{}", text_hash(inputs.text()));
}

NetworkSamples SampleCache::kept(const Inputs& inputs, const std::function<NetworkSamples()>& make) const {
  const std::filesystem::path file = place_of(inputs).string() + ".h5";
  if (std::filesystem::exists(file)) return read_samples(file, inputs);
  // Of several trainings of the same samples one cuts them out.
  const WorkClaim claim(file.string() + ".claim");
  if (std::filesystem::exists(file)) return read_samples(file, inputs);
  NetworkSamples made = make();
  write_samples(file, made, inputs);
  return made;
}

NetworkSamples SampleCache::samples(const std::string& source, const HandFinder& finder,
                                    const Inputs& segmentation, const SampleOptions& options) const {
  const auto make = [&] { return network_samples(source, finder, options); };
  return folder_.empty() ? make() : kept(inputs_of(source, segmentation, options), make);
}

NetworkSamples SampleCache::things(const std::string& source, const std::filesystem::path& detector,
                                   const SampleOptions& options) const {
  const auto make = [&] {
    return thing_samples(source, HandDetector(load_detector_weights(detector)), options);
  };
  if (folder_.empty()) return make();
  return kept(inputs_of_things(source, detector, options), make);
}

std::unique_ptr<SampleStream> SampleCache::streamed(const std::string& source, const HandFinder& finder,
                                                    const Inputs& segmentation,
                                                    const SampleOptions& options) const {
  const auto cutter = [&] { return hand_cutter(source, finder, options); };
  if (folder_.empty()) return std::make_unique<FreshSamples>(source, cutter(), options);
  const Inputs inputs = inputs_of(source, segmentation, options);
  auto blocks = SampleBlocks::opened(place_of(inputs), {inputs, options, "samples", cutter});
  require_used(blocks->frames(), source);
  return blocks;
}

std::unique_ptr<SampleStream> SampleCache::streamed_things(const std::string& source,
                                                           const std::filesystem::path& detector,
                                                           const SampleOptions& options) const {
  const auto cutter = [&] {
    return thing_cutter(source, std::make_shared<const HandDetector>(load_detector_weights(detector)),
                        options);
  };
  if (folder_.empty()) return std::make_unique<FreshSamples>(source, cutter(), options);
  const Inputs inputs = inputs_of_things(source, detector, options);
  auto blocks = SampleBlocks::opened(place_of(inputs), {inputs, options, "things", cutter});
  require_things(blocks->frames(), source);
  return blocks;
}

}  // namespace knuckle
