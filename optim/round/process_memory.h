#pragma once

#include <cstdlib>
#include <fstream>
#include <string>

namespace pathfit::optim {

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

}  // namespace pathfit::optim
