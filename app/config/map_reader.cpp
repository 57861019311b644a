#include "app/config/map_reader.h"

#include "app/config/scalar.h"

namespace pathfit::app {
namespace {

template <std::size_t N>
void GetNumbers(const YamlNode* node, std::array<double, N>& out) {
  if (node == nullptr || node->items.size() != N) return;
  for (std::size_t i = 0; i < N; ++i) out.at(i) = NumberOf(node->items[i]);
}

}  // namespace

const YamlNode* MapReader::Find(const std::string& key) const {
  return node_ == nullptr ? nullptr : node_->Find(key);
}

std::string MapReader::TextOf(const std::string& key) const {
  const YamlNode* node = Find(key);
  return node == nullptr ? std::string() : node->text;
}

void MapReader::Get(const std::string& key, bool& out) const {
  if (const YamlNode* node = Find(key)) out = ParseBool(*node).value.value_or(out);
}
void MapReader::Get(const std::string& key, int& out) const {
  // Words such as `auto` stay what the caller has set.
  const YamlNode* node = Find(key);
  if (node != nullptr && ParseInteger(*node).value) out = IntegerOf(*node);
}
void MapReader::Get(const std::string& key, double& out) const {
  if (const YamlNode* node = Find(key)) out = ParseNumber(*node, true).value.value_or(out);
}
void MapReader::Get(const std::string& key, std::string& out) const {
  if (const YamlNode* node = Find(key)) out = node->text;
}
void MapReader::Get(const std::string& key, std::filesystem::path& out) const {
  if (const YamlNode* node = Find(key)) out = node->text;
}
void MapReader::Get(const std::string& key, std::array<double, 3>& out) const {
  GetNumbers(Find(key), out);
}
void MapReader::Get(const std::string& key, std::array<double, 2>& out) const {
  GetNumbers(Find(key), out);
}
void MapReader::Get(const std::string& key, std::array<int, 2>& out) const {
  const YamlNode* node = Find(key);
  if (node == nullptr || node->items.size() != 2) return;
  for (std::size_t i = 0; i < 2; ++i) out.at(i) = IntegerOf(node->items[i]);
}

double NumberOf(const YamlNode& node) { return ParseNumber(node, true).value.value_or(0.0); }

int IntegerOf(const YamlNode& node) {
  return static_cast<int>(ParseInteger(node).value.value_or(0));
}

std::vector<double> NumbersOf(const YamlNode& node) {
  if (!node.IsList()) return {NumberOf(node)};
  std::vector<double> out;
  out.reserve(node.items.size());
  for (const YamlNode& item : node.items) out.push_back(NumberOf(item));
  return out;
}

}  // namespace pathfit::app
