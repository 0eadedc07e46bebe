// SPDX-License-Identifier: Apache-2.0
#include "knuckle/workers/worker_place.h"

#include <cstdlib>
#include <optional>

#include "knuckle/core/error.h"
#include "knuckle/core/text.h"

namespace knuckle {
namespace {

constexpr long long kMostWorkers = 1 << 20;
constexpr long long kLargestPort = 65535;
// Where no port is named: one that follows from the job, so that jobs on one machine do not meet.
constexpr long long kFirstPortOfJobs = 20000;
constexpr long long kPortsOfJobs = 10000;

std::optional<std::string> variable(const char* name) {
  const char* const text = std::getenv(name);
  if (text == nullptr || *text == '\0') return std::nullopt;
  return text;
}

std::optional<long long> number_in(const char* name, long long least, long long most) {
  const std::optional<std::string> text = variable(name);
  if (!text) return std::nullopt;
  const long long number = parse_integer(*text, name);
  if (number < least || number > most) {
    fail("--workers: {} is {}, expected a number from {} to {}", name, number, least, most);
  }
  return number;
}

/// What has to stand in the environment beside another variable.
template <class Value>
Value required(const std::optional<Value>& value, const char* name, const char* beside) {
  if (!value) fail("--workers: {} is set, and {} is not", beside, name);
  return *value;
}

WorkerPlace checked(WorkerPlace place, const char* size_variable, int workers) {
  if (place.size != workers) {
    fail("--workers is {}, and {} processes were started ({}): say --workers {}", workers, place.size,
         size_variable, place.size);
  }
  if (place.rank >= place.size) {
    fail("--workers: this is worker {} of {}, expected a number from 0 to {}", place.rank, place.size,
         place.size - 1);
  }
  return place;
}

int number_on_machine(const char* name, const WorkerPlace& place) {
  return static_cast<int>(number_in(name, 0, kMostWorkers).value_or(place.rank));
}

WorkerPlace named_place(int workers, long long rank) {
  WorkerPlace place;
  place.rank = static_cast<int>(rank);
  place.size = static_cast<int>(required(number_in("WORLD_SIZE", 1, kMostWorkers), "WORLD_SIZE", "RANK"));
  place.address = required(variable("MASTER_ADDR"), "MASTER_ADDR", "RANK");
  place.port =
      static_cast<std::uint16_t>(required(number_in("MASTER_PORT", 1, kLargestPort), "MASTER_PORT", "RANK"));
  place.number_on_machine = number_on_machine("LOCAL_RANK", place);
  return checked(place, "WORLD_SIZE", workers);
}

WorkerPlace place_in_slurm(int workers, long long tasks) {
  constexpr const char* kTasks = "SLURM_STEP_NUM_TASKS";
  WorkerPlace place;
  place.size = static_cast<int>(tasks);
  place.rank = static_cast<int>(required(number_in("SLURM_PROCID", 0, kMostWorkers), "SLURM_PROCID", kTasks));
  const std::optional<std::string> address = variable("MASTER_ADDR");
  place.address = address
                      ? *address
                      : first_host(required(variable("SLURM_STEP_NODELIST"), "SLURM_STEP_NODELIST", kTasks));
  const long long job = number_in("SLURM_JOB_ID", 0, 1LL << 40).value_or(0);
  place.port = static_cast<std::uint16_t>(
      number_in("MASTER_PORT", 1, kLargestPort).value_or(kFirstPortOfJobs + job % kPortsOfJobs));
  place.number_on_machine = number_on_machine("SLURM_LOCALID", place);
  return checked(place, kTasks, workers);
}

}  // namespace

WorkerPlace worker_place(int workers) {
  if (workers <= 1) return {};
  if (const auto rank = number_in(kRankVariable, 0, kMostWorkers)) {
    WorkerPlace place{.rank = static_cast<int>(*rank), .size = workers, .folder = {}, .address = {}};
    place.number_on_machine = place.rank;
    place.folder = required(variable(kFolderVariable), kFolderVariable, kRankVariable);
    return checked(place, kRankVariable, workers);
  }
  if (const auto rank = number_in("RANK", 0, kMostWorkers)) return named_place(workers, *rank);
  const auto tasks = number_in("SLURM_STEP_NUM_TASKS", 1, kMostWorkers);
  if (tasks.value_or(1) > 1) return place_in_slurm(workers, *tasks);
  WorkerPlace place;
  place.size = workers;
  return place;
}

std::string first_host(std::string_view hosts) {
  const std::size_t end = hosts.find_first_of("[,");
  if (end == std::string_view::npos || hosts[end] == ',') return std::string(hosts.substr(0, end));
  const std::string_view numbers = hosts.substr(end + 1);
  std::string host(hosts.substr(0, end));
  host += numbers.substr(0, numbers.find_first_of("-,]"));
  const std::size_t close = hosts.find(']');
  if (close == std::string_view::npos) return host;
  const std::string_view rest = hosts.substr(close + 1);
  host += rest.substr(0, rest.find(','));
  return host;
}

}  // namespace knuckle
