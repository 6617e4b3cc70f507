#include "sim/ground/console/terminal.hpp"

#include <poll.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <utility>

namespace ilp::console {
namespace {

constexpr std::size_t kept_lines = 500;

struct Size {
  std::size_t columns = 80, rows = 24;
};

Size size_of_terminal() {
  winsize size{};
  if (::ioctl(STDOUT_FILENO, TIOCGWINSZ, &size) != 0 || size.ws_col < 20 || size.ws_row < 6) return {};
  return {size.ws_col, size.ws_row};
}

void write_out(const std::string& text) {
  std::fwrite(text.data(), 1, text.size(), stdout);
  std::fflush(stdout);
}

// A line as rows of the terminal.
std::vector<std::string> rows_of(const std::string& line, std::size_t columns) {
  std::vector<std::string> rows;
  for (std::size_t at = 0; at == 0 || at < line.size(); at += columns) {
    rows.push_back(fit(line.substr(at, columns), columns));
  }
  return rows;
}

}  // namespace

std::string fit(const std::string& text, std::size_t columns) {
  std::string out = text.substr(0, columns);
  std::replace_if(
      out.begin(), out.end(), [](char c) { return c < ' ' || c > '~'; }, '?');
  return out;
}

Terminal::Terminal(LineEditor::Complete complete) : editor_(std::move(complete)) {
  ::tcgetattr(STDIN_FILENO, &before_);
  termios now = before_;
  now.c_lflag &= ~static_cast<tcflag_t>(ICANON | ECHO);
  now.c_cc[VMIN] = 0;
  now.c_cc[VTIME] = 0;
  ::tcsetattr(STDIN_FILENO, TCSANOW, &now);
  write_out("\x1b[?1049h");
}

Terminal::~Terminal() {
  write_out("\x1b[?1049l");
  ::tcsetattr(STDIN_FILENO, TCSANOW, &before_);
}

std::optional<std::string> Terminal::read_line(bool& ended) {
  std::array<char, 256> buffer{};
  pollfd wait{STDIN_FILENO, POLLIN, 0};
  if (::poll(&wait, 1, 0) == 1) {
    const ssize_t size = ::read(STDIN_FILENO, buffer.data(), buffer.size());
    if (size > 0) editor_.take(std::string(buffer.data(), static_cast<std::size_t>(size)));
    if (size < 0 || (wait.revents & POLLHUP) != 0) ended = true;
  }
  std::optional<std::string> line = editor_.next_line();
  if (editor_.ended()) ended = true;
  for (const std::string& choice : editor_.take_choices()) say("  " + choice);
  return line;
}

void Terminal::say(const std::string& line) {
  lines_.push_back(line);
  if (lines_.size() > kept_lines) lines_.pop_front();
}

void Terminal::draw(const std::vector<std::string>& panel) {
  const Size size = size_of_terminal();
  std::vector<std::string> rows;
  for (const std::string& line : panel) {
    const std::vector<std::string> parts = rows_of(line, size.columns);
    rows.insert(rows.end(), parts.begin(), parts.end());
  }
  rows.emplace_back(size.columns, '-');
  // At least two rows for messages and one for the input line.
  if (rows.size() + 3 > size.rows) rows.resize(size.rows - 3);
  const std::size_t capacity = size.rows - rows.size() - 1;
  std::vector<std::string> said;
  for (auto line = lines_.rbegin(); line != lines_.rend() && said.size() < capacity; ++line) {
    std::vector<std::string> parts = rows_of(*line, size.columns);
    for (auto part = parts.rbegin(); part != parts.rend() && said.size() < capacity; ++part) said.push_back(*part);
  }
  said.resize(capacity);
  rows.insert(rows.end(), said.rbegin(), said.rend());
  std::string picture = "\x1b[H";
  for (const std::string& row : rows) picture += row + "\x1b[K\r\n";
  const std::string& typed = editor_.typed();
  const std::string tail = typed.size() + 3 > size.columns ? typed.substr(typed.size() + 3 - size.columns) : typed;
  picture += "> " + fit(tail, size.columns - 2) + "\x1b[K";
  if (picture == drawn_) return;
  write_out(picture);
  drawn_ = std::move(picture);
}

}  // namespace ilp::console
