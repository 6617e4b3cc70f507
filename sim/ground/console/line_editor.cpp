#include "sim/ground/console/line_editor.hpp"

#include <algorithm>

namespace ilp::console {
namespace {

constexpr std::size_t remembered_lines = 500;
constexpr char end_of_input = 4, backspace = 8, tabulator = 9, kill_line = 21, escape = 27, rubout = 127;

std::size_t common_length(const std::vector<std::string>& lines) {
  std::size_t length = lines.front().size();
  for (const std::string& line : lines) {
    const auto [a, b] = std::mismatch(line.begin(), line.end(), lines.front().begin(), lines.front().end());
    length = std::min(length, static_cast<std::size_t>(a - line.begin()));
  }
  return length;
}

}  // namespace

/// An escape sequence at the front of the keys: up and down recall lines, others are ignored. False if its rest has not
/// come yet.
bool LineEditor::take_sequence() {
  if (keys_.size() < 2) return false;
  if (keys_[1] != '[' && keys_[1] != 'O') {
    keys_.erase(0, 1);
    return true;
  }
  const auto end = std::find_if(keys_.begin() + 2, keys_.end(), [](char c) { return c >= '@' && c <= '~'; });
  if (end == keys_.end()) return false;
  const char key = *end;
  keys_.erase(keys_.begin(), end + 1);
  if (key == 'A' && place_ > 0) recall(place_ - 1);
  if (key == 'B' && place_ < history_.size()) recall(place_ + 1);
  return true;
}

void LineEditor::recall(std::size_t place) {
  if (place_ == history_.size()) begun_ = typed_;
  place_ = place;
  typed_ = place == history_.size() ? begun_ : history_[place];
}

void LineEditor::complete() {
  const std::vector<std::string> lines = complete_ ? complete_(typed_) : std::vector<std::string>();
  if (lines.empty()) return;
  const std::size_t length = common_length(lines);
  if (lines.size() > 1 && length <= typed_.size()) choices_ = lines;
  typed_ = lines.front().substr(0, std::max(length, typed_.size()));
}

std::optional<std::string> LineEditor::next_line() {
  while (!keys_.empty()) {
    const char key = keys_.front();
    if (key == escape) {
      if (!take_sequence()) return std::nullopt;
      continue;
    }
    keys_.erase(0, 1);
    if (key == '\n' || key == '\r') {
      if (!typed_.empty() && (history_.empty() || history_.back() != typed_)) history_.push_back(typed_);
      if (history_.size() > remembered_lines) history_.erase(history_.begin());
      place_ = history_.size();
      return std::exchange(typed_, {});
    }
    if (key == end_of_input && typed_.empty()) ended_ = true;
    if (key == kill_line) typed_.clear();
    if (key == tabulator) complete();
    if ((key == backspace || key == rubout) && !typed_.empty()) typed_.pop_back();
    if (key >= ' ' && key < rubout) typed_ += key;
  }
  return std::nullopt;
}

}  // namespace ilp::console
