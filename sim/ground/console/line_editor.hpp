// Edits the input line of a terminal, with history (arrow keys) and completion (tabulator).
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace ilp::console {

class LineEditor {
 public:
  /// Returns the possible completions of a line, as whole lines.
  using Complete = std::function<std::vector<std::string>(const std::string&)>;
  explicit LineEditor(Complete complete = {}) : complete_(std::move(complete)) {}

  /// Adds octets from the terminal; sequences may be split.
  void take(const std::string& keys) { keys_ += keys; }
  /// Processes the octets up to the next finished line; none if no line is finished.
  std::optional<std::string> next_line();

  [[nodiscard]] const std::string& typed() const { return typed_; }
  /// Whether Control-D was typed on an empty line.
  [[nodiscard]] bool ended() const { return ended_; }
  /// The possible completions since the last call; empty if none was ambiguous.
  [[nodiscard]] std::vector<std::string> take_choices() { return std::exchange(choices_, {}); }

 private:
  bool take_sequence();
  void recall(std::size_t place);
  void complete();

  Complete complete_;
  std::string keys_, typed_, begun_;
  std::vector<std::string> history_;
  std::size_t place_ = 0;  ///< index in the history; its size: the line that is being typed
  std::vector<std::string> choices_;
  bool ended_ = false;
};

}  // namespace ilp::console
