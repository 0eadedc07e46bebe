// SPDX-License-Identifier: Apache-2.0
#include "knuckle/workers/join_workers.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdlib>
#include <future>
#include <numeric>
#include <thread>
#include <utility>

#include <ATen/Functions.h>
#include <ATen/Version.h>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <malloc.h>
#include <torch/csrc/distributed/c10d/ProcessGroupGloo.hpp>
#include <unistd.h>

#include "knuckle/core/error.h"
#include "knuckle/core/interruption.h"
#include "knuckle/pipeline/stopwatch.h"
#include "knuckle/storage/content_hash.h"
#include "knuckle/workers/c10d_workers.h"
#include "knuckle/workers/meeting_place.h"
#include "knuckle/workers/nccl_exchange.h"
#include "knuckle/workers/own_address.h"
#include "knuckle/workers/tensor_exchange.h"
#include "knuckle/workers/watch.h"

namespace knuckle {
namespace {

using Gloo = c10d::ProcessGroupGloo;

constexpr auto kLook = std::chrono::milliseconds(20);
/// How often one that waits for a message looks whether its sender still lives.
constexpr auto kPatience = std::chrono::milliseconds(500);
/// Within this time workers tell how they ended; those whose heart has not beaten for as long are lost.
constexpr double kTimeToTell = 5.0;
constexpr double kSilence = 3.5;

/// What the results hang on beside the options.
std::vector<WorkerTrait> traits_of_this_program() {
  return {{"another build of the program", content_hash("/proc/self/exe")},
          {"another LibTorch or a processor with other instructions", at::show_config()}};
}

std::string lines_of(const std::vector<WorkerTrait>& traits) {
  std::string lines;
  for (const WorkerTrait& trait : traits) lines += text_hash(trait.value) + "\n";
  return lines;
}

/// The first trait in which two workers differ.
std::string difference(const std::vector<WorkerTrait>& traits, const std::string& a, const std::string& b) {
  const std::size_t line = text_hash("").size() + 1;
  for (std::size_t i = 0; i < traits.size(); ++i) {
    if (a.substr(std::min(a.size(), i * line), line) != b.substr(std::min(b.size(), i * line), line))
      return traits[i].what;
  }
  return "another build of the program";
}

/// The network that workers talk over: the one that is named, else the one that leads to worker 0. A
/// machine's own name often stands for its loopback.
std::shared_ptr<gloo::transport::Device> network_device(const WorkerPlace& place) {
  if (place.is_on_one_machine()) return Gloo::createDeviceForHostname("127.0.0.1");
  if (const char* const named = std::getenv("GLOO_SOCKET_IFNAME"))
    return Gloo::createDeviceForInterface(named);
  const auto own = own_address_towards(place.address, place.port);
  return own ? Gloo::createDeviceForHostname(*own) : Gloo::createDefaultDevice();
}

/// Messages of megabytes come and go all the time. Memory that is given back to the system comes from there
/// anew, page by page: a tenth of a forest's training.
void keep_freed_memory() {
  constexpr int kMostKept = 32 << 20;  // glibc's own most
  ::mallopt(M_MMAP_THRESHOLD, kMostKept);
  ::mallopt(M_TRIM_THRESHOLD, 2 * kMostKept);
}

std::string hello(int rank) {
  return fmt::format("hello/{}", rank);
}
std::string fault_of(int rank) {
  return fmt::format("fault/{}", rank);
}
std::string reason(int rank) {
  return fmt::format("reason/{}", rank);
}
std::string left(int rank) {
  return fmt::format("left/{}", rank);
}

class GlooWorkers final : public C10dWorkers, public DeviceWorkers {
 public:
  explicit GlooWorkers(const JoinOptions& options)
      : options_(options),
        place_(options.place),
        notes_(std::make_shared<MeetingPlace>(options.place, options.wait_s)) {
    keep_freed_memory();
    options_.traits = traits_of_this_program();
    options_.traits.insert(options_.traits.end(), options.traits.begin(), options.traits.end());
    if (options_.has_met) options_.has_met();
    try {
      greet();
      watch_ = std::make_unique<Watch>(notes_, place_.rank, place_.size, options_.wait_s);
      connect();
    } catch (const std::exception& error) {
      say_fault(error.what());
      linger();
      throw;
    }
  }

