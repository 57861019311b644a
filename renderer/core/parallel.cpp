#include "renderer/core/parallel.h"

#include <algorithm>
#include <cstdlib>
#include <exception>
#include <fstream>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include <sched.h>
#include <tbb/global_control.h>
#include <tbb/parallel_for.h>

#include "renderer/core/error.h"

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
  if (sched_getaffinity(0, sizeof(set), &set) == 0) threads = std::max(1, CPU_COUNT(&set));
  std::ifstream cgroup("/sys/fs/cgroup/cpu.max");
  std::string quota;
  double period = 0.0;
  if (cgroup >> quota >> period && quota != "max" && period > 0.0) {
    const double cpus = std::strtod(quota.c_str(), nullptr) / period;
    if (cpus >= 1.0) threads = std::min(threads, static_cast<int>(cpus));
  }
  // NOLINTNEXTLINE(concurrency-mt-unsafe): read once at start-up.
  if (const char* slurm = std::getenv("SLURM_CPUS_PER_TASK")) {
    const int cpus = static_cast<int>(std::strtol(slurm, nullptr, 10));
    if (cpus > 0) threads = std::min(threads, cpus);
  }
  return threads;
}

void ThrowIfCancelled(const CancelFlag* flag) {
  if (flag != nullptr && flag->load(std::memory_order_relaxed)) throw Cancelled();
}

#ifdef PATHFIT_THREAD_SANITIZER

// The thread sanitizer cannot see the synchronisation inside TBB's library and would report every
// loop; plain threads show it ours.
void ParallelFor(std::int64_t count, const std::function<void(std::int64_t)>& body) {
  std::atomic<std::int64_t> next{0};
  std::mutex mutex;
  std::exception_ptr error;
  const auto work = [&] {
    try {
      for (std::int64_t i = next++; i < count; i = next++) body(i);
    } catch (...) {
      const std::lock_guard lock(mutex);
      error = std::current_exception();
      next = count;
    }
  };
  const std::size_t limit =
      tbb::global_control::active_value(tbb::global_control::max_allowed_parallelism);
  std::vector<std::thread> threads;
  for (std::size_t t = 1; t < limit; ++t) threads.emplace_back(work);
  work();
  for (std::thread& thread : threads) thread.join();
  if (error) std::rethrow_exception(error);
}

#else

void ParallelFor(std::int64_t count, const std::function<void(std::int64_t)>& body) {
  tbb::parallel_for(std::int64_t{0}, count, [&](std::int64_t i) { body(i); });
}

#endif

}  // namespace pathfit::renderer
