#include "optim/checkpoint/checkpoint.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <fstream>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include <nlohmann/json.hpp>

#include "optim/checkpoint/npy.h"
#include "renderer/core/error.h"

namespace pathfit::optim {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

constexpr int kVersion = 1;
constexpr std::size_t kKeptStates = 2;
constexpr std::string_view kPrefix = "state_";

struct NamedArray {
  const char* file;
  std::vector<double>* values;
};

std::array<NamedArray, 5> ArraysOf(FitState& state) {
  return {{{"current.npy", &state.current},
           {"stage_start.npy", &state.stage_start},
           {"costs.npy", &state.costs},
           {"average_older.npy", &state.average.older_sum},
           {"average_newer.npy", &state.average.newer_sum}}};
}

Json ToJson(const FitState& state) {
  return {{"version", kVersion},
          {"fingerprint", state.fingerprint},
          {"sequence", state.sequence},
          {"step", state.step},
          {"stage", state.stage},
          {"round", state.round},
          {"wall_s", state.wall_s},
          {"radius_factor", state.radius_factor},
          {"damping", state.damping},
          {"rejected_in_row", state.rejected_in_row},
          {"average_older_weight", state.average.older_weight},
          {"average_newer_weight", state.average.newer_weight},
          {"average_newer_start", state.average.newer_start}};
}

void FromJson(const Json& json, FitState& state) {
  json.at("fingerprint").get_to(state.fingerprint);
  json.at("sequence").get_to(state.sequence);
  json.at("step").get_to(state.step);
  json.at("stage").get_to(state.stage);
  json.at("round").get_to(state.round);
  json.at("wall_s").get_to(state.wall_s);
  json.at("radius_factor").get_to(state.radius_factor);
  json.at("damping").get_to(state.damping);
  json.at("rejected_in_row").get_to(state.rejected_in_row);
  json.at("average_older_weight").get_to(state.average.older_weight);
  json.at("average_newer_weight").get_to(state.average.newer_weight);
  json.at("average_newer_start").get_to(state.average.newer_start);
}

std::vector<fs::path> StateFolders(const fs::path& folder) {
  std::vector<fs::path> states;
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(folder, error)) {
    if (entry.path().filename().string().starts_with(kPrefix)) {
      states.push_back(entry.path());
    }
  }
  std::sort(states.begin(), states.end(), std::greater<>());
  return states;
}

FitState ReadState(const fs::path& folder) {
  const fs::path path = folder / "state.json";
  FitState state;
  try {
    std::ifstream file(path);
    const Json json = Json::parse(file);
    const int version = json.at("version").get<int>();
    if (version != kVersion) {
      throw renderer::IoError(path.string() + ": version " + std::to_string(version) +
                              "; this program reads version " + std::to_string(kVersion));
    }
    FromJson(json, state);
  } catch (const Json::exception& error) {
    throw renderer::IoError(path.string() + ": " + error.what());
  }
  for (const NamedArray& array : ArraysOf(state)) {
    *array.values = ReadNpy(folder / array.file);
  }
  return state;
}

void WriteState(const fs::path& folder, FitState state) {
  fs::create_directories(folder);
  for (const NamedArray& array : ArraysOf(state)) {
    WriteNpy(folder / array.file, *array.values);
  }
  std::ofstream file(folder / "state.json");
  file << ToJson(state).dump(2) << '\n';
  file.close();
  if (!file) {
    throw renderer::IoError((folder / "state.json").string() + ": cannot be written");
  }
}

}  // namespace

void WriteCheckpoint(const fs::path& folder, const FitState& state) {
  std::array<char, 16> number{};
  std::snprintf(number.data(), number.size(), "%06d", state.sequence);
  const fs::path temporary = folder / (".tmp_" + std::string(kPrefix) + number.data());
  const fs::path target = folder / (std::string(kPrefix) + number.data());
  try {
    fs::remove_all(temporary);
    WriteState(temporary, state);
    fs::remove_all(target);
    fs::rename(temporary, target);
    const std::vector<fs::path> states = StateFolders(folder);
    for (std::size_t i = kKeptStates; i < states.size(); ++i) {
      fs::remove_all(states[i]);
    }
  } catch (const fs::filesystem_error& error) {
    throw renderer::IoError(folder.string() + ": cannot write a checkpoint: " + error.what());
  }
}

std::optional<FitState> ReadNewestCheckpoint(const fs::path& folder) {
  std::string first_error;
  for (const fs::path& path : StateFolders(folder)) {
    try {
      return ReadState(path);
    } catch (const renderer::IoError& error) {
      first_error = first_error.empty() ? error.what() : first_error;
    }
  }
  if (!first_error.empty()) {
    throw renderer::IoError(first_error);
  }
  return std::nullopt;
}

}  // namespace pathfit::optim
