// Reads a YAML document as a tree. A build without libyaml throws std::runtime_error instead.
#pragma once

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace ilp::host {

/// ASCII letters in lower case.
[[nodiscard]] std::string lower_case(std::string text);

/// A node of the document.
struct YamlTree {
  std::string scalar;
  bool is_scalar = false;
  std::map<std::string, std::size_t> members;  ///< mapping: key in lower case to index of the node
  std::vector<std::size_t> items;              ///< sequence: indices of the nodes
};

/// A node with access by key. Upper and lower case of keys are equal. Functions throw std::runtime_error that names a
/// key that is missing (except `find`) or has a value of another type.
class YamlNode {
 public:
  YamlNode(const std::vector<YamlTree>& nodes, std::size_t index, std::string key)
      : nodes_(&nodes), index_(index), key_(std::move(key)) {}

  [[nodiscard]] std::optional<YamlNode> find(const std::string& key) const;
  [[nodiscard]] YamlNode at(const std::string& key) const;
  [[nodiscard]] std::string text() const;
  [[nodiscard]] double number() const;
  [[nodiscard]] std::vector<double> numbers() const;
  /// The numbers of the member `data` (OpenCV's matrices); throws unless their count is `rows` times `cols`.
  [[nodiscard]] std::vector<double> matrix() const;

 private:
  const std::vector<YamlTree>* nodes_;
  std::size_t index_;
  std::string key_;
};

class YamlFile {
 public:
  /// Parses the text. Throws std::runtime_error that names the line of an error.
  explicit YamlFile(const std::string& text);
  [[nodiscard]] YamlNode root() const { return {nodes_, 0, "the document"}; }

 private:
  std::vector<YamlTree> nodes_;
};

}  // namespace ilp::host
