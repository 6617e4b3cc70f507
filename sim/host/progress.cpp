#include "sim/host/progress.hpp"

#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <iostream>

#include "sim/host/text_format.hpp"

namespace ilp::host {
namespace {

using Clock = std::chrono::steady_clock;
constexpr const char* clear_line = "\r\033[K";
constexpr double rewrite_s = 0.25;
constexpr double line_s = 5;
constexpr double line_share = 0.2;  ///< of the time so far: long work leaves few lines
constexpr double phase_s = 3;

double seconds_since(Clock::time_point begin) {
  return std::chrono::duration<double>(Clock::now() - begin).count();
}

std::string about(double seconds) {
  const bool minutes = seconds >= 120;
  return "about " + fixed(std::ceil(minutes ? seconds / 60 : seconds), 0) + (minutes ? " min" : " s");
}

}  // namespace

ProgressStyle progress_style(const std::ostream& messages) {
  const bool terminal = messages.rdbuf() == std::cerr.rdbuf() && isatty(STDERR_FILENO) != 0;
  return terminal ? ProgressStyle::rewritten : ProgressStyle::lines;
}

std::string progress_text(const std::string& what, std::size_t done, std::size_t all, double elapsed_s) {
  std::string text = what + ": " + std::to_string(done);
  if (all == 0) return text;
  text += " of " + std::to_string(all);
  if (done == 0 || done >= all) return text;
  const double left_s = elapsed_s * static_cast<double>(all - done) / static_cast<double>(done);
  return text + ", " + about(left_s) + " left";
}

Progress::Progress(std::ostream& messages, std::string what, ProgressStyle style)
    : messages_(messages), what_(std::move(what)), style_(style) {}

void Progress::update(std::size_t done, std::size_t all, double elapsed_s) {
  if (all > 0 && done >= all) return end();
  const bool rewritten = style_ == ProgressStyle::rewritten;
  if (elapsed_s - reported_s_ < (rewritten ? rewrite_s : std::max(line_s, line_share * elapsed_s))) return;
  reported_s_ = elapsed_s;
  const std::string text = progress_text(what_, done, all, elapsed_s);
  messages_ << (rewritten ? clear_line + text : text + "\n") << std::flush;
  open_ = rewritten;
}

void Progress::end() {
  if (open_) messages_ << clear_line << std::flush;
  open_ = false;
}

double Progress::seconds_since_begin() const {
  return seconds_since(begun_);
}

void LongPhases::operator()(const std::string& phase) {
  const bool rewritten = style_ == ProgressStyle::rewritten;
  if (!rewritten && seconds_since(begun_) < phase_s) return;
  messages_ << (rewritten ? clear_line + phase : phase + "\n") << std::flush;
  open_ = rewritten;
}

LongPhases::~LongPhases() {
  if (open_) messages_ << clear_line << std::flush;
}

}  // namespace ilp::host
