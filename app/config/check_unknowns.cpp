#include <algorithm>

#include <fmt/format.h>

#include "app/config/nearest_name.h"
#include "app/config/read_config.h"

namespace pathfit::app {
namespace {

// Indices of the unknowns that a stage frees.
std::vector<int> FreeOf(const YamlNode& node, const std::string& path, ConfigReading& reading) {
  const std::vector<UnknownConfig>& unknowns = reading.config.unknowns;
  std::vector<std::string> known;
  std::vector<int> free;
  for (const UnknownConfig& unknown : unknowns) {
    if (!node.IsList() && !unknown.spec.hold) free.push_back(static_cast<int>(known.size()));
    known.push_back(unknown.name);
  }
  if (!node.IsList() && free.empty()) {
    reading.Report(node.place,
                   path,
                   known.empty() ? "there are no unknowns to free" : "every unknown is held");
  }
  for (const YamlNode& item : node.items) {
    const auto index =
        static_cast<int>(std::find(known.begin(), known.end(), item.text) - known.begin());
    if (index == static_cast<int>(known.size())) {
      reading.Report(item.place,
                     path,
                     "no unknown is called '" + item.text + "'" + NameHint(item.text, known));
    } else if (unknowns[static_cast<std::size_t>(index)].spec.hold) {
      reading.Report(item.place, path, "'" + item.text + "' is held (hold: true)");
    } else if (std::find(free.begin(), free.end(), index) != free.end()) {
      reading.Report(item.place, path, "'" + item.text + "' is given twice");
    } else {
      free.push_back(index);
    }
  }
  return free;
}

}  // namespace

void CheckStages(ConfigReading& reading) {
  const YamlNode* stages = reading.root.Find("stages");
  if (stages == nullptr) return;
  std::vector<std::string> names;
  for (std::size_t i = 0; i < stages->items.size(); ++i) {
    const YamlNode& node = stages->items[i];
    const std::string path = fmt::format("stages[{}]", i);
    if (const YamlNode* free = node.Find("free")) {
      reading.config.fit.stages[i].free = FreeOf(*free, path + ".free", reading);
    }
    const YamlNode* name = node.Find("name");
    if (name == nullptr) continue;
    if (std::find(names.begin(), names.end(), name->text) != names.end()) {
      reading.Report(
          name->place, path + ".name", "another stage is called '" + name->text + "' already");
    }
    names.push_back(name->text);
  }
  if (!stages->items.empty() && !reading.has_input) {
    reading.Report(stages->place, "stages", "a fit needs photos; give input");
  }
}

}  // namespace pathfit::app
