#include "sim/host/yaml_file.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#ifdef ILP_HAVE_YAML
#include <yaml.h>
#endif

namespace ilp::host {

std::string lower_case(std::string text) {
  std::ranges::transform(text, text.begin(), [](char c) { return c >= 'A' && c <= 'Z' ? char(c - 'A' + 'a') : c; });
  return text;
}

std::optional<YamlNode> YamlNode::find(const std::string& key) const {
  const YamlTree& node = (*nodes_)[index_];
  const auto member = node.members.find(key);
  if (member == node.members.end()) return std::nullopt;
  return YamlNode(*nodes_, member->second, key);
}

YamlNode YamlNode::at(const std::string& key) const {
  if (const auto found = find(key)) return *found;
  throw std::runtime_error(key + " is missing");
}

std::string YamlNode::text() const {
  if (!(*nodes_)[index_].is_scalar) throw std::runtime_error(key_ + " is not a word");
  return (*nodes_)[index_].scalar;
}

double YamlNode::number() const {
  const std::string word = text();
  std::size_t used = 0;
  double value = std::nan("");
  try {
    value = std::stod(word, &used);
  } catch (const std::exception&) {
    used = 0;
  }
  if (used != word.size() || !std::isfinite(value))
    throw std::runtime_error(key_ + ": '" + word + "' is not a finite number");
  return value;
}

std::vector<double> YamlNode::numbers() const {
  if ((*nodes_)[index_].is_scalar) throw std::runtime_error(key_ + " is not a list of numbers");
  std::vector<double> values;
  for (const std::size_t item : (*nodes_)[index_].items) values.push_back(YamlNode(*nodes_, item, key_).number());
  return values;
}

std::vector<double> YamlNode::matrix() const {
  std::vector<double> values = YamlNode(*nodes_, at("data").index_, key_).numbers();
  if (at("rows").number() * at("cols").number() != static_cast<double>(values.size()))
    throw std::runtime_error(key_ + " has " + std::to_string(values.size()) + " numbers, not rows times cols");
  return values;
}

#ifdef ILP_HAVE_YAML
namespace {

/// What libyaml allocates is freed, whatever happens.
struct Document {
  yaml_parser_t parser{};
  yaml_document_t document{};
  bool loaded = false;

  explicit Document(const std::string& text) {
    if (yaml_parser_initialize(&parser) == 0) throw std::runtime_error("no memory for YAML");
    yaml_parser_set_input_string(&parser, reinterpret_cast<const unsigned char*>(text.data()), text.size());
    loaded = yaml_parser_load(&parser, &document) != 0;
  }
  Document(const Document&) = delete;
  Document& operator=(const Document&) = delete;
  ~Document() {
    if (loaded) yaml_document_delete(&document);
    yaml_parser_delete(&parser);
  }
};

/// libyaml counts nodes from 1.
std::size_t index_of(int node) {
  return static_cast<std::size_t>(node - 1);
}

std::string scalar_of(const yaml_node_t& node) {
  return {reinterpret_cast<const char*>(node.data.scalar.value), node.data.scalar.length};
}

}  // namespace

YamlFile::YamlFile(const std::string& text) {
  // OpenCV's first line is %YAML:1.0, which YAML does not allow.
  std::string rest = text;
  if (rest.starts_with("%YAML:")) rest[0] = '#';
  Document yaml(rest);
  if (!yaml.loaded) {
    const char* const problem = yaml.parser.problem != nullptr ? yaml.parser.problem : "it cannot be parsed";
    throw std::runtime_error("line " + std::to_string(yaml.parser.problem_mark.line + 1) + ": no YAML: " + problem);
  }
  if (yaml_document_get_root_node(&yaml.document) == nullptr) throw std::runtime_error("it is empty");
  for (const yaml_node_t* node = yaml.document.nodes.start; node != yaml.document.nodes.top; ++node) {
    YamlTree& out = nodes_.emplace_back();
    if (node->type == YAML_SCALAR_NODE) {
      out.is_scalar = true;
      out.scalar = scalar_of(*node);
    } else if (node->type == YAML_SEQUENCE_NODE) {
      const auto& items = node->data.sequence.items;
      for (const int* item = items.start; item != items.top; ++item) out.items.push_back(index_of(*item));
    } else if (node->type == YAML_MAPPING_NODE) {
      const auto& pairs = node->data.mapping.pairs;
      for (const yaml_node_pair_t* pair = pairs.start; pair != pairs.top; ++pair) {
        const yaml_node_t& key = *yaml_document_get_node(&yaml.document, pair->key);
        if (key.type != YAML_SCALAR_NODE) continue;
        const bool is_new = out.members.emplace(lower_case(scalar_of(key)), index_of(pair->value)).second;
        if (!is_new) throw std::runtime_error(scalar_of(key) + " is there twice");
      }
    }
  }
}
#else
YamlFile::YamlFile(const std::string&) {
  throw std::runtime_error(
      "it is YAML, and these programs were built without libyaml: apt-get install libyaml-dev, and build again; or "
      "write COLMAP's format, 1 MODEL WIDTH HEIGHT PARAMETERS");
}
#endif

}  // namespace ilp::host
