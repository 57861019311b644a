// Gives every reader damaged files: each must be read, or refused with a message. See README.md.
#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <fstream>
#include <iostream>
#include <optional>
#include <thread>

#include <sys/resource.h>
#include <unistd.h>

#include "app/config/config_error.h"
#include "renderer/core/error.h"
#include "tests/fuzz/fuzz_targets.h"
#include "tests/fuzz/mutator.h"

#ifdef PATHFIT_ADDRESS_SANITIZER
extern "C" const char* __asan_default_options();
extern "C" const char* __asan_default_options() {
  // The largest image that is read, 2^28 pixels of three floats, takes 3 GiB.
  return "max_allocation_size_mb=4096:hard_rss_limit_mb=8000:detect_leaks=1";
}
#endif

namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;
using pathfit::tests::FileSet;
using pathfit::tests::FuzzTarget;
using pathfit::tests::Mutator;

#ifdef PATHFIT_ADDRESS_SANITIZER
constexpr double kLongestS = 30.0;  // for one input
#else
constexpr double kLongestS = 10.0;
#endif

struct Options {
  std::string target;
  std::uint64_t inputs = 200, first = 1;
  double seconds = 0.0;
};

std::atomic<double> started{-1.0};  // of the input that is read, as ProcessorSeconds; else negative
std::atomic<bool> over{false};

