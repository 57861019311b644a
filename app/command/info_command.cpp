#include <cstdint>
#include <fstream>
#include <string>

#include <OpenEXR/OpenEXRConfig.h>
#include <OpenMesh/Core/System/config.h>
#include <fmt/format.h>
#include <oneapi/tbb/version.h>
#include <opencv4/opencv2/core/version.hpp>
#include <openvdb/version.h>
#include <unistd.h>

#include "app/command/command_line.h"
#include "app/command/program_info.h"
#include "app/output/fields.h"

namespace pathfit::app {
namespace {

// Value of the first line of /proc/cpuinfo that starts with `key`.
std::string CpuInfo(const std::string& key) {
  std::ifstream file("/proc/cpuinfo");
  for (std::string line; std::getline(file, line);) {
    const std::size_t value = line.find(": ");
    if (line.starts_with(key) && value != std::string::npos) return line.substr(value + 2);
  }
  return "unknown";
}

const char* InstructionSet() {
  if (__builtin_cpu_supports("avx512f") != 0) return "AVX-512";
  if (__builtin_cpu_supports("avx2") != 0) return "AVX2";
  if (__builtin_cpu_supports("avx") != 0) return "AVX";
  return "SSE2";
}

std::int64_t MemoryBytes() {
  return static_cast<std::int64_t>(sysconf(_SC_PHYS_PAGES)) * sysconf(_SC_PAGE_SIZE);
}

Json Describe(const CommandLine& line) {
  RunRecord record;
  FillProgramInfo(record);
  Json json = {{"version", record.program_version},
               {"build", record.build},
               {"checks", PATHFIT_CHECKS != 0},
               {"libraries", Json::object()},
               {"cpu", CpuInfo("model name")},
               {"instruction_set", InstructionSet()},
               {"threads", NumThreads(line, 0)},
               {"memory_bytes", MemoryBytes()}};
  for (const auto& [name, version] : record.libraries) json["libraries"][name] = version;
  json["libraries"]["OpenCV"] = CV_VERSION;
  json["libraries"]["OpenEXR"] = OPENEXR_VERSION_STRING;
  json["libraries"]["oneTBB"] = fmt::format("{}.{}", TBB_VERSION_MAJOR, TBB_VERSION_MINOR);
  json["libraries"]["OpenMesh"] = fmt::format("{}.{}", OM_GET_VER, OM_GET_MAJ);
  json["libraries"]["OpenVDB"] = OPENVDB_LIBRARY_VERSION_STRING;
  return json;
}

void Declare(OptionList& /*options*/, CommandLine& /*line*/) {}

ExitStatus Run(CommandContext& context) {
  const Json info = Describe(context.line);
  if (context.line.json) {
    fmt::print("{}\n", JsonText(info));
    return ExitStatus::kFinished;
  }
  constexpr double kGiB = 1073741824.0;
  fmt::print("pathfit {}\nbuild            {}{}\n",
             info["version"].get<std::string>(),
             info["build"].get<std::string>(),
             info["checks"].get<bool>() ? ", with checks" : "");
  for (const auto& [name, version] : info["libraries"].items()) {
    fmt::print("{:<16} {}\n", name, version.get<std::string>());
  }
  fmt::print("CPU              {} ({})\nthreads          {}\nmemory           {:.1f} GiB\n",
             info["cpu"].get<std::string>(),
             info["instruction_set"].get<std::string>(),
             info["threads"].get<int>(),
             info["memory_bytes"].get<double>() / kGiB);
  return ExitStatus::kFinished;
}

}  // namespace

extern const Command kInfoCommand = {
    "info", "Prints versions, processor, threads and memory", nullptr, Declare, Run};

}  // namespace pathfit::app
