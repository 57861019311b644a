#include "app/command/stop_signals.h"

#include <csignal>
#include <string_view>

#include <unistd.h>

namespace pathfit::app {
namespace {

struct SignalState {
  renderer::CancelFlag cancel{false};
  std::atomic<int> first{0};
};

/// Handlers can reach static storage only.
SignalState& State() {
  static SignalState state;
  return state;
}

void Say(std::string_view text) {
  [[maybe_unused]] const ssize_t written = write(STDERR_FILENO, text.data(), text.size());
}

extern "C" void HandleStopSignal(int signal) {
  SignalState& state = State();
  if (state.first.load() == SIGINT && signal == SIGINT) {
    _exit(static_cast<int>(ExitStatus::kInterrupted));
  }
  state.first = signal;
  state.cancel = true;
  if (signal == SIGINT) Say("\nstopping - press again to quit now\n");
}

/// Whether the signal was to be ignored when the program began, as under nohup.
bool IsIgnored(int signal) {
  struct sigaction action = {};
  return sigaction(signal, nullptr, &action) == 0 && action.sa_handler == SIG_IGN;
}

void Install(void (*handler)(int)) {
  struct sigaction action = {};
  action.sa_handler = handler;
  sigemptyset(&action.sa_mask);
  action.sa_flags = SA_RESTART;
  sigaction(SIGINT, &action, nullptr);
  sigaction(SIGTERM, &action, nullptr);
  if (!IsIgnored(SIGHUP)) sigaction(SIGHUP, &action, nullptr);
}

}  // namespace

StopSignals::StopSignals() {
  State().cancel = false;
  State().first = 0;
  Install(HandleStopSignal);
}

StopSignals::~StopSignals() { Install(SIG_DFL); }

renderer::CancelFlag& StopSignals::flag() const { return State().cancel; }

std::optional<ExitStatus> StopSignals::Received() const {
  switch (State().first.load()) {
    case SIGINT:
      return ExitStatus::kInterrupted;
    case SIGTERM:
      return ExitStatus::kStopped;
    default:
      return std::nullopt;
  }
}

}  // namespace pathfit::app
