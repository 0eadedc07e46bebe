// SPDX-License-Identifier: Apache-2.0
#include "knuckle/estimate/create_estimator.h"

#include <array>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "knuckle/core/error.h"
#include "knuckle/core/named_table.h"
#include "knuckle/core/own_convention.h"
#include "knuckle/estimate/network_estimator.h"
#include "knuckle/estimate/onnx_estimator.h"
#include "knuckle/estimate/pose_forest.h"
#include "knuckle/estimate/surest_estimator.h"

namespace knuckle {

namespace {

struct EstimationMethod {
  std::string_view name;
  /// Reads the options of the method alone from the table, then the model, where it has one.
  std::unique_ptr<Estimator> (*load)(const OptionTable& table);
};

std::filesystem::path model_of(const OptionTable& table) {
  return table.resolved_path(table.required_text("model"));
}

std::unique_ptr<Estimator> load_forest(const OptionTable& table) {
  return std::make_unique<PoseForestEstimator>(load_pose_forest(model_of(table)));
}

/// The method is the name of the network's architecture.
std::unique_ptr<Estimator> load_network_estimator(const OptionTable& table) {
  NetworkEstimatorOptions options;
  table.read(options);
  const std::filesystem::path model = model_of(table);
  PoseNetwork network(model);
  const std::string method = table.required_text("method");
  if (network.options().architecture != method) {
    table.fail_at("model", fmt::format("{} is a network \"{}\", expected \"{}\"", model.string(),
                                       network.options().architecture, method));
  }
  return std::make_unique<NetworkEstimator>(std::move(network), options);
}

/// Null where none is named.
std::unique_ptr<Estimator> load_judge(const OptionTable& table, const std::string& model) {
  if (model.empty()) return nullptr;
  PoseNetwork network(table.resolved_path(model));
  const NetworkOptions& options = network.options();
  if (options.architecture != "dense" || !options.dense.tells_hand) {
    table.fail_at("judge",
                  fmt::format("{} does not tell whether there is a hand, expected a network that was "
                              "trained with tells_hand = true",
                              model));
  }
  return std::make_unique<NetworkEstimator>(std::move(network), NetworkEstimatorOptions{});
}

std::unique_ptr<Estimator> load_surest(const OptionTable& table) {
  SurestEstimatorOptions options;
  table.read(options);
  if (options.models.size() < 2) {
    table.fail_at("models", fmt::format("has {} files, expected two or more", options.models.size()));
  }
  const auto load = [&](const std::string& model) {
    return std::make_unique<NetworkEstimator>(PoseNetwork(table.resolved_path(model)),
                                              NetworkEstimatorOptions{});
  };
  std::vector<std::unique_ptr<Estimator>> estimators;
  for (const std::string& model : options.models) estimators.push_back(load(model));
  return std::make_unique<SurestEstimator>(std::move(estimators), options, load_judge(table, options.judge));
}

constexpr std::array kMethods{
    EstimationMethod{"forest", load_forest},
    EstimationMethod{"dense", load_network_estimator},
    EstimationMethod{"heatmap2d", load_network_estimator},
    EstimationMethod{"heatmap25d", load_network_estimator},
    EstimationMethod{"regression", load_network_estimator},
    EstimationMethod{"pca", load_network_estimator},
    EstimationMethod{"autoencoder", load_network_estimator},
    EstimationMethod{"onnx", load_onnx_estimator},
    EstimationMethod{"surest", load_surest},
};

constexpr auto kNames = names_of(kMethods);

/// What the table asks of the model.
struct Expectations {
  std::string convention;  ///< empty: any
  int patch_size_px = 0;   ///< 0: any

  void visit(OptionVisitor& visitor) {
    visitor.text("convention", convention);
    visitor.integer("patch_size_px", patch_size_px, closed(0, 4096));
  }
};

void check(const Estimator& estimator, const Expectations& expected, const OptionTable& table) {
  const std::string_view convention = estimator.convention().name;
  const bool is_file = expected.convention.ends_with(".toml");
  const std::string_view asked =
      is_file ? convention_from_key(table, "convention", "").name : std::string_view(expected.convention);
  if (!asked.empty() && convention != asked) {
    table.fail_at("convention", fmt::format("\"{}\" is asked for, but the model predicts \"{}\"",
                                            expected.convention, convention));
  }
  const int size = estimator.patches().options().size_px;
  if (expected.patch_size_px != 0 && size != expected.patch_size_px) {
    table.fail_at("patch_size_px",
                  fmt::format("{} is asked for, but the model was trained on patches of {} x {}",
                              expected.patch_size_px, size, size));
  }
}

}  // namespace

std::span<const std::string_view> estimator_names() {
  return kNames;
}

std::unique_ptr<Estimator> create_estimator(const OptionTable& table) {
  const std::string name = table.required_text("method");
  const EstimationMethod* const method = row_named(kMethods, name);
  if (method == nullptr) table.fail_at("method", unknown_name("estimator", name, kNames));
  Expectations expected;
  table.read(expected);
  std::unique_ptr<Estimator> estimator = method->load(table);
  table.finish();
  check(*estimator, expected, table);
  return estimator;
}

}  // namespace knuckle
