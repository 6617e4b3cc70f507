// Draws a terminal with ANSI sequences: a panel at the top, lines that scroll, and an input line at the bottom.
#pragma once

#include <termios.h>
#include <deque>
#include <optional>
#include <string>
#include <vector>

#include "sim/ground/console/line_editor.hpp"

namespace ilp::console {

/// Switches the terminal to unbuffered input; the destructor restores it.
class Terminal {
 public:
  explicit Terminal(LineEditor::Complete complete);
  ~Terminal();
  Terminal(const Terminal&) = delete;
  Terminal& operator=(const Terminal&) = delete;

  /// The next line that was typed; none: no line is finished. Sets `ended` at the end of the input.
  std::optional<std::string> read_line(bool& ended);
  /// Adds a line to those that scroll.
  void say(const std::string& line);
  /// Draws everything, with `panel` at the top.
  void draw(const std::vector<std::string>& panel);

 private:
  termios before_{};
  LineEditor editor_;
  std::deque<std::string> lines_;
  std::string drawn_;
};

/// Truncates a text to `columns` characters, and replaces those that are not printable ASCII by `?`.
[[nodiscard]] std::string fit(const std::string& text, std::size_t columns);

}  // namespace ilp::console
