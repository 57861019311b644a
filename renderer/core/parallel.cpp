#include "renderer/core/parallel.h"

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <string>

#include <sched.h>
#include <tbb/global_control.h>
#include <tbb/parallel_for.h>

namespace pathfit::renderer {

struct ThreadLimit::Impl {
  explicit Impl(int num_threads)
      : control(tbb::global_control::max_allowed_parallelism,
                static_cast<std::size_t>(std::max(1, num_threads))) {}
  tbb::global_control control;
};

ThreadLimit::ThreadLimit(int num_threads) : impl_(std::make_unique<Impl>(num_threads)) {}
ThreadLimit::~ThreadLimit() = default;

int DefaultNumThreads() {
  int threads = 1;
  cpu_set_t set;
  CPU_ZERO(&set);
  if (sched_getaffinity(0, sizeof(set), &set) == 0) {
    threads = std::max(1, CPU_COUNT(&set));
  }
  std::ifstream cgroup("/sys/fs/cgroup/cpu.max");
  std::string quota;
  double period = 0.0;
  if (cgroup >> quota >> period && quota != "max" && period > 0.0) {
    const double cpus = std::strtod(quota.c_str(), nullptr) / period;
    if (cpus >= 1.0) {
      threads = std::min(threads, static_cast<int>(cpus));
    }
  }
  // NOLINTNEXTLINE(concurrency-mt-unsafe): read once at start-up.
  if (const char* slurm = std::getenv("SLURM_CPUS_PER_TASK")) {
    const int cpus = static_cast<int>(std::strtol(slurm, nullptr, 10));
    if (cpus > 0) {
      threads = std::min(threads, cpus);
    }
  }
  return threads;
}

void ParallelFor(std::int64_t count, const std::function<void(std::int64_t)>& body) {
  tbb::parallel_for(std::int64_t{0}, count, [&](std::int64_t i) { body(i); });
}

}  // namespace pathfit::renderer
