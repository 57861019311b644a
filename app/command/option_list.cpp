#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <memory>
#include <system_error>
#include <utility>

#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>
#include <fmt/format.h>

#include "app/command/command_line.h"
#include "app/config/nearest_name.h"
#include "app/config/scalar.h"

namespace pathfit::app {
namespace {

template <class T>
std::optional<T> NumberIn(const std::string& text) {
  T value{};
  const char* last = text.data() + text.size();
  const auto [end, error] = std::from_chars(text.data(), last, value);
  return error == std::errc() && end == last ? std::optional(value) : std::nullopt;
}

bool IsPositive(const std::string& text) {
  const double value = NumberIn<double>(text).value_or(0.0);
  return std::isfinite(value) && value > 0.0;
}

std::string SizeProblem(const std::string& text) {
  YamlNode node;
  node.kind = YamlNode::Kind::kScalar;
  node.text = text;
  return ParseBytes(node).problem;
}

// As a single-quoted YAML scalar.
std::string Quoted(const std::string& text) {
  std::string out = "'";
  for (const char c : text) out += c == '\'' ? std::string("''") : std::string(1, c);
  return out + "'";
}

// "--output" of "-o,--output".
std::string LongName(const std::string& names) { return names.substr(names.find("--")); }

std::vector<std::string> Split(const OptionList& list, const char* names, const std::string& text) {
  std::vector<std::string> parts;
  for (std::size_t at = 0; at <= text.size();) {
    const std::size_t end = std::min(text.find(',', at), text.size());
    if (end == at) list.Fail(LongName(names) + ": '" + text + "' has an empty part");
    parts.push_back(text.substr(at, end - at));
    at = end + 1;
  }
  return parts;
}

}  // namespace

OptionList::OptionList(CLI::App& app, CommandLine& line) : app_(app), line_(line) {}

void OptionList::Add(const char* names,
                     const std::string& type,
                     const char* doc,
                     std::function<void(const std::string&)> store) {
  auto text = std::make_shared<std::string>();
  const CLI::Option* option = app_.add_option(names, *text, doc)->type_name(type)->take_last();
  actions_.emplace_back([text, option, store = std::move(store)] {
    if (option->count() > 0) store(*text);
  });
}

void OptionList::Flag(const char* names, const char* doc, bool& value) {
  app_.add_flag(names, value, doc);
}
void OptionList::Text(const char* names,
                      const std::string& type,
                      const char* doc,
                      std::string& value) {
  Add(names, type, doc, [&value](const std::string& text) { value = text; });
}
void OptionList::Path(const char* names,
                      const std::string& type,
                      const char* doc,
                      std::filesystem::path& value) {
  Add(names, type, doc, [this, names, &value](const std::string& text) {
    // As it was written, for messages.
    value = text.starts_with('~') ? PathOf(LongName(names), text) : std::filesystem::path(text);
  });
}
void OptionList::Texts(const char* names,
                       const std::string& type,
                       const char* doc,
                       std::vector<std::string>& value) {
  // Without allow_extra_args the parser would also take the words that follow.
  app_.add_option(names, value, doc)->type_name(type)->take_all()->allow_extra_args(false);
}
void OptionList::List(const char* names,
                      const std::string& type,
                      const char* doc,
                      std::vector<std::string>& value) {
  Add(names, type, doc, [this, names, type, &value](const std::string& text) {
    value = Split(*this, names, text);
    const std::vector<std::string> words = WordsOfType(type);
    for (const std::string& part : value) {
      if (!words.empty()) RequireWord(LongName(names), words, part);
    }
  });
}
void OptionList::Word(const char* names,
                      const std::string& words,
                      const char* doc,
                      std::string& value) {
  Add(names, words, doc, [this, names, words, &value](const std::string& text) {
    RequireWord(LongName(names), WordsOfType(words), text);
    value = text;
  });
}
std::filesystem::path OptionList::PathOf(const std::string& name, const std::string& text) const {
  std::error_code error;
  const std::filesystem::path folder = std::filesystem::current_path(error);
  if (error) Fail(name + ": '" + text + "' is not a path: " + error.message());
  const Parsed<std::filesystem::path> path = ResolvePath(text, folder);
  if (!path.value) Fail(name + ": '" + text + "' is not a path: " + path.problem);
  return *path.value;
}
void OptionList::RequireWord(const std::string& name,
                             const std::vector<std::string>& words,
                             const std::string& text) const {
  if (Contains(words, text)) return;
  const std::string nearest = NearestName(text, words);
  Fail(name + ": '" + text + "' is not one of: " + JoinNames(words) +
       (nearest.empty() ? "" : " (did you mean '" + nearest + "'?)"));
}
void OptionList::Number(
    const char* names, const char* doc, double low, double high, double& value) {
  Add(names, "NUMBER", doc, [this, names, low, high, &value](const std::string& text) {
    const std::optional<double> number = NumberIn<double>(text);
    if (!number || !(*number >= low) || !(*number <= high)) {
      Fail(fmt::format("{}: '{}' is not a number from {} to {}", LongName(names), text, low, high));
    }
    value = *number;
  });
}
void OptionList::Whole(const char* names, const char* doc, int low, int high, int& value) {
  Add(names, "N", doc, [this, names, low, high, &value](const std::string& text) {
    const std::optional<int> number = NumberIn<int>(text);
    if (!number || *number < low || *number > high) {
      Fail(fmt::format(
          "{}: '{}' is not a whole number from {} to {}", LongName(names), text, low, high));
    }
    value = *number;
  });
}
void OptionList::Duration(const char* names, const char* doc, double& value) {
  Add(names, "TIME", doc, [this, names, &value](const std::string& text) {
    const std::optional<double> seconds = ParseDuration(text);
    if (!seconds) {
      Fail(LongName(names) + ": '" + text + "' is not a time like 2h, 90m, 1h30m or 45s");
    }
    value = *seconds;
  });
}

void OptionList::Override(const char* names,
                          const std::string& type,
                          const char* doc,
                          const char* key,
                          Form form,
                          std::int64_t least) {
  const std::string flag = std::string(names).substr(0, std::string(names).find(','));
  const auto set = [this, flag, key](const std::string& value) {
    line_.overrides.push_back({flag, std::string(key) + "=" + value});
  };
  if (form == Form::kTexts) {
    auto values = std::make_shared<std::vector<std::string>>();
    Texts(names, type, doc, *values);
    actions_.emplace_back([values, set] {
      std::string list;
      for (const std::string& v : *values) list += (list.empty() ? "" : ", ") + Quoted(v);
      if (!values->empty()) set("[" + list + "]");
    });
    return;
  }
  Add(names, type, doc, [this, names, type, set, form, least](const std::string& text) {
    const std::string start = LongName(names) + ": '" + text + "' is not ";
    switch (form) {
      case Form::kWhole:
        if (NumberIn<std::int64_t>(text) < least)
          Fail(start + "a whole number of at least " + std::to_string(least));
        return set(text);
      case Form::kPositive:
        if (!IsPositive(text)) Fail(start + "a number above 0");
        return set(text);
      case Form::kBytes:
        if (const std::string problem = SizeProblem(text); !problem.empty()) {
          Fail(LongName(names) + ": " + problem);
        }
        return set(text);
      case Form::kPath:
        return set(Quoted(PathOf(LongName(names), text).string()));
      case Form::kWords: {
        std::string list;
        for (const std::string& word : Split(*this, names, text)) {
          list += (list.empty() ? "" : ",") + word;
        }
        return set("[" + list + "]");
      }
      case Form::kWord:
        RequireWord(LongName(names), WordsOfType(type), text);
        return set(Quoted(text));
      default:
        return set(Quoted(text));
    }
  });
}

void OptionList::Set() {
  auto sets = std::make_shared<std::vector<std::string>>();
  Texts("--set",
        "KEY=VALUE",
        "Replaces a value of the config, or adds an entry; may be repeated",
        *sets);
  actions_.emplace_back([this, sets] {
    // Before the flags, which have the last word.
    std::vector<ConfigOverride> all;
    for (const std::string& set : *sets) {
      const std::string label = "--set #" + std::to_string(all.size() + 1);
      const std::size_t equals = set.find('=');
      if (equals == std::string::npos || equals == 0)
        Fail(label + ": '" + set + "' is not KEY=VALUE");
      all.push_back({label, set});
    }
    line_.overrides.insert(line_.overrides.begin(), all.begin(), all.end());
  });
}
void OptionList::Seed() {
  Override("--seed", "N", "Replaces the config's seed", "seed", Form::kWhole);
}
void OptionList::Threads() {
  Override("--threads", "N", "Bounds every kind of thread", "solver.threads", Form::kWhole, 1);
}
void OptionList::MaxMemory() {
  Override("--max-memory",
           "SIZE",
           "Refuses to start above it, e.g. 12GiB; else above what the machine gives",
           "solver.max_memory",
           Form::kBytes);
}

bool OptionList::Given(const char* name) const { return app_.get_option(name)->count() > 0; }

void OptionList::Fail(const std::string& text) const {
  throw UsageError(app_.get_parent() == nullptr ? "" : app_.get_name(), text);
}

void OptionList::Finish() {
  for (const auto& action : actions_) action();
}

}  // namespace pathfit::app
