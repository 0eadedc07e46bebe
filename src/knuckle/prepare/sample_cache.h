// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <string>

#include "knuckle/prepare/inputs.h"
#include "knuckle/prepare/network_samples.h"
#include "knuckle/prepare/sample_stream.h"

namespace knuckle {

/// A folder in which cut-out hands are kept from one training to the next. A file there is named by a hash of
/// all that its samples depend on: frames, segmentation and options, but not the program; empty the folder
/// after a change of it.
class SampleCache {
 public:
  /// An empty path: nothing is kept. Throws an Error that names the folder where it cannot be made.
  explicit SampleCache(std::filesystem::path folder);

  /// As `network_samples`, from the folder where they are there already, else into it. `segmentation` is what
  /// the finder was made from.
  NetworkSamples samples(const std::string& source, const HandFinder& finder, const Inputs& segmentation,
                         const SampleOptions& options) const;
  /// The same of `thing_samples`; `detector` is a model's file.
  NetworkSamples things(const std::string& source, const std::filesystem::path& detector,
                        const SampleOptions& options) const;

  /// As `samples` and `things`, for sets larger than memory: from blocks in the folder (SampleBlocks), which
  /// are made where they are missing; without a folder cut out anew each time (FreshSamples). `finder` has to
  /// live as long.
  std::unique_ptr<SampleStream> streamed(const std::string& source, const HandFinder& finder,
                                         const Inputs& segmentation, const SampleOptions& options) const;
  std::unique_ptr<SampleStream> streamed_things(const std::string& source,
                                                const std::filesystem::path& detector,
                                                const SampleOptions& options) const;

 private:
  NetworkSamples kept(const Inputs& inputs, const std::function<NetworkSamples()>& make) const;

  /// Where the samples of these inputs are kept, but for the ending.
  std::filesystem::path place_of(const Inputs& inputs) const;

  std::filesystem::path folder_;
};

}  // namespace knuckle
