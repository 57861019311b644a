#pragma once

#include <array>
#include <filesystem>
#include <string>
#include <vector>

#include "app/config/yaml_node.h"

namespace pathfit::app {

/// Typed access to a map that ApplySchema accepted. Keys that are absent (not given, or reported as
/// wrong and removed) leave the target as it is; so does a reader without a map.
class MapReader {
 public:
  explicit MapReader(const YamlNode* node) : node_(node) {}

  [[nodiscard]] bool Has(const std::string& key) const { return Find(key) != nullptr; }
  [[nodiscard]] const YamlNode* Find(const std::string& key) const;
  [[nodiscard]] MapReader Map(const std::string& key) const { return MapReader(Find(key)); }
  /// Text of a scalar, "" if absent.
  [[nodiscard]] std::string TextOf(const std::string& key) const;

  void Get(const std::string& key, bool& out) const;
  void Get(const std::string& key, int& out) const;
  void Get(const std::string& key, double& out) const;
  void Get(const std::string& key, std::string& out) const;
  void Get(const std::string& key, std::filesystem::path& out) const;
  void Get(const std::string& key, std::array<double, 3>& out) const;
  void Get(const std::string& key, std::array<double, 2>& out) const;
  void Get(const std::string& key, std::array<int, 2>& out) const;

 private:
  const YamlNode* node_;
};

/// Value of a number that was accepted.
double NumberOf(const YamlNode& node);
int IntegerOf(const YamlNode& node);
/// Values of a list of numbers; of a single number, that one.
std::vector<double> NumbersOf(const YamlNode& node);

}  // namespace pathfit::app
