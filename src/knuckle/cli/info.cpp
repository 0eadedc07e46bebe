// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "knuckle/cli/verb.h"
#include "knuckle/core/landmarks.h"
#include "knuckle/core/parallel.h"
#include "knuckle/core/text.h"
#include "knuckle/estimate/create_estimator.h"
#include "knuckle/net/onnx/onnx_engine.h"
#include "knuckle/prepare/open_source.h"
#include "knuckle/refine/refiner_factory.h"
#include "knuckle/segment/segmenter_factory.h"
#include "knuckle/stream/open_camera.h"
#include "knuckle/view/live_server.h"

namespace knuckle::cli {
namespace {

using Names = std::vector<std::string>;

Names convention_names() {
  Names names;
  for (const Convention& convention : conventions()) names.emplace_back(convention.name);
  return names;
}

template <class Range>
Names as_names(const Range& range) {
  return Names(range.begin(), range.end());
}

/// Kinds of camera that this build can open.
Names camera_names() {
  Names names;
  for (const CameraKind& kind : camera_kinds()) {
    if (kind.is_built) names.emplace_back(kind.name);
  }
  return names;
}

/// Every method by kind.
nlohmann::ordered_json methods() {
  return {{"sources", source_kinds()},
          {"cameras", camera_names()},
          {"writers", Names{"folder", "h5", "icg"}},
          {"segmenters", as_names(segmenter_names())},
          {"estimators", as_names(estimator_names())},
          {"refiners", as_names(refiner_names())},
          {"conventions", convention_names()}};
}

/// What runs ONNX files.
std::string onnx_text() {
  const OnnxSupport support = onnx_support();
  return support.is_there ? support.text : "none: " + support.text;
}

void print_info(bool as_json) {
  nlohmann::ordered_json info = {{"version", KNUCKLE_VERSION},
                                 {"build", KNUCKLE_BUILD_TYPE},
                                 {"compiler", KNUCKLE_COMPILER},
                                 {"threads", thread_count()},
                                 {"view", has_live_server() ? "live --view" : "none: built without Boost"},
                                 {"onnx", onnx_text()}};
  info.update(methods());
  if (as_json) {
    fmt::print("{}\n", info.dump(2));
    return;
  }
  for (const auto& [key, value] : info.items()) {
    const std::string text = value.is_array()    ? joined(value.get<Names>())
                             : value.is_string() ? value.get<std::string>()
                                                 : value.dump();
    fmt::print("{:<12} {}\n", key, text);
  }
}

}  // namespace

void add_info(CLI::App& program) {
  CLI::App& verb =
      add_verb(program, "info", "Version, build, and every method by kind", "knuckle info --json");
  auto as_json = std::make_shared<bool>(false);
  verb.add_flag("--json", *as_json, "Print JSON");
  verb.callback([as_json] { print_info(*as_json); });
}

}  // namespace knuckle::cli
