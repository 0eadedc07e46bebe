// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "knuckle/workers/join_workers.h"

namespace knuckle {

/// How many processes work together, and how they meet.
struct TogetherOptions {
  int workers = 1;
  double wait_s = 300.0;                  ///< JoinOptions
  std::vector<std::string> command_line;  ///< of this process: workers that are started here get the same
  std::vector<WorkerTrait> traits;        ///< beside build and processor
  std::string advice;                     ///< what to do after a worker was lost
};

/// Calls `work` with the group of all workers, or nullptr where there is one alone. On one machine worker 0
/// starts the others, and the cores are shared out. Only worker 0 prints. Where a worker fails or is lost all
/// end, and worker 0 throws an Error of one line that names it; where worker 0 is lost, worker 1 does.
void work_together(const TogetherOptions& options, const std::function<void(WorkerGroup*)>& work);

}  // namespace knuckle
