// SPDX-License-Identifier: Apache-2.0
#include "knuckle/cli/network_arguments.h"

#include <memory>

#include "knuckle/cli/verb.h"

namespace knuckle::cli {

void add_train_network(CLI::App& train, const std::function<void(const NetworkArguments&)>& run) {
  CLI::App& network = add_verb(
      train, "network", "Train a convolutional network: one that infers poses, or the detector of hands",
      "knuckle train network --config pipelines/train_dense.toml --out dense.pt");
  auto arguments = std::make_shared<NetworkArguments>();
  network.add_option("--config", arguments->config, "Sources, network, augmentation and training options")
      ->required();
  network.add_option("--out", arguments->out, "File for the model")->required();
  network.add_flag("--resume", arguments->resume,
                   "Go on where a training of the same configuration was stopped");
  network.add_option("--device", arguments->device, "cpu | cuda | cuda:N")->capture_default_str();
  network
      .add_option("--minutes", arguments->minutes,
                  "Be done with training in this time; the result then depends on the machine's speed")
      ->check(CLI::NonNegativeNumber);
  network.add_option("--cache", arguments->cache,
                     "Folder in which hands that were cut out of frames are kept for the next training");
  network
      .add_option("--workers", arguments->workers,
                  "Processes that train together, 1 to 1024: started on this machine, or by srun on several")
      ->check(CLI::Range(1, 1024).description(""))
      ->type_name("N")
      ->capture_default_str();
  network
      .add_option("--wait", arguments->wait_s,
                  "How long a worker that does not come or answer is waited for [s], 5 to 86400")
      ->check(CLI::Range(5.0, 86400.0).description(""))
      ->type_name("SECONDS")
      ->capture_default_str();
  network.add_flag("--check", arguments->check,
                   "Only show what it would be trained on: the sets in words, and samples in OUT's name with "
                   "_check.png");
  network.callback([arguments, run] { run(*arguments); });
}

}  // namespace knuckle::cli
