// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <functional>
#include <string>

#include "knuckle/prepare/inputs.h"
#include "knuckle/prepare/network_samples.h"

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

 private:
  NetworkSamples kept(const Inputs& inputs, const std::function<NetworkSamples()>& make) const;

  std::filesystem::path folder_;
};

}  // namespace knuckle
