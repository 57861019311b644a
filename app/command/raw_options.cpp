#include "app/command/raw_options.h"

#include <algorithm>
#include <array>

#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>

#include "app/config/nearest_name.h"
#include "app/config/utf8.h"

namespace pathfit::app {
namespace {

constexpr const char* kFooter =
    "Result paths go to stdout, everything else to stderr. Status: 0 done, 2 command line wrong, "
    "3 config wrong,\n4 input data wrong, 5 numerical failure, 7 check failed, 8 too little "
    "memory, "
    "75 and 130 stopped with a checkpoint.";

struct CommandInfo {
  const char* name;
  CommandName command;
  const char* doc;
  const char* target;  // name of the positional argument, null if there is none
};
constexpr std::array<CommandInfo, 7> kCommands = {{
    {"check", CommandName::kCheck, "Checks a config and its input files; fits nothing", "CONFIG"},
    {"fit", CommandName::kFit, "Fits a scene to photos; prints the run directory", "CONFIG"},
    {"resume", CommandName::kResume, "Continues a run from its newest checkpoint", "RUN"},
    {"render", CommandName::kRender, "Renders views, or derivative images", "CONFIG|RUN"},
    {"gradcheck",
     CommandName::kGradcheck,
     "Compares derivatives with finite differences; status 7 if they disagree",
     "CONFIG"},
    {"version", CommandName::kVersion, "Prints the version", nullptr},
    {"help", CommandName::kHelp, "Prints help, also of one command", "COMMAND"},
}};

void AddText(
    CLI::App& app, const char* name, std::string& value, const char* type, const char* doc) {
  app.add_option(name, value, doc)->type_name(type)->take_last();
}

// One value per occurrence: without this the parser would also take the words that follow.
void AddTexts(CLI::App& app,
              const char* name,
              std::vector<std::string>& values,
              const char* type,
              const char* doc) {
  app.add_option(name, values, doc)->type_name(type)->take_all()->allow_extra_args(false);
}

void AddGlobalOptions(CLI::App& app, RawOptions& raw) {
  const CLI::App* parent = app.get_parent();
  app.set_help_flag("-h,--help", "Prints this help");
  if (parent == nullptr) app.add_flag("--version", raw.version, "Prints the version");
  app.add_flag_function(
      "-v",
      [&raw](std::int64_t count) { raw.verbose += static_cast<int>(count); },
      "More messages (-vv: still more)");
  app.add_flag_function(
      "-q", [&raw](std::int64_t count) { raw.quiet += static_cast<int>(count); }, "Errors only");
  AddText(app, "--log-level", raw.log_level, "LEVEL", "trace, debug, info, warn or error");
  AddText(app, "--log-file", raw.log_file, "PATH", "Also writes messages to this file");
  AddText(app, "--threads", raw.threads, "N", "Bounds every kind of thread");
  AddText(app, "--seed", raw.seed, "N", "Replaces the config's seed");
  AddText(app, "--color", raw.color, "WHEN", "auto, always or never");
  AddText(app, "--progress", raw.progress, "HOW", "auto, bar, plain, json or none");
  app.add_flag("--json", raw.json, "Prints the result on stdout as JSON");
}

void AddConfigOptions(CLI::App& app, RawOptions& raw) {
  AddTexts(app, "--set", raw.set, "KEY=VALUE", "Replaces a value of the config; may be repeated");
  AddText(app, "--max-memory", raw.max_memory, "SIZE", "Refuses to start above it, e.g. 12GiB");
}

void AddCommandOptions(CLI::App& app, CommandName command, RawOptions& raw) {
  switch (command) {
    case CommandName::kCheck:
      AddConfigOptions(app, raw);
      break;
    case CommandName::kFit:
      AddConfigOptions(app, raw);
      AddText(app, "-o,--output", raw.output, "DIR", "Run directory");
      AddText(app, "--time-limit", raw.time_limit, "TIME", "Stops with a checkpoint, e.g. 2h, 90m");
      AddText(app, "--stop-after", raw.stop_after, "STAGE", "Ends after this stage");
      break;
    case CommandName::kResume:
      AddText(app, "--time-limit", raw.time_limit, "TIME", "Stops with a checkpoint, e.g. 2h, 90m");
      break;
    case CommandName::kRender:
      AddConfigOptions(app, raw);
      AddText(app, "-o,--output", raw.output, "DIR", "Where images go");
      AddText(app, "--views", raw.views, "LIST", "Photos by index or name, e.g. 0,3,8; or all");
      AddTexts(app, "--sensor", raw.sensors, "NAME", "A sensor or photo; may be repeated");
      AddText(app, "--spp", raw.spp, "N", "Samples per pixel");
      AddTexts(app, "--derivative", raw.derivatives, "PARAM", "Derivative image; may be repeated");
      AddText(app,
              "--terms",
              raw.terms,
              "LIST",
              "Of the derivative: interior,primary,direct,indirect,pixel");
      AddText(app, "--form", raw.form, "FORM", "Of the derivative: image or material");
      break;
    case CommandName::kGradcheck:
      AddConfigOptions(app, raw);
      AddText(app, "-o,--output", raw.output, "DIR", "Where images and the table go");
      AddTexts(app, "--params", raw.params, "GLOB", "Which parameters; may be repeated");
      AddText(app, "--form", raw.form, "FORM", "Of the derivative: image or material");
      AddText(app, "--step", raw.step, "X", "Of the finite difference");
      AddText(app, "--spp", raw.spp, "N", "Samples per pixel");
      AddText(app, "--replicates", raw.replicates, "N", "Independent renderings");
      AddText(app, "--sigma", raw.sigma, "X", "Largest difference in standard errors");
      break;
    case CommandName::kVersion:
    case CommandName::kHelp:
      break;
  }
}

std::vector<std::string> CommandNames() {
  std::vector<std::string> names;
  names.reserve(kCommands.size());
  for (const CommandInfo& info : kCommands) names.emplace_back(info.name);
  return names;
}

std::vector<std::string> OptionNames(const CLI::App& app) {
  std::vector<std::string> names;
  for (const CLI::Option* option : app.get_options()) {
    for (const std::string& name : option->get_lnames()) names.push_back("--" + name);
  }
  return names;
}

// What the parser could not place: an unknown option or one word too many.
void RefuseExtras(const CLI::App& root, const CLI::App& app, const std::string& command) {
  const std::vector<std::string> extras = app.remaining();
  for (const std::string& word : extras) {
    if (word.size() < 2 || word.front() != '-') continue;
    const std::string name = word.substr(0, word.find('='));
    const std::vector<std::string> known = OptionNames(app);
    const std::string nearest = NearestName(name, known);
    std::string hint = nearest.empty() ? "" : " (did you mean '" + nearest + "'?)";
    for (const CLI::App* other : root.get_subcommands(nullptr)) {
      const std::vector<std::string> theirs = OptionNames(*other);
      if (std::find(theirs.begin(), theirs.end(), name) != theirs.end()) {
        hint = " (it belongs to 'pathfit " + other->get_name() + "')";
        break;
      }
    }
    ThrowUsage(command, std::string("unknown option '").append(name).append("'").append(hint));
  }
  if (extras.empty()) return;
  const std::string& word = extras.front();
  if (command.empty()) {
    ThrowUsage(command, "unknown command '" + word + "'" + NameHint(word, CommandNames()));
  }
  ThrowUsage(command, "unexpected argument '" + word + "'");
}

// In words of ours; the parser's name the option before a colon.
std::string Explain(const CLI::ParseError& error) {
  std::string text = error.what();
  const std::size_t colon = text.find(':');
  if (error.get_name() == "ArgumentMismatch" && colon != std::string::npos) {
    return "option " + text.substr(0, colon) + " needs a value";
  }
  return text;
}

std::string HelpOf(const CLI::App& root, const std::string& command) {
  if (command.empty()) return root.help();
  const std::vector<std::string> names = CommandNames();
  if (std::find(names.begin(), names.end(), command) == names.end()) {
    ThrowUsage("", "unknown command '" + command + "'" + NameHint(command, names));
  }
  return root.get_subcommand(command)->help("pathfit");
}

// Everything but what a parse error leaves: which command, and whether all words found a place.
void FinishRaw(const CLI::App& root, RawOptions& raw) {
  RefuseExtras(root, root, "");
  if (raw.version) {
    raw.command = CommandName::kVersion;
    return;
  }
  if (root.get_subcommands().empty()) {
    ThrowUsage("", "a command is needed: " + JoinNames(CommandNames()));
  }
  const CLI::App& sub = *root.get_subcommands().front();
  raw.command_name = sub.get_name();
  RefuseExtras(root, sub, raw.command_name);
  const CommandInfo& info =
      *std::find_if(kCommands.begin(), kCommands.end(), [&raw](const CommandInfo& candidate) {
        return candidate.name == raw.command_name;
      });
  raw.command = info.command;
  if (info.command == CommandName::kHelp) {
    raw.help_text = HelpOf(root, raw.target);
  } else if (info.target != nullptr && raw.target.empty()) {
    ThrowUsage(raw.command_name, std::string(info.target) + " is missing");
  }
}

}  // namespace

RawOptions ParseRawOptions(const std::vector<std::string>& arguments) {
  for (const std::string& argument : arguments) {
    if (FirstBadByte(argument)) ThrowUsage("", "an argument is not UTF-8 text");
  }
  CLI::App root("Fits a scene (mesh, colours, lights) to photographs.", "pathfit");
  RawOptions raw;
  root.footer(kFooter);
  root.allow_extras();
  root.require_subcommand(0, 1);
  AddGlobalOptions(root, raw);
  for (const CommandInfo& info : kCommands) {
    CLI::App* sub = root.add_subcommand(info.name, info.doc);
    if (info.target != nullptr) sub->add_option(info.target, raw.target, "")->type_name("");
    AddCommandOptions(*sub, info.command, raw);
    AddGlobalOptions(*sub, raw);
  }
  std::vector<std::string> words(arguments.rbegin(), arguments.rend());
  if (!words.empty()) words.pop_back();
  try {
    root.parse(words);
  } catch (const CLI::CallForHelp&) {
    raw.help_text = root.help();
    return raw;
  } catch (const CLI::ParseError& error) {
    const auto parsed = root.get_subcommands();
    ThrowUsage(parsed.empty() ? "" : parsed.back()->get_name(), Explain(error));
  }
  FinishRaw(root, raw);
  return raw;
}

[[noreturn]] void ThrowUsage(const std::string& command, const std::string& text) {
  const std::string name = command.empty() ? "pathfit" : "pathfit " + command;
  throw UsageError(name + ": " + text + "\nTry '" + name + " --help'. Nothing was run (status 2)");
}

}  // namespace pathfit::app
