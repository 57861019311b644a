#include "app/command/command_line.h"

#include <algorithm>
#include <array>
#include <memory>
#include <sstream>
#include <utility>

#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>

#include "app/config/nearest_name.h"
#include "app/config/thread_count.h"
#include "app/config/utf8.h"

namespace pathfit::app {
namespace {

constexpr const char* kFooter =
    "Result paths go to stdout, everything else to stderr. Status: 0 done, 2 command line wrong, "
    "3 config wrong,\n4 input data wrong, 5 numerical failure, 7 check failed, 8 too little "
    "memory, "
    "75 stopped (with a checkpoint, or the disk is full), 130 Ctrl-C with a checkpoint.";

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
  throw UsageError(command, option + ": '" + text + "' is not one of: " + JoinNames(names));
}

template <class T, std::size_t kCount>
std::string WordOf(T wanted, const std::array<std::pair<const char*, T>, kCount>& words) {
  for (const auto& [name, value] : words) {
    if (value == wanted) return name;
  }
  throw std::logic_error("a value without a word");
}

constexpr std::array<std::pair<const char*, LogLevel>, 5> kLevels = {{{"trace", LogLevel::kTrace},
                                                                      {"debug", LogLevel::kDebug},
                                                                      {"info", LogLevel::kInfo},
                                                                      {"warn", LogLevel::kWarn},
                                                                      {"error", LogLevel::kError}}};
constexpr std::array<std::pair<const char*, ColorMode>, 3> kColors = {
    {{"auto", ColorMode::kAuto}, {"always", ColorMode::kAlways}, {"never", ColorMode::kNever}}};
constexpr std::array<std::pair<const char*, ProgressMode>, 5> kModes = {
    {{"auto", ProgressMode::kAuto},
     {"bar", ProgressMode::kBar},
     {"plain", ProgressMode::kPlain},
     {"json", ProgressMode::kJson},
     {"none", ProgressMode::kNone}}};

int ParseThreads(const std::string& command, const std::string& option, const std::string& text) {
  try {
    return RequireThreadCount(option, text);
  } catch (const std::invalid_argument& error) {
    throw UsageError(command, error.what());
  }
}

// Options of every command, which may also stand before its name; there also stand those that only
// some commands have.
struct GlobalWords {
  int verbose = 0, quiet = 0;
  bool version = false;
  std::string log_level, threads, color, progress;

  void Declare(CLI::App& app, OptionList& options, CommandLine& line) {
    app.set_help_flag("-h,--help", "Prints this help");
    if (app.get_parent() == nullptr) options.Flag("--version", "Prints the version", version);
    app.add_flag_function(
        "-v",
        [this](std::int64_t count) { verbose += static_cast<int>(count); },
        "More messages (-vv: still more)");
    app.add_flag_function(
        "-q",
        [this](std::int64_t count) { quiet += static_cast<int>(count); },
        "Errors only, and what is not in the derivative; no progress");
    options.Word("--log-level", "trace|debug|info|warn|error", "Which messages", log_level);
    options.Path("--log-file", "PATH", "Also writes messages to this file", line.log_file);
    if (app.get_parent() == nullptr) {
      options.Seed();
      options.Threads();
    }
    options.Word("--color", "auto|always|never", "Colours of messages", color);
    options.Word("--progress",
                 "auto|bar|plain|json|none",
                 "Messages and how a fit shows its rounds",
                 progress);
    options.Flag("--json", "Prints the result on stdout as JSON", line.json);
  }

