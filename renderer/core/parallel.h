#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

namespace pathfit::renderer {

/// Bounds every parallel loop and Embree's build tasks while it lives (one TBB pool).
class ThreadLimit {
 public:
  explicit ThreadLimit(int num_threads);
  ~ThreadLimit();
  ThreadLimit(const ThreadLimit&) = delete;
  ThreadLimit& operator=(const ThreadLimit&) = delete;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// Threads a program should use by default: the affinity mask, cgroup quota and
/// SLURM_CPUS_PER_TASK, whichever is least.
int DefaultNumThreads();

/// Runs body(i) for i in [0, count). The order is free, so bodies write to their own slots only;
/// results must not depend on the thread. An exception of a body reaches the caller.
void ParallelFor(std::int64_t count, const std::function<void(std::int64_t)>& body);

/// Runs body(i, part) for i in [0, count), each with a part of its own, and returns the parts: what
/// is summed from them in order has the same bits for any number of threads.
template <class Part, class Body>
std::vector<Part> ParallelParts(std::int64_t count, const Body& body) {
  std::vector<Part> parts(static_cast<std::size_t>(count));
  ParallelFor(count, [&](std::int64_t i) { body(i, parts[static_cast<std::size_t>(i)]); });
  return parts;
}

/// Set by a signal handler, polled by long loops.
using CancelFlag = std::atomic<bool>;

/// Throws Cancelled (renderer/core/error.h) if the flag is set; null: never.
void ThrowIfCancelled(const CancelFlag* flag);

}  // namespace pathfit::renderer
