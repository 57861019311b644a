#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <numbers>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "app/config/scalar.h"
#include "app/config/schema.h"

namespace pathfit::app {

// The language in which the schema is written. A line is a key, its meaning, and the member that
// holds its value, given as pointers to members (&Outer::inner, &Inner::value) or as a function
// `Value& (Owner&)`. Type and default are the member's own.

/// What a line says besides its key and its member: `Key(...) | AtLeast(0.0) | Unit("metres")`.
using Trait = std::function<void(SchemaNode&)>;
inline SchemaNode operator|(SchemaNode node, const Trait& trait) {
  trait(node);
  return node;
}
/// Both, in this order.
inline Trait operator|(const Trait& first, const Trait& second) {
  return [first, second](SchemaNode& node) {
    first(node);
    second(node);
  };
}

namespace binding {
template <class T>
Trait Set(T SchemaNode::*member, const std::type_identity_t<T>& value) {
  return [member, value](SchemaNode& node) { node.*member = value; };
}
}  // namespace binding

inline Trait Doc(const std::string& text) { return binding::Set(&SchemaNode::doc, text); }
inline Trait Unit(const std::string& text) { return binding::Set(&SchemaNode::unit, text); }
inline Trait Always() {
  return binding::Set(&SchemaNode::presence, SchemaNode::Presence::kDefaulted);
}
inline Trait Default(const std::string& yaml) {
  return binding::Set(&SchemaNode::default_yaml, yaml) | Always();
}
/// Absent = the member keeps its own value.
inline Trait Optional() {
  return Default("") | binding::Set(&SchemaNode::presence, SchemaNode::Presence::kOptional);
}
inline Trait DefaultIs(const std::string& text) {
  return Optional() | binding::Set(&SchemaNode::default_doc, text);
}
/// Required for these values of the sibling named by When (empty: for all); for others it has
/// `yaml` as default, if that is not empty.
inline Trait RequiredFor(const std::vector<std::string>& values, const std::string& yaml = "") {
  return [values, yaml](SchemaNode& node) {
    node.presence = SchemaNode::Presence::kRequired;
    node.required_values = values;
    node.default_yaml = yaml;
  };
}
inline Trait Required() { return RequiredFor({}); }
Trait From(double lower, double upper);
Trait AtLeast(double lower);
Trait Above(double lower);
Trait Between(double lower, double upper);  ///< ends excluded
Trait OrInfinite();
inline Trait Words(const std::vector<std::string>& list) {
  return binding::Set(&SchemaNode::words, list);
}
/// The word stands for the member's own value.
inline Trait OrWord(const std::string& word) { return Words({word}) | Default(word); }
inline Trait Refuse(const std::vector<Unsupported>& list) {
  return binding::Set(&SchemaNode::unsupported, list);
}
inline Trait Items(int min_count, int max_count) {
  return binding::Set(&SchemaNode::min_items, min_count) |
         binding::Set(&SchemaNode::max_items, max_count);
}
/// Exactly one of the group.
inline Trait OneOf(const std::string& group) {
  return Optional() | binding::Set(&SchemaNode::one_of, group);
}
/// One of the group at most; exactly one for these values of the sibling named by When.
inline Trait OneOfFor(const std::string& group, const std::vector<std::string>& values) {
  return OneOf(group) | binding::Set(&SchemaNode::one_of_values, values);
}
inline Trait Needs(const std::string& sibling) { return binding::Set(&SchemaNode::needs, sibling); }
inline Trait When(const std::string& sibling, const std::vector<std::string>& values) {
  return binding::Set(&SchemaNode::when_key, sibling) |
         binding::Set(&SchemaNode::when_values, values);
}
/// Has no use if the value of this path from the root is one of these.
inline Trait UselessWith(const std::string& path, const std::vector<std::string>& values) {
  return binding::Set(&SchemaNode::useless_key, path) |
         binding::Set(&SchemaNode::useless_values, values);
}
inline Trait FreeNames() { return binding::Set(&SchemaNode::free_names, true); }
inline Trait Distinct() { return binding::Set(&SchemaNode::distinct, true); }
Trait OrOne();  ///< of a list of numbers: one number stands for all
template <class T>
Trait Check(void (*function)(T&, const CheckedMap&)) {
  return [function](SchemaNode& node) {
    node.check_type = &typeid(T);
    node.check = [function](void* values, const CheckedMap& map) {
      function(*static_cast<T*>(values), map);
    };
  };
}

/// How a value is reached from the struct of its map. Optional members on the way are filled.
template <class O, class V>
struct Access {
  using Owner = O;
  using Value = V;
  std::function<V&(O&)> get;
};

namespace binding {

template <class T>
struct IsOptional : std::false_type {};
template <class T>
struct IsOptional<std::optional<T>> : std::true_type {};

template <class T>
auto& Filled(T& value) {
  if constexpr (IsOptional<T>::value) {
    return value ? *value : value.emplace();
  } else {
    return value;
  }
}

template <class T>
using FilledType = std::remove_reference_t<decltype(Filled(std::declval<T&>()))>;

template <class T, class M>
auto& Reach(T& value, M member) {
  return value.*member;
}
template <class T, class M, class... Rest>
auto& Reach(T& value, M member, Rest... rest) {
  return Reach(Filled(value.*member), rest...);
}

template <class F>
struct FunctionOf;
template <class F>
requires std::is_class_v<F>
struct FunctionOf<F> : FunctionOf<decltype(&F::operator())> {
};
template <class F, class V, class O>
struct FunctionOf<V& (F::*)(O&) const> {
  using Type = Access<O, V>;
};
template <class V, class O>
struct FunctionOf<V& (*)(O&)> {
  using Type = Access<O, V>;
};

template <class O, class M, class... Rest>
auto To(M O::*first, Rest... rest) {
  const auto get = [ first, rest... ](O & owner) -> auto& { return Reach(owner, first, rest...); };
  using V = std::remove_reference_t<decltype(get(std::declval<O&>()))>;
  return Access<O, V>{get};
}
template <class F>
typename FunctionOf<F>::Type To(F function) {
  return {function};
}

// Values as text, for defaults, and from accepted nodes. Words that are no value of the type leave
// it as it is.
std::string WriteNumber(double value);
template <class T>
std::string Write(const T& value) {
  if constexpr (std::is_same_v<T, bool>) {
    return value ? "true" : "false";
  } else if constexpr (std::is_same_v<T, double>) {
    return WriteNumber(value);
  } else if constexpr (std::is_integral_v<T>) {
    return std::to_string(value);
  } else if constexpr (std::is_convertible_v<T, std::string>) {
    return value;
  } else {
    std::string out;
    for (const auto& item : value) out += (out.empty() ? "" : ", ") + Write(item);
    return "[" + out + "]";
  }
}

template <class T>
void Read(const YamlNode& node, T& value) {
  if constexpr (std::is_same_v<T, bool>) {
    value = ParseBool(node).value.value_or(value);
  } else if constexpr (std::is_same_v<T, double>) {
    value = ParseNumber(node, true).value.value_or(value);
  } else if constexpr (std::is_integral_v<T>) {
    if (const auto parsed = ParseInteger(node); parsed.value) value = static_cast<T>(*parsed.value);
  } else {
    value = node.text;
  }
}
template <class T, std::size_t N>
void Read(const YamlNode& node, std::array<T, N>& value) {
  for (std::size_t i = 0; i < N; ++i) {
    if (!node.IsList()) {
      Read(node, value[i]);
    } else if (i < node.items.size()) {
      Read(node.items[i], value[i]);
    }
  }
}
/// Of a single number, that one; of a word, none.
template <class T>
void Read(const YamlNode& node, std::vector<T>& value) {
  value.clear();
  if (!node.IsList() && ParseNumber(node, true).value) Read(node, value.emplace_back());
  for (const YamlNode& item : node.items) Read(item, value.emplace_back());
}

SchemaNode Make(SchemaNode::Type type, std::string key);

/// What the file holds for a value of type T.
template <class T>
struct Described {
  static constexpr auto kType = std::is_same_v<T, bool>          ? SchemaNode::Type::kBool
                                : std::is_integral_v<T>          ? SchemaNode::Type::kInteger
                                : std::is_same_v<T, double>      ? SchemaNode::Type::kNumber
                                : std::is_same_v<T, std::string> ? SchemaNode::Type::kText
                                                                 : SchemaNode::Type::kPath;
  static SchemaNode Node() { return Make(kType, ""); }
};
template <class T>
struct Described<std::vector<T>> {
  static SchemaNode Node() {
    SchemaNode node = Make(SchemaNode::Type::kList, "");
    node.children = {Described<T>::Node()};
    return node;
  }
};
template <class T, std::size_t N>
struct Described<std::array<T, N>> {
  static SchemaNode Node() {
    return Described<std::vector<T>>::Node() | Items(static_cast<int>(N), static_cast<int>(N));
  }
};
template <class T>
struct Described<std::optional<T>> : Described<T> {};

/// The value goes by store(node, member).
template <class A, class Store>
void StoreIn(const A& access, SchemaNode& node, Store store) {
  using Owner = typename A::Owner;
  node.owner = &typeid(Owner);
  node.store = [access, store](const YamlNode& from, void* owner) {
    store(from, Filled(access.get(*static_cast<Owner*>(owner))));
  };
}

/// The member's own value.
template <class A>
auto InitialOf(const A& access) {
  typename A::Owner owner{};
  return Filled(access.get(owner));
}

}  // namespace binding

/// A value described by `node` instead of by the type of its member; the default is the member's.
template <class... Members>
SchemaNode Bound(SchemaNode node, Members... members) {
  const auto access = binding::To(members...);
  binding::StoreIn(
      access, node, [](const YamlNode& from, auto& value) { binding::Read(from, value); });
  using Value = typename decltype(access)::Value;
  if constexpr (!binding::IsOptional<Value>::value) {
    Default(binding::Write(binding::InitialOf(access)))(node);
  }
  return node;
}

template <class... Members>
SchemaNode Key(std::string key, Members... members) {
  using Value = typename decltype(binding::To(members...))::Value;
  SchemaNode node = binding::Described<Value>::Node();
  node.key = std::move(key);
  return Bound(std::move(node), members...);
}

/// A value that is written as one of some words.
template <class V>
using WordsOf = std::vector<std::pair<std::string, V>>;

template <class... Members>
SchemaNode Choice(std::string key,
                  WordsOf<typename decltype(binding::To(std::declval<Members>()...))::Value> words,
                  Members... members) {
  // As it is: of an optional member one word may mean no value.
  const auto access = binding::To(members...);
  using Owner = typename decltype(access)::Owner;
  SchemaNode node = binding::Make(SchemaNode::Type::kChoice, std::move(key));
  Owner initial{};
  for (const auto& [word, value] : words) {
    node.words.push_back(word);
    if (access.get(initial) == value) Default(word)(node);
  }
  node.owner = &typeid(Owner);
  node.store = [access, words](const YamlNode& from, void* owner) {
    for (const auto& [word, value] : words) {
      if (from.text == word) access.get(*static_cast<Owner*>(owner)) = value;
    }
  };
  return node;
}

/// A list of the words of what is in a set (Has, Set).
template <class V, class... Members>
SchemaNode WordSet(std::string key, WordsOf<V> words, Members... members) {
  const auto access = binding::To(members...);
  SchemaNode node = binding::Make(SchemaNode::Type::kList, std::move(key));
  SchemaNode item = binding::Make(SchemaNode::Type::kChoice, "");
  std::vector<std::string> initial;
  for (const auto& [word, value] : words) {
    item.words.push_back(word);
    if (binding::InitialOf(access).Has(value)) initial.push_back(word);
  }
  node.children = {item};
  binding::StoreIn(access, node, [words](const YamlNode& from, auto& set) {
    for (const auto& [word, value] : words) {
      set.Set(value, std::ranges::any_of(from.items, [&word](const YamlNode& given) {
                return given.text == word;
              }));
    }
  });
  return std::move(node) | Items(1, static_cast<int>(words.size())) | Distinct() |
         Default(binding::Write(initial));
}

/// Degrees in the file, radians in the member.
template <class... Members>
SchemaNode Degrees(std::string key, Members... members) {
  SchemaNode node = Key(std::move(key), members...) | Unit("degrees");
  binding::StoreIn(binding::To(members...), node, [](const YamlNode& from, double& angle) {
    binding::Read(from, angle);
    angle = angle * std::numbers::pi / 180.0;
  });
  return std::move(node) | Optional();
}

/// "16 GiB" in the file, bytes in the member; infinite for the word none.
template <class... Members>
SchemaNode Bytes(std::string key, Members... members) {
  SchemaNode node = Key(std::move(key), members...);
  node.type = SchemaNode::Type::kBytes;
  binding::StoreIn(binding::To(members...), node, [](const YamlNode& from, double& bytes) {
    bytes = from.text == "none" ? std::numeric_limits<double>::infinity()
                                : ParseBytes(from).value.value_or(bytes);
  });
  return node;
}

/// Letters, digits, _ and -.
template <class... Members>
SchemaNode Name(std::string key, Members... members) {
  SchemaNode node = Key(std::move(key), members...);
  node.type = SchemaNode::Type::kName;
  return std::move(node) | Optional();
}

/// Keys of the same struct as those beside the map.
SchemaNode Map(std::string key, std::vector<SchemaNode> children);

/// Keys of a struct that is a member (or optional, or an alternative: a function that makes it).
template <class... Members>
SchemaNode MapOf(std::string key, std::vector<SchemaNode> children, Members... members) {
  const auto access = binding::To(members...);
  using Owner = typename decltype(access)::Owner;
  SchemaNode node = Map(std::move(key), std::move(children));
  node.owner = &typeid(Owner);
  node.target = [access](void* values, const std::string&) -> void* {
    return &binding::Filled(access.get(*static_cast<Owner*>(values)));
  };
  using Value = typename decltype(access)::Value;
  node.target_type = &typeid(binding::FilledType<Value>);
  return node;
}

namespace binding {

/// `node` is a list or named map of maps, which append to the vector.
template <class A>
SchemaNode Appending(SchemaNode node, const A& access) {
  using Owner = typename A::Owner;
  using Item = typename A::Value::value_type;
  node.owner = &typeid(Owner);
  node.target = [access](void* values, const std::string& name) -> void* {
    Item& item = access.get(*static_cast<Owner*>(values)).emplace_back();
    if (!name.empty()) item.name = name;
    return &item;
  };
  node.target_type = &typeid(Item);
  return node;
}

}  // namespace binding

/// Maps with names given by the user: items of a vector of structs with a `name`.
template <class... Members>
SchemaNode NamedMap(std::string key, std::string name, SchemaNode item, Members... members) {
  SchemaNode node = binding::Make(SchemaNode::Type::kNamedMap, std::move(key));
  item.key = std::move(name);
  node.children.push_back(std::move(item));
  return binding::Appending(std::move(node), binding::To(members...));
}

/// A list of maps: items of a vector of structs.
template <class... Members>
SchemaNode ListOf(std::string key, SchemaNode item, Members... members) {
  SchemaNode node = binding::Make(SchemaNode::Type::kList, std::move(key));
  node.children.push_back(std::move(item));
  return binding::Appending(std::move(node), binding::To(members...));
}

/// Alternatives, told apart by scalar, list or map.
SchemaNode Either(std::string key, std::vector<SchemaNode> forms);
/// An alternative that says something by being there.
SchemaNode Word(std::string word);
/// Values that the check of the enclosing map reads from the node: names to look up, a small
/// language. `node` has no members.
SchemaNode ByCheck(SchemaNode node);
SchemaNode TextNode(std::string key);
/// Maps in it have keys of the same struct as those beside the list.
SchemaNode ListNode(std::string key, SchemaNode item);

/// Number that must be `version`.
SchemaNode Version(std::string key, int version);

/// Three numbers of at least 0, linear Rec.709.
template <class... Members>
SchemaNode Colour(std::string key, Members... members) {
  return Key(std::move(key), members...) | AtLeast(0.0) | Unit("linear Rec.709");
}
/// Width and height.
template <class... Members>
SchemaNode Size(std::string key, Members... members) {
  constexpr double kMaxSize = 32768;
  return Key(std::move(key), members...) | From(1, kMaxSize) | Unit("pixels: width, height") |
         Optional();
}

// The parts of the tree.
SchemaNode InputSchema();
SchemaNode GeometrySchema();
SchemaNode MaterialsSchema();
SchemaNode TexturesSchema();
SchemaNode LightsSchema();
SchemaNode SensorsSchema();
SchemaNode UnknownsSchema();
SchemaNode GaugeSchema();
SchemaNode StagesSchema();
SchemaNode RenderSchema();
SchemaNode LossSchema();
SchemaNode SolverSchema();
SchemaNode OutputSchema();
SchemaNode GradcheckSchema();

}  // namespace pathfit::app
