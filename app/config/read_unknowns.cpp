#include <algorithm>
#include <limits>
#include <optional>

#include <fmt/format.h>

#include "app/config/apply_schema.h"
#include "app/config/map_reader.h"
#include "app/config/nearest_name.h"
#include "app/config/read_config.h"
#include "app/config/unknown_names.h"

namespace pathfit::app {
namespace {

// Values that the kind can have at all, checked against the bounds.
void CheckBounds(const YamlNode& bounds,
                 const UnknownKind& kind,
                 const std::string& path,
                 ConfigReading& reading) {
  const double lower = NumberOf(bounds.items[0]);
  const double upper = NumberOf(bounds.items[1]);
  if (lower > upper) {
    reading.Report(
        bounds.place, path, fmt::format("lower bound {} is above upper bound {}", lower, upper));
    return;
  }
  if (lower == upper) {
    reading.Report(bounds.place,
                   path,
                   fmt::format("both bounds are {}; to keep a value, write hold: true", lower));
    return;
  }
  for (const YamlNode& item : bounds.items) {
    const double value = NumberOf(item);
    if (value < kind.smallest || value > kind.largest) {
      const std::string allowed = kind.largest == std::numeric_limits<double>::infinity()
                                      ? fmt::format("at least {}", kind.smallest)
                                      : fmt::format("from {} to {}", kind.smallest, kind.largest);
      reading.Report(
          item.place, path, fmt::format("{} is out of range (allowed: {})", item.text, allowed));
    }
  }
}

void ReadBounds(YamlNode& node,
                const UnknownKind& kind,
                const std::string& path,
                ConfigReading& reading,
                UnknownConfig& unknown) {
  const YamlNode* bounds = node.Find("bounds");
  const bool limited = !kind.default_bounds.empty();
  if (bounds != nullptr && !limited) {
    reading.Report(bounds->place,
                   path + ".bounds",
                   "bounds of " + kind.property + " are not supported" + kind.bounds_advice);
    return;
  }
  if (!limited) return;
  if (bounds == nullptr) {
    node.entries.push_back({"bounds", Place{}, DefaultValue(kind.default_bounds)});
    bounds = &node.entries.back().value;
  }
  CheckBounds(*bounds, kind, path + ".bounds", reading);
  unknown.lower = NumberOf(bounds->items[0]);
  unknown.upper = NumberOf(bounds->items[1]);
}

void ReadTransform(YamlNode& node,
                   const UnknownKind& kind,
                   const std::string& path,
                   ConfigReading& reading,
                   UnknownConfig& unknown) {
  const YamlNode* transform = node.Find("transform");
  if (transform == nullptr) {
    if (kind.default_bounds.empty()) return;
    unknown.log_transform = kind.default_log;
    const char* word = kind.default_log ? "log" : "identity";
    node.entries.push_back({"transform", Place{}, DefaultValue(word)});
    return;
  }
  unknown.log_transform = transform->text == "log";
  if (unknown.log_transform && (kind.default_bounds.empty() || kind.smallest < 0.0)) {
    reading.Report(transform->place, path + ".transform", "log does not fit " + kind.property);
  }
}

void ReadParametrisation(const MapReader& map,
                         const UnknownKind& kind,
                         const std::string& path,
                         ConfigReading& reading,
                         UnknownConfig& unknown) {
  const YamlNode* node = map.Find("parametrisation");
  if (node == nullptr) return;
  map.Map("parametrisation").Map("large_steps").Get("lambda", unknown.large_steps_lambda);
  if (kind.property != "vertices") {
    reading.Report(
        node->place, path + ".parametrisation", "only vertices have one, not " + kind.property);
  }
}

void ReadPrior(const YamlEntry& entry,
               const UnknownKind& kind,
               const std::string& path,
               ConfigReading& reading,
               UnknownConfig& unknown) {
  const MapReader prior(&entry.value);
  const auto& fitting = kind.priors;
  if (std::find(fitting.begin(), fitting.end(), entry.key) == fitting.end()) {
    const std::string allowed = fitting.empty() ? "none" : JoinNames(fitting);
    reading.Report(
        entry.key_place,
        path,
        "prior '" + entry.key + "' does not fit " + kind.property + " (allowed: " + allowed + ")");
    return;
  }
  if (entry.key == "laplacian") {
    prior.Get("weight", unknown.laplacian_weight);
  } else if (entry.key == "smooth") {
    prior.Get("weight", unknown.smooth_weight);
  } else if (entry.key == "neutral") {
    prior.Get("weight", unknown.neutral_weight);
  } else {
    GaussianConfig& gaussian = unknown.gaussian.emplace();
    prior.Get("sigma", gaussian.sigma);
    const YamlNode* mean = prior.Find("mean");
    if (mean == nullptr || (mean->IsScalar() && mean->text == "start")) return;
    gaussian.mean = NumbersOf(*mean);
    const auto count = gaussian.mean.size();
    if (count > 1 && kind.num_components == 1) {
      reading.Report(mean->place, path + ".gaussian.mean", kind.property + " is one number");
    } else if (count > 1 && count != static_cast<std::size_t>(kind.num_components)) {
      reading.Report(
          mean->place,
          path + ".gaussian.mean",
          fmt::format("{} has {} numbers, not {}", kind.property, kind.num_components, count));
    }
  }
}

void ReadPriors(const MapReader& map,
                const UnknownKind& kind,
                const std::string& path,
                ConfigReading& reading,
                UnknownConfig& unknown) {
  const YamlNode* priors = map.Find("priors");
  if (priors == nullptr) return;
  std::vector<std::string> given;
  for (std::size_t i = 0; i < priors->items.size(); ++i) {
    const std::string item_path = fmt::format("{}.priors[{}]", path, i);
    for (const YamlEntry& entry : priors->items[i].entries) {
      if (std::find(given.begin(), given.end(), entry.key) != given.end()) {
        reading.Report(entry.key_place, item_path, "prior '" + entry.key + "' is given twice");
        continue;
      }
      given.push_back(entry.key);
      ReadPrior(entry, kind, item_path, reading, unknown);
    }
  }
}

}  // namespace

void ReadUnknowns(ConfigReading& reading) {
  YamlNode* unknowns = reading.root.Find("unknowns");
  if (unknowns == nullptr) return;
  for (YamlEntry& entry : unknowns->entries) {
    UnknownConfig unknown;
    unknown.name = entry.key;
    const std::size_t dot = entry.key.rfind('.');  // names of photos have dots
    unknown.object = dot == std::string::npos ? "" : entry.key.substr(0, dot);
    unknown.property = dot == std::string::npos ? entry.key : entry.key.substr(dot + 1);
    const auto [kind, problem] = FindUnknown(entry.key, reading);
    if (!problem.empty()) reading.Report(entry.key_place, "unknowns", problem);
    if (kind != nullptr && entry.value.IsMap()) {
      const std::string path = "unknowns." + entry.key;
      const MapReader map(&entry.value);
      map.Get("hold", unknown.hold);
      ReadParametrisation(map, *kind, path, reading, unknown);
      ReadPriors(map, *kind, path, reading, unknown);
      ReadBounds(entry.value, *kind, path, reading, unknown);
      ReadTransform(entry.value, *kind, path, reading, unknown);
    }
    reading.config.unknowns.push_back(std::move(unknown));
  }
}

}  // namespace pathfit::app
