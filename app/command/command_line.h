#pragma once

#include <cstdint>
#include <exception>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

#include "app/config/config_error.h"
#include "app/output/log.h"
#include "app/output/run_record.h"
#include "app/output/terminal.h"

namespace CLI {
class App;
}  // namespace CLI
namespace pathfit::optim {
class Ranks;
}  // namespace pathfit::optim

namespace pathfit::app {

struct Command;
struct CommandContext;

/// What the process returns; README.md lists the same table.
enum class ExitStatus {
  kFinished = 0,       ///< also --help
  kInternalError = 1,  ///< a bug; the message asks for log.txt
  kUsage = 2,          ///< command line wrong
  kConfig = 3,         ///< config wrong, all problems listed
  kInput = 4,          ///< input data missing, unreadable or inconsistent
  kNumerical = 5,      ///< NaN, no usable step; the last accepted state is saved
  kCheckFailed = 7,    ///< gradcheck outside its limits
  kMemory = 8,         ///< would exceed the memory limit, or allocation failed
  /// By --time-limit or SIGTERM, with a checkpoint (`pathfit resume`), or by a full disk: nothing
  /// is wrong with the input, the same may be tried again.
  kStopped = 75,
  kInterrupted = 130,  ///< Ctrl-C, with a checkpoint
};

/// Runs a command with the values that it was given. Wrong input throws: ConfigError, IoError,
/// SceneError, MemoryError, NumericalError.
using Action = std::function<ExitStatus(CommandContext&)>;

/// What the user asked for: values only, checked one by one; nothing has been opened. What a
/// command alone takes is in its action.
struct CommandLine {
  const Command* command = nullptr;  ///< null: help_text goes to stdout
  Action run;                        ///< the command
  std::string help_text;
  std::filesystem::path target;                ///< CONFIG or RUN, relative to the working directory
  std::vector<std::filesystem::path> targets;  ///< all such words, `target` first
  std::vector<std::string> arguments;          ///< argv as given, for the record of the run
  /// The changes to the config: every --set, then the flags that stand for a value of it.
  std::vector<ConfigOverride> overrides;

  LogLevel log_level = LogLevel::kInfo;  ///< -v debug, -vv trace, -q error, --log-level
  std::filesystem::path log_file;        ///< empty: none beside that of the run
  std::optional<int> threads;            ///< --threads
  std::optional<int> default_threads;    ///< PATHFIT_THREADS, where the config says auto
  ColorMode color = ColorMode::kAuto;
  ProgressMode progress = ProgressMode::kAuto;
  bool json = false;  ///< machine-readable result on stdout
};

/// The command line is wrong: what() is the complete message, the status is ExitStatus::kUsage.
class UsageError : public std::runtime_error {
 public:
  /// `command` is empty for what no command says.
  UsageError(const std::string& command, const std::string& text);
};

/// How a command declares its options. Values are stored once all words have found their place;
/// an option that was not given leaves its value alone.
class OptionList {
 public:
  OptionList(CLI::App& app, CommandLine& line);

  void Flag(const char* names, const char* doc, bool& value);
  void Text(const char* names, const std::string& type, const char* doc, std::string& value);
  void Path(const char* names,
            const std::string& type,
            const char* doc,
            std::filesystem::path& value);
  /// May be repeated; each takes one word.
  void Texts(const char* names,
             const std::string& type,
             const char* doc,
             std::vector<std::string>& value);
  /// Words separated by commas, none empty. `type`: "LIST", or all that are allowed: "glb,obj,ply".
  void List(const char* names,
            const std::string& type,
            const char* doc,
            std::vector<std::string>& value);
  /// One of `words`, "exr|png|jpg".
  void Word(const char* names, const std::string& words, const char* doc, std::string& value);
  /// From `low` to `high`.
  void Number(const char* names, const char* doc, double low, double high, double& value);
  void Whole(const char* names, const char* doc, int low, int high, int& value);
  /// "2h", "1h30m", in seconds.
  void Duration(const char* names, const char* doc, double& value);

  enum class Form {
    kWhole,     ///< of at least `least`
    kPositive,  ///< a number above 0
    kBytes,     ///< "12GiB"
    kText,
    kPath,   ///< made absolute
    kWords,  ///< separated by commas: a list
    kWord,   ///< one of `type`, "image|material"
    kTexts,  ///< may be repeated: a list
  };
  /// A value of the config that has a flag of its own.
  void Override(const char* names,
                const std::string& type,
                const char* doc,
                const char* key,
                Form form,
                std::int64_t least = 0);
  // What several commands have: each declares those that it uses.
  void Set();        ///< --set
  void Seed();       ///< --seed
  void Threads();    ///< --threads
  void MaxMemory();  ///< --max-memory

