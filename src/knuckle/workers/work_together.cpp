// SPDX-License-Identifier: Apache-2.0
#include "knuckle/workers/work_together.h"

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <filesystem>
#include <system_error>

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include "knuckle/core/error.h"
#include "knuckle/core/interruption.h"
#include "knuckle/core/parallel.h"
#include "knuckle/core/progress.h"
#include "knuckle/workers/local_workers.h"

namespace knuckle {
namespace {

/// Sends what this process prints to nowhere, until it is taken back.
class Silence {
 public:
  Silence() {
    std::fflush(nullptr);
    show_progress(false);
    const int nowhere = ::open("/dev/null", O_WRONLY | O_CLOEXEC);
    errors_ = ::fcntl(STDERR_FILENO, F_DUPFD_CLOEXEC, STDERR_FILENO + 1);
    if (nowhere < 0 || errors_ < 0) return;
    ::dup2(nowhere, STDOUT_FILENO);
    ::dup2(nowhere, STDERR_FILENO);
    ::close(nowhere);
  }
  /// Errors are printed again.
  void end() const {
    std::fflush(nullptr);
    if (errors_ >= 0) ::dup2(errors_, STDERR_FILENO);
  }

 private:
  int errors_ = -1;
};

/// Threads of LibTorch that wait for what never comes must not see the program's objects go.
void exit_without_waiting() {
  std::atexit([] {
    std::fflush(nullptr);
    ::_exit(EXIT_FAILURE);
  });
}

/// What this worker has to say; nothing where it ends for another's sake.
std::string own_fault(const std::exception_ptr& fault, const JoinedWorkers& workers) {
  try {
    std::rethrow_exception(fault);
  } catch (const WorkersFault&) {
    return {};
  } catch (const Interrupted& interruption) {
    return workers.has_seen_fault() ? std::string() : interruption.what();
  } catch (const std::exception& error) {
    return error.what();
  }
}

/// Worker 1 speaks, and tidies up, where worker 0 no longer can.
void stand_in_for_worker_0(const WorkerPlace& place, const Silence* silence) {
  if (silence != nullptr) silence->end();
  std::error_code ignored;
  if (!place.folder.empty()) std::filesystem::remove_all(place.folder, ignored);
}

[[noreturn]] void end_all(JoinedWorkers& workers, const std::exception_ptr& fault, const WorkerPlace& place,
                          const std::string& advice, const Silence* silence) {
  exit_without_waiting();
  const std::string own = own_fault(fault, workers);
  const std::optional<std::string> verdict = workers.ended_with(own);
  if (workers.rank() == 0 && !own.empty()) std::rethrow_exception(fault);
  if (workers.rank() == 1 && verdict) stand_in_for_worker_0(place, silence);
  fail("{}; all workers have ended: {}", verdict.value_or("another worker has failed"), advice);
}

std::unique_ptr<JoinedWorkers> joined(const JoinOptions& options) {
  try {
    return join_workers(options);
  } catch (...) {
    exit_without_waiting();
    throw;
  }
}

void work_joined(JoinOptions join, const std::string& advice, const std::function<void(WorkerGroup*)>& work) {
  std::unique_ptr<Silence> silence;
  const auto keep_silent = [&] { silence = std::make_unique<Silence>(); };
  // A worker that was started by worker 0 has nothing to say that worker 0 does not say.
  const bool is_started = join.place.is_on_one_machine() && join.place.rank > 0;
  if (is_started) keep_silent();
  if (join.place.rank > 0 && !is_started) join.has_met = keep_silent;
  const std::unique_ptr<JoinedWorkers> workers = joined(join);
  try {
    work(workers.get());
    gathered(*workers, "done");
  } catch (...) {
    end_all(*workers, std::current_exception(), join.place, advice, silence.get());
  }
  workers->ended_well();
}

/// Whether worker 0, whose child this process is, has ended: a connection that it leaves open says nothing.
std::function<std::optional<std::string>()> fault_of_parent(int workers) {
  return [workers, parent = ::getppid()]() -> std::optional<std::string> {
    if (::getppid() == parent) return std::nullopt;
    return fmt::format("worker 0 of {} was lost: its process ended", workers);
  };
}

}  // namespace

void work_together(const TogetherOptions& options, const std::function<void(WorkerGroup*)>& work) {
  if (options.workers <= 1) {
    work(nullptr);
    return;
  }
  if (!has_workers()) static_cast<void>(join_workers({}));  // says what is missing
  ::setenv("TORCH_CPP_LOG_LEVEL", "ERROR", 0);
  JoinOptions join;
  join.place = worker_place(options.workers);
  join.wait_s = options.wait_s;
  join.traits = options.traits;
  std::unique_ptr<LocalWorkers> started;
  if (join.place.is_on_one_machine()) {
    set_thread_count(std::max(1, thread_count() / options.workers));
    if (join.place.rank == 0) {
      started = std::make_unique<LocalWorkers>(options.command_line, options.workers);
      join.place.folder = started->folder();
      join.fault_of_process = [&started] { return started->fault(); };
    } else {
      join.fault_of_process = fault_of_parent(options.workers);
    }
  }
  work_joined(join, options.advice, work);
}

}  // namespace knuckle
