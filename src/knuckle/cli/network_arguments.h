// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <functional>
#include <string>

#include <CLI/CLI.hpp>

namespace knuckle::cli {

/// What `knuckle train network` is told.
struct NetworkArguments {
  std::filesystem::path config;
  std::filesystem::path out;
  bool resume = false;
  std::string device = "cpu";
  double minutes = 0.0;
  std::filesystem::path cache;
  int workers = 1;        ///< processes that train together
  double wait_s = 300.0;  ///< how long one of them that does not come or answer is waited for [s]
  bool check = false;     ///< shows what it would be trained on, and does not train
};

/// Adds `network` to the verb `train`. Two programs know it: `knuckle`, where `run` starts the other one, and
/// `knuckle-train-network`, where it trains.
void add_train_network(CLI::App& train, const std::function<void(const NetworkArguments&)>& run);

}  // namespace knuckle::cli
