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

/// Of a command's words after the time: `kind` and numbers; false where they are none.
bool fill(const std::string& kind, const std::vector<double>& numbers, CommandRecord& command) {
  if (kind == "capture" && numbers.size() == 1) {
    command.kind = CommandKind::capture;
    command.at_ns = std::llround(numbers[0] * 1e9);
    return true;
  }
  if (kind == "refine" && numbers.size() == 1 && numbers[0] >= 1 && std::floor(numbers[0]) == numbers[0]) {
    command.kind = CommandKind::refine;
    command.keyframe_id = std::llround(numbers[0]);
    return true;
  }
  if (kind == "place" && numbers.size() == 3) {
    command.kind = CommandKind::capture_place;
    command.longitude_deg = numbers[0];
    command.latitude_deg = numbers[1];
    command.distance_m = numbers[2];
    return true;
  }
  return false;
}

CommandRecord parse(const std::string& line, const std::string& place) {
  constexpr double largest = 1e9;
  std::istringstream words(line);
  double sent_s = 0;
  std::string kind;
  std::vector<double> numbers;
  bool possible = static_cast<bool>(words >> sent_s >> kind) && std::fabs(sent_s) < largest;
  for (double number = 0; words >> number;) {
    possible = possible && std::fabs(number) < largest;
    numbers.push_back(number);
  }
  CommandRecord command;
  if (!possible || !words.eof() || !fill(kind, numbers, command)) {
    throw std::runtime_error(place +
                             ": expected SENT_S capture AT_S, two times in seconds, SENT_S place LONGITUDE LATITUDE "
                             "METRES, or SENT_S refine KEYFRAME, found: " +
                             line);
  }
  command.time_ns = std::llround(sent_s * 1e9);
  return command;
}

/// Components give other commands.
std::size_t commands_from_ground(Store& store) {
  std::size_t count = 0;
  CommandRecord command;
  for (std::int64_t id = 0; next(store, id, command).ok(); id = command.id) {
    const CommandKind kind = command.kind;
    if (kind == CommandKind::capture || kind == CommandKind::refine || kind == CommandKind::capture_place) ++count;
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
