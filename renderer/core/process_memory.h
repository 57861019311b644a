#pragma once

#include <cstdlib>
#include <fstream>
#include <string>

#if defined(__GLIBC__)
#include <malloc.h>
#endif

namespace pathfit::renderer {

/// Of this process in bytes, by a key of Linux' /proc/self/status ("VmRSS:" resident now, "VmHWM:"
/// at most so far); 0 where the system does not tell.
inline double ProcessMemory(const std::string& key) {
  std::ifstream status("/proc/self/status");
  for (std::string line; std::getline(status, line);) {
    if (line.starts_with(key)) {
      return 1024.0 * std::strtod(line.c_str() + key.size(), nullptr);
    }
  }
  return 0.0;
}

/// Gives the system back what was freed: between phases that take their memory in pieces of
/// different sizes, it stands in the way of the next one's.
inline void ReturnFreedMemory() {
#if defined(__GLIBC__)
  malloc_trim(0);
#endif
}

}  // namespace pathfit::renderer
