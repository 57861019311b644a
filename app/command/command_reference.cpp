#include "app/command/command_reference.h"

#include <algorithm>
#include <set>

#include <fmt/format.h>

namespace pathfit::app {
namespace {

/// Text of a man page: '-' as it is typed, no word of the text a request.
std::string Roff(const std::string& text) {
  std::string out;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (c == '\\') {
      out += "\\e";
    } else if (c == '-') {
      out += "\\-";
    } else if ((c == '.' || c == '\'') && (i == 0 || text[i - 1] == '\n')) {
      out += std::string("\\&") + c;
    } else {
      out += c;
    }
  }
  return out;
}

std::string Targets(const DeclaredCommand& command) {
  std::string text;
  for (const std::string& target : command.targets) text += " " + target;
  return text;
}

std::string Names(const DeclaredOption& option) {
  std::string text;
  for (const std::string& name : option.names) text += (text.empty() ? "" : ", ") + name;
  return option.type.empty() ? text : text + " " + option.type;
}

bool Has(const DeclaredCommand& command, const DeclaredOption& option) {
  return std::ranges::any_of(command.options, [&](const DeclaredOption& other) {
    return other.names.back() == option.names.back();
  });
}

/// Those of every command.
std::vector<DeclaredOption> CommonOptions(const DeclaredProgram& program) {
  std::vector<DeclaredOption> chosen;
  for (const DeclaredOption& option : program.options) {
    if (std::ranges::all_of(program.commands,
                            [&](const auto& c) { return c.name == "help" || Has(c, option); })) {
      chosen.push_back(option);
    }
  }
  return chosen;
}

/// Those of no command.
std::vector<DeclaredOption> LoneOptions(const DeclaredProgram& program) {
  std::vector<DeclaredOption> chosen;
  for (const DeclaredOption& option : program.options) {
    if (std::ranges::none_of(program.commands, [&](const auto& c) { return Has(c, option); })) {
      chosen.push_back(option);
    }
  }
  return chosen;
}

/// Those of a command that are not of every command.
std::vector<DeclaredOption> OwnOptions(const DeclaredCommand& command,
                                       const DeclaredProgram& program) {
  std::set<std::string> common;
  for (const DeclaredOption& option : CommonOptions(program)) common.insert(option.names.back());
  std::vector<DeclaredOption> own;
  for (const DeclaredOption& option : command.options) {
    if (common.count(option.names.back()) == 0) own.push_back(option);
  }
  return own;
}

std::string ManOptions(const std::vector<DeclaredOption>& options) {
  std::string text;
  for (const DeclaredOption& option : options) {
    text += fmt::format(".TP\n.B {}\n{}.\n", Roff(Names(option)), Roff(option.doc));
  }
  return text;
}

std::string MarkdownOptions(const std::vector<DeclaredOption>& options) {
  std::string text = "| option | what |\n|---|---|\n";
  for (const DeclaredOption& option : options) {
    std::string names = Names(option);
    for (std::size_t at = names.find('|'); at != std::string::npos; at = names.find('|', at + 2)) {
      names.insert(at, "\\");
    }
    text += fmt::format("| `{}` | {} |\n", names, option.doc);
  }
  return text;
}

}  // namespace

std::string ManPage(const DeclaredProgram& program, const std::string& version) {
  std::string text = fmt::format(
      ".TH PATHFIT 1 \"\" \"pathfit {}\" \"User Commands\"\n"
      ".SH NAME\npathfit \\- fits a scene to photographs\n"
      ".SH SYNOPSIS\n.B pathfit\n.I COMMAND\n[\\fIARGUMENTS\\fR] [\\fIOPTIONS\\fR]\n"
      ".SH DESCRIPTION\n{}\n.PP\n{}\n.SH COMMANDS\n",
      version,
      Roff(program.doc),
      Roff(program.footer));
  for (const DeclaredCommand& command : program.commands) {
    text += fmt::format(
        ".SS pathfit {}{}\n{}.\n", command.name, Roff(Targets(command)), Roff(command.doc));
    text += ManOptions(OwnOptions(command, program));
  }
  text += ".SH OPTIONS OF EVERY COMMAND\n" + ManOptions(CommonOptions(program));
  text += ".SH OPTIONS WITHOUT A COMMAND\n" + ManOptions(LoneOptions(program));
  return text +
         ".SH ENVIRONMENT\n"
         ".TP\n.B PATHFIT_THREADS\nNumber of threads where the config says auto.\n"
         ".TP\n.B PATHFIT_LOG_LEVEL\nLike \\-\\-log\\-level, which has the last word.\n"
         ".TP\n.B NO_COLOR\nIf it is set, messages have no colours.\n"
         ".SH EXAMPLES\n.nf\npathfit init photos\npathfit check photos.yaml\n"
         "pathfit fit photos.yaml\npathfit export runs/photos \\-\\-to glb,blender\n.fi\n";
}

std::string CommandMarkdown(const DeclaredProgram& program) {
  std::string text =
      "# Command reference\n\n"
      "Written from the declarations in this folder; a test compares. `pathfit help COMMAND` and "
      "`man pathfit` say the\nsame. Options may stand anywhere. With `--json` a command prints one "
      "object on standard output: `schema`, which\nis `pathfit-COMMAND-1`, and the keys listed "
      "here; numbers that are not known are null.\n\n"
      "## Every command\n\n" +
      MarkdownOptions(CommonOptions(program)) + "\n## Without a command\n\n" +
      MarkdownOptions(LoneOptions(program));
  for (const DeclaredCommand& command : program.commands) {
    text += fmt::format("\n## pathfit {}{}\n\n{}.\n", command.name, Targets(command), command.doc);
    const std::vector<DeclaredOption> own = OwnOptions(command, program);
    if (!own.empty()) text += "\n" + MarkdownOptions(own);
    if (command.result.empty()) continue;
    text += "\n| key of `--json` | type | what |\n|---|---|---|\n";
    for (const ResultKey& key : command.result) {
      text += fmt::format("| `{}` | {} | {} |\n", key.key, key.type, key.doc);
    }
  }
  return text;
}

}  // namespace pathfit::app
