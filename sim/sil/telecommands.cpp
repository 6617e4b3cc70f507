#include "sim/sil/telecommands.hpp"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <sstream>
#include <stdexcept>
#include <string>

#include "hal/store/newest_id.hpp"
#include "sim/host/status_error.hpp"

namespace ilp::sil {
namespace {

CommandRecord parse(const std::string& line, const std::string& place) {
  std::istringstream words(line);
  double sent_s = 0;
  double subject = 0;
  std::string kind;
  std::string more;
  const bool complete = static_cast<bool>(words >> sent_s >> kind >> subject) && !(words >> more);
  const bool possible =
      std::isfinite(sent_s) && std::isfinite(subject) && std::fabs(sent_s) < 1e9 && std::fabs(subject) < 1e9;
  const bool refine = kind == "refine" && subject >= 1 && std::floor(subject) == subject;
  if (!complete || !possible || (kind != "capture" && !refine)) {
    throw std::runtime_error(place + ": expected SENT_S capture AT_S, two times in seconds, or SENT_S refine " +
                             "KEYFRAME, a time and a keyframe's number, found: " + line);
  }
  CommandRecord command;
  command.time_ns = std::llround(sent_s * 1e9);
  command.kind = refine ? CommandKind::refine : CommandKind::capture;
  if (refine) {
    command.keyframe_id = std::llround(subject);
  } else {
    command.at_ns = std::llround(subject * 1e9);
  }
  return command;
}

/// Components give other commands.
std::size_t commands_from_ground(Store& store) {
  std::size_t count = 0;
  CommandRecord command;
  for (std::int64_t id = 0; next(store, id, command).ok(); id = command.id) {
    if (command.kind == CommandKind::capture || command.kind == CommandKind::refine) ++count;
  }
  return count;
}

}  // namespace

Telecommands::Telecommands(const std::filesystem::path& file) {
  if (file.empty()) return;
  std::ifstream in(file);
  if (!in) throw std::runtime_error("telecommands " + file.string() + " cannot be read");
  std::string line;
  for (int number = 1; std::getline(in, line); ++number) {
    line.erase(std::min(line.find('#'), line.size()));
    if (line.find_first_not_of(" \t\r") == std::string::npos) continue;
    commands_.push_back(parse(line, file.string() + ", line " + std::to_string(number)));
  }
}

void Telecommands::send(Store& store, TimeNs now) {
  if (commands_.empty()) return;
  if (!received_) received_ = commands_from_ground(store);
  std::size_t& received = *received_;
  while (received < commands_.size() && commands_[received].time_ns <= now) {
    CommandRecord command = commands_[received];
    if (!newest_id<CommandRecord>(store, command.id).ok()) return;
    ++command.id;
    Transaction transaction(store);
    if (!transaction.begin().ok() || !put(store, command).ok() || !transaction.commit().ok()) return;  // tried again
    ++received;
  }
}

}  // namespace ilp::sil
