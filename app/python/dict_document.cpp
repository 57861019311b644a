#include "app/python/dict_document.h"

#include <stdexcept>
#include <utility>

namespace pathfit::app {
namespace {

namespace py = pybind11;
using Kind = YamlNode::Kind;

constexpr Place kNoLine{Place::Source::kFile, 0, 0, 0};

class TreeOfDict {
 public:
  explicit TreeOfDict(std::vector<Problem>& problems) : problems_(problems) {}

  YamlNode NodeOf(const py::handle& value, const std::string& path, int depth) {
    YamlNode node;
    node.place = kNoLine;
    if (value.is_none()) return node;
    if (depth > kMaxYamlDepth) {
      Report(path, "deeper than " + std::to_string(kMaxYamlDepth) + " levels");
    } else if (py::isinstance<py::bool_>(value)) {
      SetScalar(node, value.cast<bool>() ? "true" : "false");
    } else if (py::isinstance<py::str>(value)) {
      SetScalar(node, value.cast<std::string>());
      node.quoted = true;
    } else if (py::isinstance<py::int_>(value)) {
      SetScalar(node, py::str(value));
    } else if (py::isinstance<py::float_>(value)) {
      SetScalar(node, TextOf(value));
    } else if (py::isinstance<py::dict>(value)) {
      FillMap(node, py::reinterpret_borrow<py::dict>(value), path, depth);
    } else if (py::isinstance<py::list>(value) || py::isinstance<py::tuple>(value)) {
      node.kind = Kind::kList;
      for (const py::handle item : value) {
        const std::string place = path + "[" + std::to_string(node.items.size()) + "]";
        node.items.push_back(NodeOf(item, place, depth + 1));
      }
    } else if (py::hasattr(value, "tolist")) {
      return NodeOf(value.attr("tolist")(), path, depth + 1);
    } else if (py::hasattr(value, "__fspath__")) {
      return NodeOf(value.attr("__fspath__")(), path, depth + 1);
    } else {
      Report(path, "a " + TypeName(value) + " is no value of a config");
    }
    return node;
  }

 private:
  static std::string TypeName(const py::handle& value) {
    return py::str(py::type::handle_of(value).attr("__name__"));
  }
  static void SetScalar(YamlNode& node, std::string text) {
    node.kind = Kind::kScalar;
    node.text = std::move(text);
  }
  /// The shortest that reads back to the same bits.
  static std::string TextOf(const py::handle& number) {
    std::string text = py::str(py::float_(py::reinterpret_borrow<py::object>(number)));
    if (text == "inf" || text == "-inf" || text == "nan") {
      text.insert(text[0] == '-' ? 1 : 0, ".");
    }
    return text;
  }
  void FillMap(YamlNode& node, const py::dict& dict, const std::string& path, int depth) {
    node.kind = Kind::kMap;
    for (const auto& [key, value] : dict) {
      if (!py::isinstance<py::str>(key)) {
        Report(path, "the key " + std::string(py::repr(key)) + " is no text");
        continue;
      }
      const std::string name = py::str(key);
      const std::string below = path.empty() ? name : path + "." + name;
      node.entries.push_back({name, kNoLine, NodeOf(value, below, depth + 1)});
    }
  }
  void Report(const std::string& path, std::string text) {
    problems_.push_back({kNoLine, path, std::move(text)});
  }

  std::vector<Problem>& problems_;
};

void AppendQuoted(const std::string& text, std::string& out) {
  out += '\'';
  for (const char c : text) out.append(c == '\'' ? 2 : 1, c);
  out += '\'';
}

void AppendInOneLine(const YamlNode& node, std::string& out) {
  switch (node.kind) {
    case Kind::kNull:
      out += "null";
      break;
    case Kind::kScalar:
      if (node.quoted) {
        AppendQuoted(node.text, out);
      } else {
        out += node.text;
      }
      break;
    case Kind::kList:
      out += '[';
      for (const YamlNode& item : node.items) {
        AppendInOneLine(item, out);
        out += ", ";
      }
      out += ']';
      break;
    case Kind::kMap:
      out += '{';
      for (const YamlEntry& entry : node.entries) {
        AppendQuoted(entry.key, out);
        out += ": ";
        AppendInOneLine(entry.value, out);
        out += ", ";
      }
      out += '}';
      break;
  }
}

}  // namespace

YamlDocument DocumentOf(const py::dict& config, const std::string& name) {
  YamlDocument document;
  document.source.file = name;
  document.root = TreeOfDict(document.problems).NodeOf(config, "", 0);
  return document;
}

std::string OverrideText(const py::handle& value) {
  if (py::isinstance<py::str>(value)) return value.cast<std::string>();
  std::vector<Problem> problems;
  const YamlNode node = TreeOfDict(problems).NodeOf(value, "", 0);
  if (!problems.empty()) throw py::type_error(problems.front().text);
  std::string text;
  AppendInOneLine(node, text);
  return text;
}

}  // namespace pathfit::app
