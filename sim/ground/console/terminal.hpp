// A terminal with a panel at the top, lines that scroll, and an input line at the bottom, drawn with ANSI sequences.
#pragma once

#include <termios.h>
#include <deque>
#include <optional>
#include <string>
#include <vector>

#include "sim/ground/console/line_editor.hpp"

namespace ilp::console {

/// Reads keys one by one. The destructor restores the terminal.
class Terminal {
 public:
  explicit Terminal(LineEditor::Complete complete);
  ~Terminal();
  Terminal(const Terminal&) = delete;
  Terminal& operator=(const Terminal&) = delete;

  /// The next whole line that was typed; none if there is none yet. `ended` becomes true at the end of the input.
  std::optional<std::string> read_line(bool& ended);
  void say(const std::string& line);
  void draw(const std::vector<std::string>& panel);

 private:
  termios before_{};
  LineEditor editor_;
  std::deque<std::string> lines_;
  std::string drawn_;
};

/// The text cut to `columns` columns; characters that are not printable ASCII become `?`.
[[nodiscard]] std::string fit(const std::string& text, std::size_t columns);

}  // namespace ilp::console