  /// Runs after all values are stored; throws by Fail.
  void Check(std::function<void()> check) { actions_.push_back(std::move(check)); }
  [[nodiscard]] bool Given(const char* name) const;
  /// In a check: the command's words and what all commands have.
  [[nodiscard]] const CommandLine& line() const { return line_; }
  [[noreturn]] void Fail(const std::string& text) const;

  /// Stores the values of what was given, and checks.
  void Finish();

 private:
  void Add(const char* names,
           const std::string& type,
           const char* doc,
           std::function<void(const std::string&)> store);
  /// Absolute. A leading ~ is replaced here too: shells leave it behind "--output=".
  [[nodiscard]] std::filesystem::path PathOf(const std::string& name,
                                             const std::string& text) const;
  void RequireWord(const std::string& name,
                   const std::vector<std::string>& words,
                   const std::string& text) const;

  CLI::App& app_;
  CommandLine& line_;
  std::vector<std::function<void()>> actions_;
};

/// What every command uses to speak: standard error through terminal and log; results alone go to
/// standard output.
struct CommandContext {
  const CommandLine& line;
  Terminal& terminal;
  Log& log;
  optim::Ranks& ranks;  ///< of which only the first writes files and speaks
};

/// A key of the object that a command prints with --json.
struct ResultKey {
  const char* key;
  const char*
      type;  ///< text, number, whole, boolean, list, map; " or null", " or absent" behind it
  const char* doc;
};

/// A command of the program.
struct Command {
  const char* name;
  const char* doc;
  /// What its arguments are called in help and messages; null: it takes none. "[A] [B]" need not
  /// be given, of "A..." there may be any number, "show|default" are the words that may stand
  /// there.
  const char* target;
  Action (*prepare)(OptionList& options);  ///< declares its options; the action takes their values
  std::span<const ResultKey> result = {};  ///< of --json, below `schema`; empty: it prints text
  bool over_ranks = false;  ///< shares its work among what mpirun starts; else it is refused
};

/// Command::prepare of a command whose options are the members of an `Options` of its own.
template <class Options,
          void (*kDeclare)(OptionList&, Options&),
          ExitStatus (*kRun)(CommandContext&, const Options&)>
Action Prepare(OptionList& list) {
  auto own = std::make_shared<Options>();
  kDeclare(list, *own);
  return [own](CommandContext& context) { return kRun(context, *own); };
}

using Commands = std::vector<const Command*>;
/// In the order of the help.
const Commands& AllCommands();

/// Parses argv (the program's name first). Flags may stand anywhere. Throws UsageError with the
/// nearest command or option when a word is unknown, also for wrong values of PATHFIT_THREADS and
/// PATHFIT_LOG_LEVEL.
CommandLine ParseCommandLine(const std::vector<std::string>& arguments,
                             const Environment& environment,
                             const Commands& commands = AllCommands());

/// The options with which another process says as much as this one, whichever way they were given.
std::vector<std::string> MessageOptions(const CommandLine& line);

/// What the parser knows, as plain values: for completion, the man page and the reference.
struct DeclaredOption {
  std::vector<std::string> names;  ///< "-o", "--output"
  std::string type, doc;           ///< type: "N", "DIR", "auto|never", "glb,obj"; empty: a flag
};
struct DeclaredCommand {
  std::string name, doc;
  std::vector<std::string> targets;  ///< words of Command::target
  std::vector<DeclaredOption> options;
  std::span<const ResultKey> result;
};
struct DeclaredProgram {
  std::string doc, footer;
  std::vector<DeclaredOption> options;  ///< which may also stand before the command
  std::vector<DeclaredCommand> commands;
};
DeclaredProgram DescribeProgram();

/// "a|b|c" or "a,b,c" of lower-case words; empty if a type is no such choice.
std::vector<std::string> WordsOfType(const std::string& type);
/// The other way: names(item) of all items, with a separator between.
template <class Items, class Name>
std::string TypeOfWords(const Items& items, char separator, const Name& name) {
  std::string type;
  for (const auto& item : items) {
    if (!type.empty()) type += separator;
    type += std::invoke(name, item);
  }
  return type;
}

// What commands share.

/// Version, build and library versions.
void FillProgramInfo(RunRecord& record);

/// --threads, then the config, then the environment, then what the machine gives.
/// `in_config` is 0 for auto.
int NumThreads(const CommandLine& line, int in_config);

/// The status a command ends with when this exception reaches main.
ExitStatus StatusOfException(const std::exception& error);

}  // namespace pathfit::app