  ~GlooWorkers() override {
    // Its threads may wait for messages that never come.
    if (is_broken_) group_.release();
  }

  int rank() const override { return place_.rank; }
  int size() const override { return place_.size; }
  int number_on_machine() const override { return place_.number_on_machine; }
  double seconds_in_exchange() const override { return seconds_in_exchange_; }
  std::int64_t bytes_sent() const override { return bytes_sent_; }
  bool has_seen_fault() const override { return watch_ && watch_->has_seen_fault(); }

  std::vector<std::byte> exchange(Messages sent, const std::vector<std::int64_t>& sizes) override {
    const std::int64_t length = std::accumulate(sizes.begin(), sizes.end(), std::int64_t{0});
    const auto bytes = std::make_shared<Bytes>(std::move(sent), static_cast<std::size_t>(length));
    complete({.output = at::from_blob(bytes->received.data(), {length}, at::kByte),
              .input = at::from_blob(bytes->sent.bytes.data(), {std::ssize(bytes->sent.bytes)}, at::kByte),
              .received_counts = sizes,
              .sent_counts = bytes->sent.sizes,
              .memory = bytes});
    return std::move(bytes->received);
  }

  std::unique_ptr<TensorExchange> exchange_on(const torch::Device& device) override {
    if (device.is_cpu()) return std::make_unique<GlooExchange>(*this);
    return nccl_exchange(*this, device);
  }

  const c10::intrusive_ptr<c10d::Store>& store() override { return notes_->store(); }

  void end_if_over() override {
    if (is_over()) throw WorkersFault("a worker has ended");
    end_if_interrupted();
  }

  WorkersFault fault_of_exchange(const std::string& reason) override {
    is_broken_ = true;
    remember(reason);
    end_if_over();
    return WorkersFault(reason_);
  }

  void add_exchange(double seconds, std::int64_t bytes) override {
    seconds_in_exchange_ += seconds;
    bytes_sent_ += bytes;
  }

  std::optional<std::string> ended_with(const std::string& own) override {
    is_broken_ = true;
    if (watch_ && !watch_->fault().empty()) remember(watch_->fault());
    say(reason(place_.rank), reason_);
    say_fault(own);
    const std::optional<std::string> verdict = place_.rank == 0 ? verdict_of(own) : verdict_heard();
    if (place_.rank == 0) say("verdict", *verdict);
    linger();
    if (place_.rank == 1 && verdict && !is_notes_lost_) wait_for_leaving(2);  // it removes the notes
    return verdict;
  }

  void ended_well() override { linger(); }

 private:
  struct Bytes {
    Bytes(Messages messages, std::size_t length) : sent(std::move(messages)), received(length) {}
    Messages sent;
    std::vector<std::byte> received;
  };

  /// What an exchange writes and reads.
  struct Pending {
    at::Tensor output;
    at::Tensor input;
    std::vector<std::int64_t> received_counts;
    std::vector<std::int64_t> sent_counts;
    std::shared_ptr<void> memory;  ///< of tensors that have none of their own
  };

  void complete(Pending what) {
    end_if_over();
    const Stopwatch watch;
    const std::int64_t own = what.sent_counts[static_cast<std::size_t>(place_.rank)];
    const std::int64_t others =
        (what.input.numel() - own) * static_cast<std::int64_t>(what.input.element_size());
    auto pending = std::make_unique<Pending>(std::move(what));
    try {
      wait_for(*group_->alltoall_base(pending->output, pending->input, pending->received_counts,
                                      pending->sent_counts));
    } catch (const std::exception& error) {
      static_cast<void>(pending.release());  // a thread of Gloo may still write there
      throw fault_of_exchange(error.what());
    }
    add_exchange(watch.seconds(), others);
  }

