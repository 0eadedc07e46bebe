// SPDX-License-Identifier: Apache-2.0
#include "knuckle/core/interruption.h"

#include <atomic>
#include <csignal>
#include <utility>

#include "knuckle/core/interrupted_by.h"

namespace knuckle {
namespace {

std::atomic<bool> was_asked_to_end = false;
std::atomic<bool> has_got_signal = false;
std::atomic<bool> is_held = false;
static_assert(std::atomic<bool>::is_always_lock_free, "a signal handler may touch nothing else");
pthread_t holder;  // the thread that holds signals; written before is_held
thread_local const std::atomic<bool>* own_end = nullptr;

/// The second signal is left to the system, which ends the program as if nobody watched. Work that ends for
/// another reason is no signal: what it has yet to write would be lost. One that is held comes here where
/// another thread takes it (libraries start some before `main`): it waits with the thread that holds it, else
/// it would be gone with this program's memory.
extern "C" void on_interruption(int signal_number) {
  was_asked_to_end = true;
  if (is_held) {
    ::pthread_kill(holder, signal_number);
    return;
  }
  if (!has_got_signal.exchange(true)) return;
  std::signal(signal_number, SIG_DFL);
  std::raise(signal_number);
}

void watch(int signal_number) {
  struct sigaction before {};
  ::sigaction(signal_number, nullptr, &before);
  if (before.sa_handler == SIG_IGN) return;
  struct sigaction action {};
  action.sa_handler = on_interruption;
  action.sa_flags = SA_RESTART;  // reading and writing files goes on
  ::sigemptyset(&action.sa_mask);
  ::sigaction(signal_number, &action, nullptr);
}

/// SIG_BLOCK or SIG_UNBLOCK for both signals, in this thread.
void set_mask(int how) {
  sigset_t signals;
  ::sigemptyset(&signals);
  ::sigaddset(&signals, SIGINT);
  ::sigaddset(&signals, SIGTERM);
  ::pthread_sigmask(how, &signals, nullptr);
}

}  // namespace

void watch_for_interruption() {
  is_held = false;
  watch(SIGINT);
  watch(SIGTERM);
  set_mask(SIG_UNBLOCK);
}

void hold_interruption() {
  set_mask(SIG_BLOCK);
  holder = ::pthread_self();
  is_held = true;
}

bool is_interrupted() {
  return was_asked_to_end || (own_end != nullptr && *own_end);
}

InterruptedBy::InterruptedBy(const std::atomic<bool>& is_ended)
    : before_(std::exchange(own_end, &is_ended)) {}

InterruptedBy::~InterruptedBy() {
  own_end = before_;
}

void set_interrupted(bool interrupted) {
  was_asked_to_end = interrupted;
  if (!interrupted) has_got_signal = false;
}

void end_if_interrupted() {
  if (is_interrupted()) throw Interrupted("interrupted");
}

}  // namespace knuckle
