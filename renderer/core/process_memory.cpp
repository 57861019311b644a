#include "renderer/core/process_memory.h"

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <limits>

#include <sys/resource.h>
#include <unistd.h>

#if defined(__GLIBC__)
#include <malloc.h>
#endif

namespace pathfit::renderer {
namespace {

namespace fs = std::filesystem;

constexpr double kNoLimit = std::numeric_limits<double>::infinity();

/// "max", and files that are not there, are no limit.
double LimitIn(const fs::path& file) {
  double bytes = 0.0;
  std::ifstream stream(file);
  return stream >> bytes && bytes > 0.0 ? bytes : kNoLimit;
}

double LimitOfAddresses() {
  rlimit limit{};
  if (getrlimit(RLIMIT_AS, &limit) != 0 || limit.rlim_cur == RLIM_INFINITY) return kNoLimit;
  const double mapped_only = ProcessMemory("VmSize:") - ProcessMemory("VmRSS:");
  return std::max(1.0, static_cast<double>(limit.rlim_cur) - mapped_only);
}

}  // namespace

double ProcessMemory(const std::string& key) {
  std::ifstream status("/proc/self/status");
  for (std::string line; std::getline(status, line);) {
    if (line.starts_with(key)) {
      return 1024.0 * std::strtod(line.c_str() + key.size(), nullptr);
    }
  }
  return 0.0;
}

double ControlGroupLimit(const fs::path& groups, const fs::path& mount) {
  double least = kNoLimit;
  std::ifstream stream(groups);
  // Lines "4:memory:/job/step" (version 1) and "0::/job/step" (version 2).
  for (std::string line; std::getline(stream, line);) {
    const std::size_t first = line.find(':');
    const std::size_t second = line.find(':', first + 1);
    if (first == std::string::npos || second == std::string::npos) continue;
    const std::string controllers = line.substr(first + 1, second - first - 1);
    const bool is_new = controllers.empty();
    if (!is_new && ("," + controllers + ",").find(",memory,") == std::string::npos) continue;
    const fs::path root = is_new ? mount : mount / "memory";
    const char* file = is_new ? "memory.max" : "memory.limit_in_bytes";
    // A container sees its own group as the root, whatever its path outside is.
    least = std::min(least, LimitIn(root / file));
    fs::path group = root;
    for (const fs::path& part : fs::path(line.substr(second + 1)).relative_path()) {
      group /= part;
      least = std::min(least, LimitIn(group / file));
    }
  }
  return least;
}

double MemoryLimit() {
  const long pages = sysconf(_SC_PHYS_PAGES);
  const double machine =
      pages > 0 ? static_cast<double>(pages) * static_cast<double>(sysconf(_SC_PAGE_SIZE))
                : kNoLimit;
  const double least = std::min(
      {machine, ControlGroupLimit("/proc/self/cgroup", "/sys/fs/cgroup"), LimitOfAddresses()});
  return least < kNoLimit ? least : 0.0;
}

void ReturnFreedMemory() {
#if defined(__GLIBC__)
  malloc_trim(0);
#endif
}

}  // namespace pathfit::renderer
