#include "optim/round/peak_memory.h"

#include <cstdlib>
#include <fstream>
#include <string>

namespace pathfit::optim {

double PeakResidentMegabytes() {
  std::ifstream status("/proc/self/status");
  constexpr const char* kKey = "VmHWM:";
  for (std::string line; std::getline(status, line);) {
    if (line.starts_with(kKey)) {
      return std::strtod(line.c_str() + std::string(kKey).size(), nullptr) / 1e3 * 1.024;
    }
  }
  return 0.0;
}

}  // namespace pathfit::optim
