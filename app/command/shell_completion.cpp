#include "app/command/shell_completion.h"

#include <algorithm>
#include <map>

#include <fmt/format.h>

#include "app/config/schema.h"

namespace pathfit::app {
namespace {

constexpr const char* kKeyValue = "KEY=";

/// How a value is completed, from its type: "file", "folder", "key", "word a b", "list a b", or
/// "none".
std::string KindOf(const std::string& type) {
  const std::vector<std::string> words = WordsOfType(type);
  if (!words.empty()) {
    std::string kind = type.find(',') != std::string::npos ? "list" : "word";
    for (const std::string& word : words) kind += " " + word;
    return kind;
  }
  if (type.starts_with(kKeyValue)) return "key";
  if (type == "DIR" || type == "PHOTOS") return "folder";
  for (const char* file : {"PATH", "FILE", "CONFIG", "CONFIG|RUN", "RUN", "CAMERAS", "IN", "OUT"}) {
    if (type == file) return "file";
  }
  return "none";
}

std::string BareTarget(const std::string& word) {
  std::string bare;
  for (const char c : word) {
    if (c != '[' && c != ']' && c != '.') bare += c;
  }
  return bare;
}

std::string Joined(const std::vector<std::string>& words, const std::string& between) {
  std::string text;
  for (const std::string& word : words) text += (text.empty() ? "" : between) + word;
  return text;
}

std::string CommandNamesOf(const DeclaredProgram& program) {
  std::string names;
  for (const DeclaredCommand& command : program.commands) {
    names += (names.empty() ? "" : " ") + command.name;
  }
  return names;
}

/// Kinds of the arguments of a command; `help` takes names of commands.
std::vector<std::string> TargetKinds(const DeclaredCommand& command,
                                     const DeclaredProgram& program) {
  std::vector<std::string> kinds;
  for (const std::string& target : command.targets) {
    const std::string bare = BareTarget(target);
    kinds.push_back(bare == "COMMAND" ? "word " + CommandNamesOf(program) : KindOf(bare));
    if (target.ends_with("...")) kinds.back() += "...";
  }
  return kinds;
}

void AddKeys(const SchemaNode& map, const std::string& path, std::vector<std::string>& keys) {
  for (const SchemaNode& child : map.children) {
    const std::string key = JoinPath(path, child.key);
    if (child.type == SchemaNode::Type::kMap) {
      AddKeys(child, key, keys);
    } else if (child.type != SchemaNode::Type::kNamedMap) {
      keys.push_back(key);
    }
  }
}

/// For one shell's string in single quotes.
std::string Quoted(const std::string& text, const char* quote) {
  std::string out = "'";
  for (const char c : text) out += c == '\'' ? std::string(quote) : std::string(1, c);
  return out + "'";
}

constexpr const char* kPosixQuote = "'\\''";
constexpr const char* kFishQuote = "\\'";

/// Functions that bash and zsh share: what follows an option, an argument, and what there is.
std::string Tables(const DeclaredProgram& program) {
  std::string options, values, targets;
  for (const DeclaredCommand& command : program.commands) {
    std::vector<std::string> names;
    std::map<std::string, std::vector<std::string>> by_kind;
    for (const DeclaredOption& option : command.options) {
      names.insert(names.end(), option.names.begin(), option.names.end());
      if (option.type.empty()) continue;
      for (const std::string& name : option.names) by_kind[KindOf(option.type)].push_back(name);
    }
    options +=
        fmt::format("    {}) echo {} ;;\n", command.name, Quoted(Joined(names, " "), kPosixQuote));
    for (const auto& [kind, of] : by_kind) {
      std::vector<std::string> patterns;
      for (const std::string& name : of) patterns.push_back(command.name + ":" + name);
      values +=
          fmt::format("    {}) echo {} ;;\n", Joined(patterns, "|"), Quoted(kind, kPosixQuote));
    }
    const std::vector<std::string> kinds = TargetKinds(command, program);
    for (std::size_t i = 0; i < kinds.size(); ++i) {
      const bool many = kinds[i].ends_with("...");
      targets += fmt::format(
          "    {}:{}) echo {} ;;\n",
          command.name,
          many ? "*" : std::to_string(i),
          Quoted(many ? kinds[i].substr(0, kinds[i].size() - 3) : kinds[i], kPosixQuote));
    }
  }
  std::vector<std::string> before, before_values;
  for (const DeclaredOption& option : program.options) {
    before.insert(before.end(), option.names.begin(), option.names.end());
    if (option.type.empty()) continue;
    for (const std::string& name : option.names) {
      before_values.push_back(
          fmt::format("    :{}) echo {} ;;\n", name, Quoted(KindOf(option.type), kPosixQuote)));
    }
  }
  std::vector<std::string> keys;
  for (const std::string& key : SettableKeys()) keys.push_back(key + "=");
  return fmt::format(
      "_pathfit_commands={}\n_pathfit_keys={}\n"
      "_pathfit_options() {{\n  case $1 in\n{}    *) echo {} ;;\n  esac\n}}\n"
      "_pathfit_value() {{\n  case $1:$2 in\n{}{}  esac\n}}\n"
      "_pathfit_target() {{\n  case $1:$2 in\n{}  esac\n}}\n",
      Quoted(CommandNamesOf(program), kPosixQuote),
      Quoted(Joined(keys, " "), kPosixQuote),
      options,
      Quoted(Joined(before, " "), kPosixQuote),
      values,
      Joined(before_values, ""),
      targets);
}

/// Sets `command`, the number of its arguments so far, and `kind`, from the words before the last.
constexpr const char* kScan = R"sh(
_pathfit_scan() {
  command= kind= count=0
  local word value=
  for word in "$@"; do
    if [[ -n $value ]]; then value=; continue; fi
    case $word in
      --*=*) ;;
      -*) value=$(_pathfit_value "$command" "$word") ;;
      *)
        if [[ -n $command ]]; then
          count=$((count + 1))
        elif [[ " $_pathfit_commands " == *" $word "* ]]; then
          command=$word
        fi ;;
    esac
  done
  kind=$value
}
)sh";