  void Store(const std::string& command, const Environment& environment, CommandLine& line) const {
    if (verbose > 0 && quiet > 0) throw UsageError(command, "-q and -v exclude each other");
    if (const std::string level = environment("PATHFIT_LOG_LEVEL"); !level.empty()) {
      line.log_level = ParseWord(command, "PATHFIT_LOG_LEVEL", level, kLevels);
    }
    if (quiet > 0) line.log_level = LogLevel::kError;
    if (verbose > 0) line.log_level = verbose > 1 ? LogLevel::kTrace : LogLevel::kDebug;
    if (!log_level.empty()) line.log_level = ParseWord(command, "--log-level", log_level, kLevels);
    if (const std::string text = environment(kThreadsVariable); !text.empty()) {
      line.default_threads = ParseThreads(command, kThreadsVariable, text);
    }
    for (const ConfigOverride& given : line.overrides) {
      if (given.label != "--threads") continue;
      const std::size_t value = given.assignment.find('=') + 1;
      line.threads = ParseThreads(command, given.label, given.assignment.substr(value));
    }
    if (!color.empty()) line.color = ParseWord(command, "--color", color, kColors);
    if (quiet > 0) line.progress = ProgressMode::kNone;
    if (!progress.empty()) line.progress = ParseWord(command, "--progress", progress, kModes);
  }
};

std::vector<std::string> NamesOf(const Commands& commands) {
  std::vector<std::string> names;
  for (const Command* command : commands) names.emplace_back(command->name);
  names.emplace_back("help");
  return names;
}

/// One of the arguments that Command::target speaks of.
struct TargetWord {
  std::string name;
  bool is_optional = false, is_list = false;
  std::vector<std::string> words;  ///< that may stand there; empty: any
};

std::vector<TargetWord> WordsOf(const Command& command) {
  std::vector<TargetWord> words;
  std::istringstream text(command.target == nullptr ? "" : command.target);
  for (std::string word; text >> word;) {
    TargetWord& target = words.emplace_back();
    target.is_optional = word.starts_with('[');
    target.is_list = word.ends_with("...");
    for (const char c : word) {
      if (c != '[' && c != ']' && c != '.') target.name += c;
    }
    target.words = WordsOfType(target.name);
  }
  return words;
}

std::vector<std::string> OptionNames(const CLI::App& app) {
  std::vector<std::string> names;
  for (const CLI::Option* option : app.get_options()) {
    for (const std::string& name : option->get_lnames()) names.push_back("--" + name);
  }
  return names;
}

[[noreturn]] void RefuseUseless(const std::string& command, const std::string& option) {
  throw UsageError(command, option + " has no use");
}

// What stands before a command that does not declare it.
void RefuseUseless(const CLI::App& root, const CLI::App& app) {
  const std::vector<std::string> known = OptionNames(app);
  for (const CLI::Option* option : root.get_options()) {
    if (option->count() == 0 || option->get_lnames().empty()) continue;
    const std::string name = "--" + option->get_lnames().front();
    if (!Contains(known, name)) RefuseUseless(app.get_name(), name);
  }
}

// What the parser could not place: an unknown option or one word too many.
void RefuseExtras(const Commands& commands,
                  const CLI::App& root,
                  const CLI::App& app,
                  const std::string& command) {
  const std::vector<std::string> extras = app.remaining();
  for (const std::string& word : extras) {
    if (word.size() < 2 || word.front() != '-') continue;
    const std::string name = word.substr(0, word.find('='));
    if (!command.empty() && Contains(OptionNames(root), name)) RefuseUseless(command, name);
    const std::vector<std::string> known = OptionNames(app);
    const std::string nearest = NearestName(name, known);
    std::string hint = nearest.empty() ? "" : " (did you mean '" + nearest + "'?)";
    for (const CLI::App* other : root.get_subcommands(nullptr)) {
      const std::vector<std::string> theirs = OptionNames(*other);
      if (std::ranges::find(theirs, name) != theirs.end()) {
        hint = " (it belongs to 'pathfit " + other->get_name() + "')";
        break;
      }
    }
    throw UsageError(command,
                     std::string("unknown option '").append(name).append("'").append(hint));
  }
  if (extras.empty()) return;
  const std::string& word = extras.front();
  if (command.empty()) {
    throw UsageError(command, "unknown command '" + word + "'" + NameHint(word, NamesOf(commands)));
  }
  throw UsageError(command, "unexpected argument '" + word + "'");
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

std::string HelpOf(const Commands& commands, const CLI::App& root, const std::string& command) {
  if (command.empty()) return root.help();
  const std::vector<std::string> names = NamesOf(commands);
  if (std::ranges::find(names, command) == names.end()) {
    throw UsageError("", "unknown command '" + command + "'" + NameHint(command, names));
  }
  return root.get_subcommand(command)->help("pathfit");
}

/// The whole command line, declared.
struct Declarations {
  struct Declared {
    const Command* command;
    CLI::App* app;
    std::vector<TargetWord> words;
    std::vector<std::unique_ptr<std::vector<std::string>>> given;  // for each of the words
    OptionList own, global;
    Action run;

    void StoreWords(CommandLine& into) const {
      for (std::size_t i = 0; i < words.size(); ++i) {
        std::vector<std::string>& texts = *given[i];
        std::erase(texts, "");
        if (texts.empty() && !words[i].is_optional) {
          throw UsageError(command->name, words[i].name + " is missing");
        }
        const std::vector<std::string>& known = words[i].words;
        for (const std::string& text : texts) {
          if (known.empty() || Contains(known, text)) continue;
          throw UsageError(command->name, "'" + text + "' is not known" + NameHint(text, known));
        }
        into.targets.insert(into.targets.end(), texts.begin(), texts.end());
      }
      if (!into.targets.empty()) into.target = into.targets.front();
    }
  };
  const Commands& commands;
  CLI::App root{"Fits a scene (mesh, colours, lights) to photographs.", "pathfit"};
  CommandLine line;
  GlobalWords globals;
  std::string help_target;
  OptionList before{root, line};
  std::vector<std::unique_ptr<Declared>> all;

  explicit Declarations(const Commands& all_commands) : commands(all_commands) {
    root.footer(kFooter);
    root.allow_extras();
    root.require_subcommand(0, 1);
    globals.Declare(root, before, line);
    for (const Command* command : commands) Declare(*command);
    root.add_subcommand("help", "Prints help, also of one command")
        ->add_option("COMMAND", help_target, "")
        ->type_name("");
  }
  Declarations(const Declarations&) = delete;
  Declarations& operator=(const Declarations&) = delete;

  /// Null: `help`.
  [[nodiscard]] Declared* Find(const std::string& name) const {
    const auto found = std::ranges::find_if(
        all, [&](const auto& declared) { return declared->command->name == name; });
    return found == all.end() ? nullptr : found->get();
  }
  Declared* Choose(const std::string& name) {
    Declared* const chosen = Find(name);
    if (chosen == nullptr) return nullptr;
    line.command = chosen->command;
    line.run = chosen->run;
    return chosen;
  }

 private:
  void Declare(const Command& command) {
    CLI::App* sub = root.add_subcommand(command.name, command.doc);
    all.push_back(std::make_unique<Declared>(Declared{
        &command, sub, WordsOf(command), {}, OptionList(*sub, line), OptionList(*sub, line), {}}));
    Declared& declared = *all.back();
    for (const TargetWord& word : declared.words) {
      std::vector<std::string>& given = *declared.given.emplace_back(
          std::make_unique<std::vector<std::string>>(word.is_list ? 0 : 1));
      (word.is_list ? sub->add_option(word.name, given, "")
                    : sub->add_option(word.name, given.front(), ""))
          ->type_name("");
    }
    declared.run = command.prepare(declared.own);
    globals.Declare(*sub, declared.global, line);
  }
};

std::vector<DeclaredOption> OptionsOf(const CLI::App& app) {
  std::vector<DeclaredOption> options;
  for (const CLI::Option* option : app.get_options()) {
    if (option->get_positional()) continue;
    DeclaredOption& declared = options.emplace_back();
    for (const std::string& name : option->get_snames()) declared.names.push_back("-" + name);
    for (const std::string& name : option->get_lnames()) declared.names.push_back("--" + name);
    if (option->get_items_expected_max() > 0) declared.type = option->get_type_name();
    declared.doc = option->get_description();
  }
  return options;
}

}  // namespace

UsageError::UsageError(const std::string& command, const std::string& text)
    : std::runtime_error([&] {
        const std::string name = command.empty() ? "pathfit" : "pathfit " + command;
        return name + ": " + text + "\nTry '" + name + " --help'. Nothing was run (status 2)";
      }()) {}

CommandLine ParseCommandLine(const std::vector<std::string>& arguments,
                             const Environment& environment,
                             const Commands& commands) {
  for (const std::string& argument : arguments) {
    if (FirstBadByte(argument)) throw UsageError("", "an argument is not UTF-8 text");
  }
  Declarations declarations(commands);
  CLI::App& root = declarations.root;
  CommandLine& line = declarations.line;
  line.arguments = arguments;
  std::vector<std::string> words(arguments.rbegin(), arguments.rend());
  if (!words.empty()) words.pop_back();
  try {
    root.parse(words);
  } catch (const CLI::CallForHelp&) {
    line.help_text = root.help();
    return line;
  } catch (const CLI::ParseError& error) {
    const auto parsed = root.get_subcommands();
    throw UsageError(parsed.empty() ? "" : parsed.back()->get_name(), Explain(error));
  }
  RefuseExtras(commands, root, root, "");
  if (declarations.globals.version) {
    declarations.Choose("version");
    return line;
  }
  if (root.get_subcommands().empty()) {
    throw UsageError("", "a command is needed: " + JoinNames(NamesOf(commands)));
  }
  const CLI::App& sub = *root.get_subcommands().front();
  const std::string name = sub.get_name();
  RefuseExtras(commands, root, sub, name);
  Declarations::Declared* const chosen = declarations.Choose(name);
  if (chosen == nullptr) {
    line.help_text = HelpOf(commands, root, declarations.help_target);
    return line;
  }
  RefuseUseless(root, sub);
  declarations.before.Finish();
  chosen->StoreWords(line);
  chosen->global.Finish();
  chosen->own.Finish();
  declarations.globals.Store(name, environment, line);
  return line;
}

std::vector<std::string> MessageOptions(const CommandLine& line) {
  return {"--log-level=" + WordOf(line.log_level, kLevels),
          "--color=" + WordOf(line.color, kColors),
          "--progress=" + WordOf(line.progress, kModes)};
}

std::vector<std::string> WordsOfType(const std::string& type) {
  const bool lower = !type.empty() && std::ranges::all_of(type, [](char c) {
    return (c >= 'a' && c <= 'z') || c == '-' || c == '|' || c == ',';
  });
  std::vector<std::string> words;
  if (!lower) return words;
  for (std::size_t at = 0; at <= type.size();) {
    const std::size_t end = std::min(type.find_first_of("|,", at), type.size());
    words.push_back(type.substr(at, end - at));
    at = end + 1;
  }
  return words;
}

DeclaredProgram DescribeProgram() {
  const Declarations declarations(AllCommands());
  const CLI::App& root = declarations.root;
  DeclaredProgram program{root.get_description(), root.get_footer(), OptionsOf(root), {}};
  for (const CLI::App* sub : root.get_subcommands(nullptr)) {
    DeclaredCommand& command = program.commands.emplace_back();
    command.name = sub->get_name();
    command.doc = sub->get_description();
    command.options = OptionsOf(*sub);
    const Declarations::Declared* const known = declarations.Find(command.name);
    const char* const target = known == nullptr ? "[COMMAND]" : known->command->target;
    std::istringstream words(target == nullptr ? "" : target);
    for (std::string word; words >> word;) command.targets.push_back(word);
    if (known != nullptr) command.result = known->command->result;
  }
  return program;
}

}  // namespace pathfit::app
