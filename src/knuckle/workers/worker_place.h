// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>

namespace knuckle {

/// Which of several workers this process is, and where they meet.
struct WorkerPlace {
  int rank = 0;
  int size = 1;
  int number_on_machine = 0;  ///< among the workers of its machine; its rank where nothing says it
  /// Workers of one machine meet in a folder that worker 0 makes. Empty: not known yet, or at an address.
  std::filesystem::path folder;
  std::string address;     ///< of worker 0's machine; empty: all are on this machine
  std::uint16_t port = 0;  ///< where worker 0 listens there

  bool is_on_one_machine() const { return address.empty(); }
};

/// The variable by which worker 0 tells a worker that it starts on its machine which one it is.
inline constexpr const char* kRankVariable = "KNUCKLE_WORKER";
/// The variable that tells it in which folder they meet.
inline constexpr const char* kFolderVariable = "KNUCKLE_WORKERS_FOLDER";

/// The place of this process among `workers`, from the environment. In this order: the two variables above;
/// RANK and WORLD_SIZE with MASTER_ADDR and MASTER_PORT, as PyTorch's starters set them; a step of Slurm with
/// several tasks (`srun`), whose first host is worker 0's; else worker 0 of this machine, which starts the
/// others. Throws an Error that names the variable that is wrong, or says that another number was started.
WorkerPlace worker_place(int workers);

/// The first of a list of hosts as Slurm writes it: "node07" of "node[07-09,12],other".
std::string first_host(std::string_view hosts);

}  // namespace knuckle