constexpr const char* kBashMain = R"sh(
_pathfit() {
  local command kind count words
  local current=${COMP_WORDS[COMP_CWORD]}
  local before=("${COMP_WORDS[@]:1:COMP_CWORD-1}")
  local last=$((${#before[@]} - 1))
  # "--color=never" comes as three words.
  if [[ $current == '=' && $last -ge 0 ]]; then
    current=
  elif [[ $last -ge 1 && ${before[last]} == '=' && ${before[last-1]} == --* ]]; then
    unset 'before[last]'
  fi
  # "--set a.b=c" does, too: what is behind '=' is free.
  [[ $last -ge 2 && ${before[last]} == '=' ]] && return
  _pathfit_scan "${before[@]}"
  COMPREPLY=()
  if [[ -z $kind ]]; then
    if [[ $current == -* ]]; then
      COMPREPLY=($(compgen -W "$(_pathfit_options "$command")" -- "$current"))
      return
    fi
    if [[ -z $command ]]; then
      COMPREPLY=($(compgen -W "$_pathfit_commands" -- "$current"))
      return
    fi
    kind=$(_pathfit_target "$command" "$count")
  fi
  words=${kind#* }
  case $kind in
    word\ *) COMPREPLY=($(compgen -W "$words" -- "$current")) ;;
    list\ *)
      local done=
      [[ $current == *,* ]] && done=${current%,*},
      COMPREPLY=($(compgen -P "$done" -W "$words" -- "${current##*,}"))
      compopt -o nospace 2>/dev/null ;;
    key)
      COMPREPLY=($(compgen -W "$_pathfit_keys" -- "$current"))
      compopt -o nospace 2>/dev/null ;;
    folder|file)
      compopt -o filenames 2>/dev/null
      # A name may hold spaces, which are typed with a backslash.
      mapfile -t COMPREPLY < <(compgen "$([[ $kind == file ]] && echo -f || echo -d)" -- "${current//\\/}") ;;
  esac
}
complete -F _pathfit pathfit
)sh";