  /// Tensors from where they lie to where they shall lie.
  class GlooExchange final : public TensorExchange {
   public:
    explicit GlooExchange(GlooWorkers& workers) : workers_(workers) {}

    torch::Tensor exchange(const torch::Tensor& sent, std::vector<std::int64_t> sent_counts,
                           std::vector<std::int64_t> received_counts) override {
      const std::int64_t length =
          std::accumulate(received_counts.begin(), received_counts.end(), std::int64_t{0});
      torch::Tensor output = at::empty({length}, sent.options());
      workers_.complete({.output = output,
                         .input = sent.contiguous(),
                         .received_counts = std::move(received_counts),
                         .sent_counts = std::move(sent_counts),
                         .memory = nullptr});
      return output;
    }

   private:
    GlooWorkers& workers_;
  };

  /// Waits until all are there, and compares what they are.
  void greet() {
    const std::string own = lines_of(options_.traits);
    notes_->say(hello(place_.rank), own);
    std::vector<std::optional<std::string>> said(static_cast<std::size_t>(place_.size));
    const Stopwatch watch;
    while (!have_all_come(said)) {
      end_if_interrupted();
      if (const auto fault = fault_of_process()) fail("--workers: {} before it had begun", *fault);
      if (watch.seconds() > options_.wait_s) fail_for_absent(said);
      std::this_thread::sleep_for(kLook);
    }
    for (int k = 1; k < place_.size; ++k) {
      const std::string& other = *said[static_cast<std::size_t>(k)];
      if (other != *said[0]) {
        fail(
            "--workers: worker {} of {} has {} than worker 0: start all with the same program and options, "
            "on processors of one kind",
            k, place_.size, difference(options_.traits, *said[0], other));
      }
    }
  }

  /// One that has ended can no longer be asked.
  bool have_all_come(std::vector<std::optional<std::string>>& said) {
    for (int k = 0; k < place_.size; ++k) {
      std::optional<std::string>& note = said[static_cast<std::size_t>(k)];
      if (!note) note = notes_->said(hello(k));
    }
    return std::ranges::all_of(said, [](const auto& note) { return note.has_value(); });
  }

  [[noreturn]] void fail_for_absent(const std::vector<std::optional<std::string>>& said) const {
    std::vector<int> absent;
    for (int k = 0; k < place_.size; ++k) {
      if (!said[static_cast<std::size_t>(k)]) absent.push_back(k);
    }
    fail(
        "--workers: worker {} of {} did not come within {:g} s; look at its own output, or wait longer by "
        "--wait",
        fmt::join(absent, ", "), place_.size, options_.wait_s);
  }

  /// Connects each with each, which cannot be broken off: where one is lost meanwhile, it is left alone.
  void connect() {
    auto options = Gloo::Options::create(kNoTimeLimit);
    options->threads = 1;
    options->devices.push_back(network_device(place_));
    std::packaged_task<c10::intrusive_ptr<Gloo>()> task([store = notes_->store(), options, place = place_] {
      return c10::make_intrusive<Gloo>(store, place.rank, place.size, options);
    });
    std::future<c10::intrusive_ptr<Gloo>> connected = task.get_future();
    std::thread(std::move(task)).detach();
    while (connected.wait_for(kPatience) != std::future_status::ready) {
      if (is_over()) fail("--workers: a worker was lost while they connected to each other");
      end_if_interrupted();
    }
    try {
      group_ = connected.get();
    } catch (const std::exception& error) {
      const std::string_view text = error.what();
      fail("--workers: the workers cannot connect to each other: {}", text.substr(0, text.find('\n')));
    }
  }

  bool is_over() { return watch_->has_seen_fault() || fault_of_process().has_value(); }

  std::optional<std::string> fault_of_process() const {
    return options_.fault_of_process ? options_.fault_of_process() : std::nullopt;
  }

