// A YAML document as a tree. A build without libyaml reads none, and says so.
#pragma once

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace ilp::host {

/// ASCII.
[[nodiscard]] std::string lower_case(std::string text);

struct YamlTree {
  std::string scalar;
  bool is_scalar = false;
  std::map<std::string, std::size_t> members;  ///< of a mapping, by key in lower case: index of the node
  std::vector<std::size_t> items;              ///< of a sequence
};

/// Keys are found in either case. std::runtime_error names a key that is missing, or whose value is of another kind.
class YamlNode {
 public:
  YamlNode(const std::vector<YamlTree>& nodes, std::size_t index, std::string key)
      : nodes_(&nodes), index_(index), key_(std::move(key)) {}

  [[nodiscard]] std::optional<YamlNode> find(const std::string& key) const;
  [[nodiscard]] YamlNode at(const std::string& key) const;
  [[nodiscard]] std::string text() const;
  [[nodiscard]] double number() const;
  [[nodiscard]] std::vector<double> numbers() const;
  /// The numbers of `data`, of which there are `rows` times `cols`.
  [[nodiscard]] std::vector<double> matrix() const;

 private:
  const std::vector<YamlTree>* nodes_;
  std::size_t index_;
  std::string key_;
};

class YamlFile {
 public:
  /// std::runtime_error names the line that is no YAML.
  explicit YamlFile(const std::string& text);
  [[nodiscard]] YamlNode root() const { return {nodes_, 0, "the document"}; }

 private:
  std::vector<YamlTree> nodes_;
};

}  // namespace ilp::host
