// Writes indented XML element by element.
#pragma once

#include <string>
#include <utility>
#include <vector>

namespace ilp::docgen {

class Xml {
 public:
  using Attributes = std::vector<std::pair<const char*, std::string>>;

  explicit Xml(std::size_t depth = 0) : depth_(depth) {}

  /// Begins an element. Attributes with empty values are left out.
  void open(const std::string& name, const Attributes& attributes = {});
  void close();
  /// Writes an element without children.
  void leaf(const std::string& name, const Attributes& attributes, const std::string& text = {});
  /// Appends elements that were written separately, unchanged.
  void append(const std::string& elements) { text_ += elements; }

  [[nodiscard]] const std::string& text() const { return text_; }
  [[nodiscard]] bool empty() const { return text_.empty(); }

 private:
  void begin(const std::string& name, const Attributes& attributes);

  std::string text_;
  std::size_t depth_;
  std::vector<std::string> open_;
};

}  // namespace ilp::docgen