  void wait_for(c10d::Work& work) {
    while (!work.isCompleted()) {
      try {
        work.wait(kPatience);
      } catch (const std::exception&) {  // also where it is done by now
        if (!work.isCompleted()) end_if_over();
      }
    }
    work.wait();  // throws what has gone wrong
  }

  void say(const std::string& name, const std::string& note) {
    try {
      notes_->say(name, note);
    } catch (const std::exception&) {
      is_notes_lost_ = true;
    }
  }

  std::optional<std::string> heard(const std::string& name) {
    try {
      return notes_->said(name);
    } catch (const std::exception&) {
      is_notes_lost_ = true;
      return std::nullopt;
    }
  }

  void say_fault(const std::string& own) {
    say(fault_of(place_.rank), own);
    say("fault", "");
  }

  /// What worker 0 finds out: who failed, else who was ended by the system, else who is silent.
  std::string verdict_of(const std::string& own) {
    if (!own.empty()) return own;
    const Stopwatch watch;
    while (watch.seconds() < kTimeToTell) {
      for (int k = 1; k < place_.size; ++k) {
        const auto fault = heard(fault_of(k));
        if (fault && !fault->empty()) return fmt::format("worker {} of {}: {}", k, place_.size, *fault);
      }
      if (const auto fault = fault_of_process()) {
        if (fault->find("signal") != std::string::npos) return *fault;
      }
      std::this_thread::sleep_for(kLook);
    }
    const std::vector<int> silent = watch_ ? watch_->silent_for(kSilence) : std::vector<int>();
    if (!silent.empty()) {
      return fmt::format("worker {} of {} was lost: its process ended, or its connection was cut",
                         fmt::join(silent, ", "), place_.size);
    }
    return fault_of_process().value_or(
        fmt::format("the connection between two workers was cut: {}", reasons()));
  }

  /// What the workers that are left have seen.
  std::string reasons() {
    std::vector<std::string> all;
    for (int k = 0; k < place_.size; ++k) {
      const auto seen = heard(reason(k));
      if (seen && !seen->empty()) all.push_back(fmt::format("worker {}: {}", k, *seen));
    }
    return fmt::format("{}", fmt::join(all, "; "));
  }

  /// The first line of the first fault that this worker has seen.
  void remember(std::string_view fault) {
    if (reason_.empty()) reason_ = fault.substr(0, fault.find('\n'));
  }

  /// What another than worker 0 hears: nothing where worker 0 knows.
  std::optional<std::string> verdict_heard() {
    const Stopwatch watch;
    while (watch.seconds() < 2 * kTimeToTell && !is_notes_lost_) {
      const bool is_worker_0_gone = fault_of_process().has_value();  // before: it may speak, then end
      if (heard("verdict")) return std::nullopt;
      if (is_worker_0_gone) break;
      std::this_thread::sleep_for(kLook);
    }
    return fmt::format("worker 0 of {} was lost: its process ended, or its connection was cut", place_.size);
  }

  /// Worker 0 stays until the others have heard what it has said.
  void linger() {
    watch_.reset();
    say(left(place_.rank), "");
    if (place_.rank == 0 && !place_.is_on_one_machine()) wait_for_leaving(1);
  }

  void wait_for_leaving(int first) {
    const Stopwatch watch;
    for (int k = first; k < place_.size; ++k) {
      while (watch.seconds() < kTimeToTell && !heard(left(k))) std::this_thread::sleep_for(kLook);
    }
  }

  JoinOptions options_;
  WorkerPlace place_;
  std::shared_ptr<MeetingPlace> notes_;
  std::unique_ptr<Watch> watch_;
  c10::intrusive_ptr<Gloo> group_;
  std::string reason_;
  bool is_broken_ = false;
  bool is_notes_lost_ = false;
  double seconds_in_exchange_ = 0.0;
  std::int64_t bytes_sent_ = 0;
};

}  // namespace

bool has_workers() {
  return true;
}

std::unique_ptr<JoinedWorkers> join_workers(const JoinOptions& options) {
  return std::make_unique<GlooWorkers>(options);
}

}  // namespace knuckle
