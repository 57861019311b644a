#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <typeinfo>
#include <utility>
#include <vector>

#include "app/config/config_error.h"
#include "app/config/yaml_node.h"

namespace pathfit::app {

struct ExperimentConfig;

/// A key or value that people know from other programs or from our plans and that does not exist
/// here. It is refused with " is not supported" and the advice.
struct Unsupported {
  std::string name;
  std::string advice;  ///< "; write max_rounds"; may be empty
};

/// Allowed numbers; both ends belong to it unless open.
struct NumberRange {
  double lower;
  double upper;
  bool lower_open = false;
  bool upper_open = false;
  bool allow_infinite = false;  ///< `.inf` may be written
};

/// The map of a check, at its path. Defaults that it adds are part of the resolved copy.
struct CheckedMap {
  YamlNode& node;
  const std::string& path;
  std::vector<Problem>& problems;

  [[nodiscard]] YamlNode* Find(const std::string& key) const { return node.Find(key); }
  /// What is wrong with a key; the place is its own, or that of another value that says so.
  void Report(const std::string& key, std::string text) const {
    Report(key, *node.Find(key), std::move(text));
  }
  void Report(const std::string& key, const YamlNode& at, std::string text) const {
    problems.push_back({at.place, path + "." + key, std::move(text)});
  }
};

/// One value of the configuration: what it may be, what it is without the file, what it means, and
/// the member of the program's structs that holds it. Checks, --set, the resolved copy, the
/// reference page and the values themselves all follow this tree.
struct SchemaNode {
  enum class Type {
    kBool,
    kInteger,
    kNumber,
    kText,
    kName,    ///< letters, digits, _ and -
    kChoice,  ///< one of `words`
    kPath,
    kBytes,     ///< "16 GiB"
    kList,      ///< children[0] is the item
    kMap,       ///< children are the keys
    kNamedMap,  ///< names given by the user; children[0] is the value of each
    kEither,    ///< children are alternatives, told apart by scalar, list or map
  };
  enum class Presence {
    kDefaulted,  ///< absent = default_yaml; maps: absent = empty, so that their keys take defaults
    kOptional,   ///< absent = not used, or depends on other values
    kRequired,
  };

  Type type = Type::kMap;
  std::string key;  ///< of a child of a map; kNamedMap items: what a name stands for, "MATERIAL"
  std::string doc;
  Presence presence = Presence::kOptional;
  std::vector<std::string> required_values;  ///< kRequired only for these values of `when_key`
  std::string default_yaml;                  ///< also of what is required for other values only
  std::string default_doc;  ///< for the reference where the default depends on other values
  std::string unit;
  NumberRange range{0.0, 0.0, false, false, false};
  bool has_range = false;
  std::vector<std::string> words;  ///< kChoice; also accepted instead of a number, path or bytes
  std::vector<Unsupported> unsupported;  ///< keys of a map, or values of a choice
  std::vector<SchemaNode> children;
  int min_items = 0;
  int max_items = 0;   ///< 0 = any number
  std::string one_of;  ///< exactly one sibling with the same text here must be given
  std::vector<std::string> one_of_values;  ///< or at most one, but for these values of `when_key`
  std::string needs;                       ///< a sibling that must be given too
  std::string when_key;  ///< belongs only to maps whose `when_key` has one of when_values
  std::vector<std::string> when_values;
  /// Path of another value from the root ("render.form"), with some of which this one has no use.
  /// It is accepted all the same, since that value may be changed for one run (--set, sweep).
  std::string useless_key;
  std::vector<std::string> useless_values;
  bool free_names = false;  ///< kNamedMap: names from other programs, of any characters
  bool distinct = false;    ///< kList: no item may be there twice

  // Where the value goes; set by the builders. Pointers are to the struct of the enclosing map.
  const std::type_info* owner = nullptr;  ///< that struct; null: any (the values below say it)
  std::function<void(const YamlNode&, void*)> store;  ///< scalars and lists of scalars
  /// Maps: the struct of their own keys; absent: that of the enclosing map. Named maps, lists of
  /// maps: appends one, called `name`.
  std::function<void*(void*, const std::string& name)> target;
  const std::type_info* target_type = nullptr;
  /// Maps: what depends on several values, once they are stored: derived members, defaults that
  /// depend on other values (written into the node, too), problems.
  std::function<void(void*, const CheckedMap&)> check;
  const std::type_info* check_type = nullptr;

  [[nodiscard]] const SchemaNode* Child(const std::string& name) const;
  /// The advice of what is refused by this name; null if nothing is.
  [[nodiscard]] const std::string* AdviceFor(const std::string& name) const;
};

/// Puts `path.to.key=VALUE` (and `path.to.list+=VALUE`, which appends) into the tree, in order, as
/// if the file had said so. Items of lists are named by index, `stages[2]`, or by their name,
/// `stages.light`. What cannot be placed is reported and left out; values are not checked here.
void ApplyOverrides(const SchemaNode& schema,
                    const std::vector<ConfigOverride>& overrides,
                    YamlNode& root,
                    std::vector<Problem>& problems);

/// Checks `root` and brings it into the form that readers take for granted: everything wrong is
/// reported and removed (a named item or list item that is wrong stays as null, so that its name is
/// still known), defaults are filled in with places of kind kDefault, paths are absolute.
void ApplySchema(const SchemaNode& schema,
                 const std::filesystem::path& folder,
                 YamlNode& root,
                 std::vector<Problem>& problems);

/// Stores the values of a tree that ApplySchema accepted in `values`, the struct of the schema's
/// outermost map, and runs the checks. What is absent or null leaves its member as it is.
void BindValues(const SchemaNode& schema,
                YamlNode& node,
                const std::string& path,
                void* values,
                std::vector<Problem>& problems);

/// Throws std::logic_error if a line's member does not belong to the struct of its map.
void CheckBindings(const SchemaNode& schema, const std::type_info& values);

/// Throws std::logic_error where a line speaks of a key that its map does not have (`needs`,
/// `when_key`), of a value that this key cannot have, or of a path or value that is not in the
/// config (`useless_key`). Whoever reads a schema takes all of them for granted.
void CheckReferences(const SchemaNode& root);

/// Whether the kind of the value is that of an alternative: scalar, list or map.
bool FitsForm(const SchemaNode& form, const YamlNode& node);

/// A default of the schema as a value.
YamlNode DefaultValue(const std::string& yaml);

/// "a.b", "b" if `path` is empty.
std::string JoinPath(const std::string& path, const std::string& key);

/// Adds a default that depends on other values.
void SetDefault(YamlNode& map, const std::string& key, const std::string& yaml);

/// Schema of the whole file.
const SchemaNode& ConfigSchema();

/// What is written, is not the default, and has no use with another value: a sentence with the
/// place for each.
std::vector<std::string> UselessValues(const ExperimentConfig& config);

/// "from 0 to 1", "above 0", "at least 1"; empty without a range.
std::string DescribeRange(const SchemaNode& node);

/// "a number from 0 to 1", "a list of 3 numbers", "one of a, b": what may be written.
std::string DescribeType(const SchemaNode& node);

/// Every key of a config with its meaning and default, as YAML: defaults stand as they are, what
/// has none, or is optional, behind '#'. With a scene it is a config of nothing but defaults.
std::string SchemaYaml();

}  // namespace pathfit::app
