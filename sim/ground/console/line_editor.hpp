// The input line of a terminal: typing, earlier lines with the arrow keys, completion with the tabulator.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace ilp::console {

class LineEditor {
 public:
  /// Whole lines that begin as the given one.
  using Complete = std::function<std::vector<std::string>(const std::string&)>;
  explicit LineEditor(Complete complete = {}) : complete_(std::move(complete)) {}

  /// Octets as the terminal sends them, in any portions.
  void take(const std::string& keys) { keys_ += keys; }
  /// Works through the octets up to the next finished line.
  std::optional<std::string> next_line();

  [[nodiscard]] const std::string& typed() const { return typed_; }
  /// Control-D on an empty line.
  [[nodiscard]] bool ended() const { return ended_; }
  /// Possible completions since the last call, if there were several.
  [[nodiscard]] std::vector<std::string> take_choices() { return std::exchange(choices_, {}); }

 private:
  bool take_sequence();
  void recall(std::size_t place);
  void complete();

  Complete complete_;
  std::string keys_, typed_, begun_;
  std::vector<std::string> history_;
  std::size_t place_ = 0;  ///< in the history; its end: the line that was begun
  std::vector<std::string> choices_;
  bool ended_ = false;
};

}  // namespace ilp::console
