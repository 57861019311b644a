#include <cstdint>
#include <string>

#include <OpenEXR/OpenEXRConfig.h>
#include <OpenMesh/Core/System/config.h>
#include <fmt/format.h>
#include <oneapi/tbb/version.h>
#include <opencv4/opencv2/core/version.hpp>
#include <openvdb/version.h>

#include "app/command/command_line.h"
#include "app/command/result.h"
#include "app/output/fields.h"
#include "renderer/core/process_memory.h"

namespace pathfit::app::info_command {
namespace {

const char* InstructionSet() {
  if (__builtin_cpu_supports("avx512f") != 0) return "AVX-512";
  if (__builtin_cpu_supports("avx2") != 0) return "AVX2";
  if (__builtin_cpu_supports("avx") != 0) return "AVX";
  return "SSE2";
}

Json Describe(const CommandLine& line) {
  RunRecord record = MakeRunRecord(line.arguments);
  FillProgramInfo(record);
  Json json = {{"version", record.program_version},
               {"build", record.build},
               {"checks", PATHFIT_CHECKS != 0},
               {"libraries", record.libraries},
               {"cpu", record.host.cpu},
               {"instruction_set", InstructionSet()},
               {"threads", NumThreads(line, 0)},
               {"memory_bytes", static_cast<std::int64_t>(renderer::MemoryLimit())}};
  json["libraries"]["OpenCV"] = CV_VERSION;
  json["libraries"]["OpenEXR"] = OPENEXR_VERSION_STRING;
  json["libraries"]["oneTBB"] = fmt::format("{}.{}", TBB_VERSION_MAJOR, TBB_VERSION_MINOR);
  json["libraries"]["OpenMesh"] = fmt::format("{}.{}", OM_GET_VER, OM_GET_MAJ);
  json["libraries"]["OpenVDB"] = OPENVDB_LIBRARY_VERSION_STRING;
  return json;
}

constexpr ResultKey kInfoResult[] = {
    {"version", "text", "Of pathfit"},
    {"build", "text", "Compiler and build type"},
    {"checks", "boolean", "Whether internal checks are compiled in"},
    {"libraries", "map", "Versions by name"},
    {"cpu", "text", ""},
    {"instruction_set", "text", "The widest that the processor has"},
    {"threads", "whole", "What a run would use"},
    {"memory_bytes", "whole", "That a process can have here"}};
constexpr ResultKey kVersionResult[] = {{"version", "text", "Of pathfit"},
                                        {"build", "text", "Compiler and build type"},
                                        {"libraries", "map", "Versions by name"}};

ExitStatus Info(CommandContext& context) {
  const Json info = Describe(context.line);
  if (context.line.json) {
    PrintResult(context, info);
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
  fmt::print(
      "CPU              {} ({})\nthreads          {}\nmemory           {:.1f} GiB\nGPU             "
      " not used\n",
      info["cpu"].get<std::string>(),
      info["instruction_set"].get<std::string>(),
      info["threads"].get<int>(),
      info["memory_bytes"].get<double>() / kGiB);
  return ExitStatus::kFinished;
}

ExitStatus Version(CommandContext& context) {
  RunRecord record;
  FillProgramInfo(record);
  if (context.line.json) {
    const Json json = {{"version", record.program_version},
                       {"build", record.build},
                       {"libraries", record.libraries}};
    PrintResult(context, json);
    return ExitStatus::kFinished;
  }
  fmt::print("pathfit {} ({})\n", record.program_version, record.build);
  for (const auto& [name, version] : record.libraries) fmt::print("  {} {}\n", name, version);
  return ExitStatus::kFinished;
}

Action PrepareInfo(OptionList& options) {
  options.Threads();
  return Info;
}

Action PrepareVersion(OptionList& /*options*/) { return Version; }

}  // namespace

extern const Command kInfoCommand = {
    "info", "Prints versions, processor, threads and memory", nullptr, PrepareInfo, kInfoResult};

extern const Command kVersionCommand = {
    "version", "Prints the version", nullptr, PrepareVersion, kVersionResult};

}  // namespace pathfit::app::info_command