constexpr const char* kZshMain = R"sh(
_pathfit() {
  emulate -L zsh
  local command kind count
  local current=${words[CURRENT]}
  _pathfit_scan "${(@)words[2,CURRENT-1]}"
  if [[ -z $kind && $current == --*=* ]]; then
    kind=$(_pathfit_value "$command" "${current%%=*}")
    compset -P '--*='
  elif [[ -z $kind && $current == -* ]]; then
    compadd -- ${=$(_pathfit_options "$command")}
    return
  elif [[ -z $kind && -z $command ]]; then
    compadd -- ${=_pathfit_commands}
    return
  elif [[ -z $kind ]]; then
    kind=$(_pathfit_target "$command" "$count")
  fi
  case $kind in
    word\ *) compadd -- ${=kind#* } ;;
    list\ *) compset -P '*,'; compadd -S '' -- ${=kind#* } ;;
    key) compadd -S '' -- ${=_pathfit_keys} ;;
    folder) _files -/ ;;
    file) _files ;;
  esac
}
if [[ $zsh_eval_context[-1] == loadautofunc ]]; then
  _pathfit "$@"
else
  compdef _pathfit pathfit
fi
)sh";

std::string FishValue(const std::string& type) {
  const std::string kind = KindOf(type);
  if (kind.starts_with("word ") || kind.starts_with("list ")) {
    return fmt::format(" -x -a {}", Quoted(kind.substr(5), kFishQuote));
  }
  if (kind == "key") return " -x -a '(__pathfit_keys)'";
  if (kind == "folder") return " -x -a '(__fish_complete_directories)'";
  return kind == "file" ? " -r -F" : " -x";
}

std::string FishOption(const DeclaredOption& option, const std::string& condition) {
  std::string line = "complete -c pathfit -n " + Quoted(condition, kFishQuote);
  for (const std::string& name : option.names) {
    line += name.starts_with("--") ? " -l " + name.substr(2) : " -s " + name.substr(1);
  }
  if (!option.type.empty()) line += FishValue(option.type);
  return line + " -d " + Quoted(option.doc, kFishQuote) + "\n";
}

}  // namespace

std::vector<std::string> SettableKeys() {
  std::vector<std::string> keys;
  AddKeys(ConfigSchema(), "", keys);
  return keys;
}

std::string BashCompletion(const DeclaredProgram& program) {
  return "# Completion of pathfit for bash: source <(pathfit completion bash)\n" + Tables(program) +
         kScan + kBashMain;
}

std::string ZshCompletion(const DeclaredProgram& program) {
  return "#compdef pathfit\n# Completion of pathfit for zsh: source <(pathfit completion zsh)\n" +
         Tables(program) + kScan + kZshMain;
}

std::string FishCompletion(const DeclaredProgram& program) {
  std::string text =
      "# Completion of pathfit for fish: pathfit completion fish | source\n"
      "complete -c pathfit -f\n";
  text += "function __pathfit_keys\n  printf '%s\\n'";
  for (const std::string& key : SettableKeys()) text += " " + key + "=";
  text += "\nend\n";
  for (const DeclaredOption& option : program.options) {
    text += FishOption(option, "__fish_use_subcommand");
  }
  for (const DeclaredCommand& command : program.commands) {
    text += fmt::format("complete -c pathfit -n __fish_use_subcommand -a {} -d {}\n",
                        command.name,
                        Quoted(command.doc, kFishQuote));
    const std::string seen = "__fish_seen_subcommand_from " + command.name;
    std::string words;
    bool files = false;
    for (const std::string& kind : TargetKinds(command, program)) {
      if (kind.starts_with("word ")) words += (words.empty() ? "" : " ") + kind.substr(5);
      files = files || kind.starts_with("file") || kind.starts_with("folder");
    }
    if (!words.empty() || files) {
      text += fmt::format("complete -c pathfit -n '{}'{}{}\n",
                          seen,
                          files ? " -F" : "",
                          words.empty() ? "" : " -a " + Quoted(words, kFishQuote));
    }
    for (const DeclaredOption& option : command.options) text += FishOption(option, seen);
  }
  return text;
}

}  // namespace pathfit::app
