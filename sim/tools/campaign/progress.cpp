#include "sim/tools/campaign/progress.hpp"

#include "sim/host/text_format.hpp"

namespace ilp::batch {

Progress::Progress(std::ostream& out, bool terminal, std::size_t total, std::size_t done_before, std::size_t parallel)
    : out_(&out), terminal_(terminal), total_(total), before_(done_before), parallel_(parallel) {
  *out_ << ground::counted(total, "flight");
  if (before_ > 0) *out_ << ", " << before_ << " done before";
  *out_ << ", " << parallel_ << " at a time" << std::endl;
  tenths_ = total_ == 0 ? 10 : before_ * 10 / total_;
}

std::string Progress::text() const {
  std::string line = std::to_string(before_ + done_) + "/" + std::to_string(total_) + " done";
  if (failed_ > 0) line += ", " + std::to_string(failed_) + " failed";
  const std::size_t left = total_ - before_ - done_;
  if (done_ == 0 || left == 0) return line;
  const double elapsed = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin_).count();
  return line + ", about " + ground::duration_text(elapsed / static_cast<double>(done_) * static_cast<double>(left)) +
         " left";
}

void Progress::clear() {
  if (shown_) *out_ << "\r\033[K";
  shown_ = false;
}

void Progress::ended(const std::string& job, const std::string& failure) {
  ++done_;
  if (!failure.empty()) {
    ++failed_;
    clear();
    *out_ << "failed: " << job << ": " << failure << std::endl;
  }
  const std::size_t tenths = (before_ + done_) * 10 / total_;
  if (!terminal_ && tenths > tenths_) *out_ << text() << std::endl;
  tenths_ = tenths;
}

void Progress::tick(std::size_t running) {
  if (!terminal_) return;
  clear();
  *out_ << text() << " (" << running << " running)" << std::flush;
  shown_ = true;
}

void Progress::close() {
  clear();
  out_->flush();
}

}  // namespace ilp::batch
