#include "app/command/command_line.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <utility>

#include "app/command/raw_options.h"
#include "app/config/nearest_name.h"
#include "app/config/scalar.h"

namespace pathfit::app {
namespace {

template <class T>
T ParseWhole(const std::string& command,
             const std::string& option,
             const std::string& text,
             T minimum) {
  T value = 0;
  const char* last = text.data() + text.size();
  const auto [end, error] = std::from_chars(text.data(), last, value);
  if (text.empty() || error != std::errc() || end != last || value < minimum) {
    ThrowUsage(
        command,
        option + ": '" + text + "' is not a whole number of at least " + std::to_string(minimum));
  }
  return value;
}

double ParsePositive(const std::string& command,
                     const std::string& option,
                     const std::string& text) {
  double value = 0.0;
  const char* last = text.data() + text.size();
  const auto [end, error] = std::from_chars(text.data(), last, value);
  if (text.empty() || error != std::errc() || end != last || !std::isfinite(value) ||
      value <= 0.0) {
    ThrowUsage(command, option + ": '" + text + "' is not a number above 0");
  }
  return value;
}

template <class T, std::size_t kCount>
T ParseWord(const std::string& command,
            const std::string& option,
            const std::string& text,
            const std::array<std::pair<const char*, T>, kCount>& words) {
  std::vector<std::string> names;
  for (const auto& [name, value] : words) {
    if (text == name) return value;
    names.emplace_back(name);
  }
  ThrowUsage(command, option + ": '" + text + "' is not one of: " + JoinNames(names));
}

LogLevel ParseLevel(const std::string& command,
                    const std::string& option,
                    const std::string& text) {
  constexpr std::array<std::pair<const char*, LogLevel>, 5> kWords = {
      {{"trace", LogLevel::kTrace},
       {"debug", LogLevel::kDebug},
       {"info", LogLevel::kInfo},
       {"warn", LogLevel::kWarn},
       {"error", LogLevel::kError}}};
  return ParseWord(command, option, text, kWords);
}

std::vector<std::string> SplitList(const std::string& command,
                                   const std::string& option,
                                   const std::string& text) {
  std::vector<std::string> parts;
  const std::string refusal = option + ": '" + text + "' has an empty part";
  for (std::size_t at = 0; at <= text.size();) {
    const std::size_t end = std::min(text.find(',', at), text.size());
    if (end == at) ThrowUsage(command, refusal);
    parts.push_back(text.substr(at, end - at));
    at = end + 1;
  }
  return parts;
}

void ConvertGlobal(const RawOptions& raw,
                   const std::string& command,
                   const Environment& environment,
                   CommandLine& line) {
  if (raw.verbose > 0 && raw.quiet > 0) ThrowUsage(command, "-q and -v exclude each other");
  if (const std::string level = environment("PATHFIT_LOG_LEVEL"); !level.empty()) {
    line.log_level = ParseLevel(command, "PATHFIT_LOG_LEVEL", level);
  }
  if (raw.quiet > 0) line.log_level = LogLevel::kError;
  if (raw.verbose > 0) line.log_level = raw.verbose > 1 ? LogLevel::kTrace : LogLevel::kDebug;
  if (!raw.log_level.empty()) line.log_level = ParseLevel(command, "--log-level", raw.log_level);
  for (const char* name : {"PATHFIT_THREADS", "SLURM_CPUS_PER_TASK"}) {
    const std::string value = environment(name);
    if (!value.empty() && !line.default_threads) {
      line.default_threads = ParseWhole<int>(command, name, value, 1);
    }
  }
  if (!raw.threads.empty()) line.threads = ParseWhole<int>(command, "--threads", raw.threads, 1);
  if (!raw.seed.empty()) line.seed = ParseWhole<std::int64_t>(command, "--seed", raw.seed, 0);
  constexpr std::array<std::pair<const char*, ColorMode>, 3> kColors = {
      {{"auto", ColorMode::kAuto}, {"always", ColorMode::kAlways}, {"never", ColorMode::kNever}}};
  if (!raw.color.empty()) line.color = ParseWord(command, "--color", raw.color, kColors);
  constexpr std::array<std::pair<const char*, ProgressMode>, 5> kModes = {
      {{"auto", ProgressMode::kAuto},
       {"bar", ProgressMode::kBar},
       {"plain", ProgressMode::kPlain},
       {"json", ProgressMode::kJson},
       {"none", ProgressMode::kNone}}};
  if (!raw.progress.empty()) line.progress = ParseWord(command, "--progress", raw.progress, kModes);
  line.log_file = raw.log_file;
  line.json = raw.json;
}

void ConvertSets(const RawOptions& raw, const std::string& command, CommandLine& line) {
  for (std::size_t i = 0; i < raw.set.size(); ++i) {
    const std::string label = "--set #" + std::to_string(i + 1);
    const std::size_t equals = raw.set[i].find('=');
    if (equals == std::string::npos || equals == 0) {
      ThrowUsage(command, label + ": '" + raw.set[i] + "' is not KEY=VALUE");
    }
  }
  line.set = raw.set;
}

void ConvertSpecific(const RawOptions& raw, const std::string& command, CommandLine& line) {
  ConvertSets(raw, command, line);
  line.output = raw.output;
  line.stop_after = raw.stop_after;
  line.derivatives = raw.derivatives;
  line.params = raw.params;
  if (!raw.time_limit.empty()) {
    const std::optional<double> seconds = ParseDuration(raw.time_limit);
    if (!seconds || !(*seconds > 0.0)) {
      ThrowUsage(command,
                 "--time-limit: '" + raw.time_limit + "' is not a time like 2h, 90m, 1h30m or 45s");
    }
    line.time_limit_s = *seconds;
  }
  if (!raw.max_memory.empty()) {
    YamlNode node;
    node.kind = YamlNode::Kind::kScalar;
    node.text = raw.max_memory;
    const Parsed<double> bytes = ParseBytes(node);
    if (!bytes.value) ThrowUsage(command, "--max-memory: " + bytes.problem);
    line.max_memory = raw.max_memory;
  }
  if (!raw.views.empty()) {
    if (raw.views.rfind("orbit:", 0) == 0) {
      ThrowUsage(command, "--views: 'orbit:' is not supported; give indices, names or all");
    }
    if (!raw.sensors.empty()) ThrowUsage(command, "--views and --sensor exclude each other");
    if (raw.views != "all") line.views = SplitList(command, "--views", raw.views);
  }
  if (!raw.sensors.empty()) line.views = raw.sensors;
  line.terms = raw.terms;
  line.form = raw.form;
  for (const auto& [flag, value] : {std::pair{"--terms", raw.terms}, {"--form", raw.form}}) {
    if (!value.empty() && line.command == CommandName::kRender && raw.derivatives.empty()) {
      ThrowUsage(command, std::string(flag) + " needs --derivative");
    }
  }
  if (!raw.step.empty()) line.step = ParsePositive(command, "--step", raw.step);
  if (!raw.sigma.empty()) line.sigma = ParsePositive(command, "--sigma", raw.sigma);
  if (!raw.spp.empty()) line.spp = ParseWhole<int>(command, "--spp", raw.spp, 1);
  if (!raw.replicates.empty()) {
    line.replicates = ParseWhole<int>(command, "--replicates", raw.replicates, 2);
  }
}

// Reads back as the same double; at least one digit before an exponent.
std::string ShortestNumber(double value) {
  std::array<char, 32> buffer{};
  const auto end = std::to_chars(buffer.data(), buffer.data() + buffer.size(), value).ptr;
  return {buffer.data(), end};
}

// As a single-quoted YAML scalar.
std::string Quoted(const std::string& text) {
  std::string out = "'";
  for (const char c : text) out += c == '\'' ? std::string("''") : std::string(1, c);
  return out + "'";
}

}  // namespace

CommandLine ParseCommandLine(const std::vector<std::string>& arguments,
                             const Environment& environment) {
  const RawOptions raw = ParseRawOptions(arguments);
  CommandLine line;
  line.arguments = arguments;
  line.command = raw.command;
  line.help_text = raw.help_text;
  if (line.command == CommandName::kHelp) return line;
  line.target = raw.target;
  ConvertGlobal(raw, raw.command_name, environment, line);
  ConvertSpecific(raw, raw.command_name, line);
  return line;
}

std::vector<ConfigOverride> OverridesOf(const CommandLine& line) {
  std::vector<ConfigOverride> overrides;
  for (std::size_t i = 0; i < line.set.size(); ++i) {
    overrides.push_back({"--set #" + std::to_string(i + 1), line.set[i]});
  }
  const auto add = [&overrides](
                       const std::string& flag, const std::string& key, const std::string& value) {
    overrides.push_back({flag, key + "=" + value});
  };
  if (line.seed) add("--seed", "seed", std::to_string(*line.seed));
  if (line.threads) add("--threads", "solver.threads", std::to_string(*line.threads));
  if (line.max_memory) add("--max-memory", "solver.max_memory", *line.max_memory);
  const bool gradcheck = line.command == CommandName::kGradcheck;
  if (line.spp) add("--spp", gradcheck ? "gradcheck.spp" : "render.spp", std::to_string(*line.spp));
  if (!line.terms.empty()) add("--terms", "render.terms", "[" + line.terms + "]");
  if (!line.form.empty()) add("--form", "render.form", Quoted(line.form));
  if (line.command == CommandName::kFit && !line.output.empty()) {
    add("-o", "output.directory", Quoted(std::filesystem::absolute(line.output).string()));
  }
  if (line.replicates)
    add("--replicates", "gradcheck.replicates", std::to_string(*line.replicates));
  if (line.step) add("--step", "gradcheck.step", ShortestNumber(*line.step));
  if (line.sigma) add("--sigma", "gradcheck.sigma", ShortestNumber(*line.sigma));
  if (!line.params.empty()) {
    std::string list;
    for (const std::string& name : line.params) list += (list.empty() ? "" : ", ") + Quoted(name);
    add("--params", "gradcheck.params", "[" + list + "]");
  }
  return overrides;
}

}  // namespace pathfit::app
