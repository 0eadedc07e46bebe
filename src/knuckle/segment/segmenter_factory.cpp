// SPDX-License-Identifier: Apache-2.0
#include "knuckle/segment/segmenter_factory.h"

#include <algorithm>
#include <array>
#include <filesystem>
#include <string>
#include <vector>

#include "knuckle/core/error.h"
#include "knuckle/core/text.h"
#include "knuckle/segment/forest_segmenter.h"
#include "knuckle/segment/mean_shift_segmenter.h"
#include "knuckle/segment/segmentation_forest.h"
#include "knuckle/segment/threshold_segmenter.h"

namespace knuckle {
namespace {

// The table of methods: their names here, what makes them below.
constexpr std::array<std::string_view, 3> kNames{"mean_shift", "threshold", "forest"};

template <class Method, class Options>
std::unique_ptr<Segmenter> create(const OptionTable& table) {
  Options options;
  table.read(options);
  table.finish();
  return std::make_unique<Method>(options);
}

/// The model is named by a path relative to the table's file.
std::unique_ptr<Segmenter> create_forest(const OptionTable& table) {
  ForestSegmenterOptions options;
  const std::filesystem::path model = table.resolved_path(table.required_text("model"));
  table.read(options);
  table.finish();
  return std::make_unique<ForestSegmenter>(load_segmentation_forest(model), options);
}

using Create = std::unique_ptr<Segmenter> (*)(const OptionTable& table);
constexpr std::array<Create, kNames.size()> kCreate{
    create<MeanShiftSegmenter, MeanShiftSegmenterOptions>,
    create<ThresholdSegmenter, ThresholdSegmenterOptions>,
    create_forest,
};

}  // namespace

std::span<const std::string_view> segmenter_names() {
  return kNames;
}

std::unique_ptr<Segmenter> create_segmenter(std::string_view name, const OptionTable& table) {
  const auto place = std::ranges::find(kNames, name);
  if (place == kNames.end()) {
    fail("there is no segmentation method \"{}\"; known: {}", name,
         joined(std::vector<std::string>(kNames.begin(), kNames.end())));
  }
  return kCreate[static_cast<std::size_t>(place - kNames.begin())](table);
}

std::unique_ptr<Segmenter> create_segmenter(const OptionTable& table) {
  return create_segmenter(table.choice_or("method", kNames[0], kNames), table);
}

}  // namespace knuckle