/// Of this process: on a busy machine a clock would find what is none.
double ProcessorSeconds() {
  timespec time{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

/// Ends the process when an input takes too long; its files stay where they are.
void Watch() {
  while (!over) {
    std::this_thread::sleep_for(std::chrono::milliseconds(200));
    const double since = started;
    if (since < 0.0 || ProcessorSeconds() - since < kLongestS) continue;
    std::printf("FOUND: an input took more than %.0f s\n", kLongestS);
    std::fflush(stdout);
    std::_Exit(1);
  }
}

void WriteFile(const fs::path& path, const std::string& bytes) {
  std::ofstream file(path, std::ios::binary);
  file.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
}

/// One of the files of a seed, damaged.
FileSet Damaged(const FuzzTarget& target, Mutator& mutator) {
  FileSet files = target.seeds[mutator.Below(target.seeds.size())];
  const FileSet& other = target.seeds[mutator.Below(target.seeds.size())];
  auto victim = files.begin();
  std::advance(victim, static_cast<std::ptrdiff_t>(mutator.Below(files.size())));
  const auto same = other.find(victim->first);
  victim->second = mutator.Mutate(
      victim->second, same == other.end() ? std::string() : same->second, target.words);
  if (target.mend && mutator.Below(4) > 0) target.mend(victim->second);
  return files;
}

/// What a reader threw that it must not; empty for a result or a refusal.
std::optional<std::string> Read(const FuzzTarget& target, const fs::path& folder) {
  try {
    target.read(folder);
  } catch (const pathfit::renderer::IoError& error) {
    if (std::string(error.what()).empty()) return "an empty message";
  } catch (const pathfit::renderer::SceneError&) {
  } catch (const pathfit::renderer::NumericalError&) {
  } catch (const pathfit::app::ConfigError&) {
  } catch (const std::exception& error) {
    return error.what();
  }
  return std::nullopt;
}

struct Outcome {
  std::uint64_t inputs = 0, found = 0;
  double slowest_s = 0.0;
};

void KeepInput(const fs::path& from, const fs::path& to) {
  fs::create_directories(to);
  fs::copy(from, to, fs::copy_options::recursive | fs::copy_options::overwrite_existing);
}

/// Inputs first, first + 1 ... until their number or the time is reached. Each is a function of its
/// number and the target.
Outcome Run(const FuzzTarget& target, const Options& options, const fs::path& folder) {
  Outcome outcome;
  const fs::path input = folder / target.name;
  const auto wanted = static_cast<std::uint64_t>(
      std::max(1.0, target.weight * static_cast<double>(options.inputs)));
  const auto start = Clock::now();
  const auto more = [&] {
    const std::chrono::duration<double> taken = Clock::now() - start;
    return options.seconds > 0.0 ? taken.count() < options.seconds : outcome.inputs < wanted;
  };
  std::seed_seq name(target.name.begin(), target.name.end());
  std::uint32_t salt = 0;
  name.generate(&salt, &salt + 1);
  fs::create_directories(input);
  for (std::uint64_t number = options.first; more(); ++number) {
    Mutator mutator(number << 32U | salt);
    for (const auto& [file, bytes] : Damaged(target, mutator)) WriteFile(input / file, bytes);
    const double before = ProcessorSeconds();
    started = before;
    const std::optional<std::string> wrong = Read(target, input);
    started = -1.0;
    outcome.slowest_s = std::max(outcome.slowest_s, ProcessorSeconds() - before);
    ++outcome.inputs;
    if (!wrong) continue;
    ++outcome.found;
    const fs::path kept = folder / ("found_" + target.name + "_" + std::to_string(number));
    KeepInput(input, kept);
    std::cout << "FOUND: " << target.name << " --first " << number << ": " << *wrong << "\n  "
              << kept << "\n";
  }
  return outcome;
}

bool ReadOptions(int argc, char** argv, Options& options) {
  for (int i = 1; i + 1 < argc; i += 2) {
    const std::string key = argv[i], value = argv[i + 1];
    if (key == "--target") {
      options.target = value;
    } else if (key == "--inputs") {
      options.inputs = std::strtoull(value.c_str(), nullptr, 10);
    } else if (key == "--first") {
      options.first = std::strtoull(value.c_str(), nullptr, 10);
    } else if (key == "--seconds") {
      options.seconds = std::strtod(value.c_str(), nullptr);
    } else {
      return false;
    }
  }
  return argc % 2 == 1;
}

}  // namespace

int main(int argc, char** argv) {
  Options options;
  if (!ReadOptions(argc, argv, options)) {
    std::cerr << "usage: fuzz [--target NAME] [--inputs N | --seconds S] [--first N]\n";
    return 2;
  }
#ifndef PATHFIT_ADDRESS_SANITIZER
  constexpr rlim_t kMemory = rlim_t{6} << 30U;
  const rlimit limit{kMemory, kMemory};
  setrlimit(RLIMIT_AS, &limit);
  // What image libraries say of each file; of the sanitizers it is wanted.
  if (std::freopen("/dev/null", "w", stderr) == nullptr) return 2;
#endif
  const fs::path folder = fs::temp_directory_path() / ("pathfit_fuzz_" + std::to_string(getpid()));
  fs::create_directories(folder / "seeds");
  std::cout << "inputs are written in " << folder << ", and stay after a crash" << std::endl;
  const std::vector<FuzzTarget> targets = pathfit::tests::FuzzTargets(folder / "seeds");
  std::thread watch(Watch);
  std::uint64_t inputs = 0, found = 0;
  for (const FuzzTarget& target : targets) {
    if (!options.target.empty() && target.name != options.target) continue;
    // A seed that is refused would only ever find its own mistake.
    for (const FileSet& seed : target.seeds) {
      const fs::path at = folder / "whole";
      fs::create_directories(at);
      for (const auto& [file, bytes] : seed) WriteFile(at / file, bytes);
      try {
        target.read(at);
      } catch (const std::exception& error) {
        if (target.name != "ply" && target.name != "config") {
          std::cout << "FOUND: a seed of " << target.name << " is refused: " << error.what()
                    << "\n";
          ++found;
        }
      }
      fs::remove_all(at);
    }
    const Outcome outcome = Run(target, options, folder);
    inputs += outcome.inputs;
    found += outcome.found;
    std::printf("%-14s %8llu inputs, %llu found, slowest %.3f s\n",
                target.name.c_str(),
                static_cast<unsigned long long>(outcome.inputs),
                static_cast<unsigned long long>(outcome.found),
                outcome.slowest_s);
    std::fflush(stdout);
  }
  over = true;
  watch.join();
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  std::printf("%llu inputs, %llu found, at most %ld MB\n",
              static_cast<unsigned long long>(inputs),
              static_cast<unsigned long long>(found),
              usage.ru_maxrss / 1024);
  if (inputs == 0) return 2;
  if (found == 0) fs::remove_all(folder);
  return found == 0 ? 0 : 1;
}
