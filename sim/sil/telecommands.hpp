// Sends telecommands from a file at their times, in place of the ground in a simulated flight.
#pragma once

#include <filesystem>
#include <optional>
#include <vector>

#include "fsw/base/time.hpp"
#include "fsw/records/records.hpp"
#include "hal/store/store.hpp"

namespace ilp::sil {

/// Commands are sent in the order of the file. Commands that an earlier boot of the flight has received are not sent
/// again.
class Telecommands {
 public:
  /// Reads a command per line; `#` begins a comment. SENT_S is the time at which the command is sent, in seconds of
  /// mission time.
  ///   SENT_S capture AT_S                       take an image at the mission time AT_S
  ///   SENT_S place LONGITUDE LATITUDE METRES    take an image where the flight passes a place (degrees) within METRES
  ///   SENT_S refine KEYFRAME                    send all products of a keyframe before all others
  /// An empty path means no commands. Throws std::runtime_error that names file and line, and what was expected.
  explicit Telecommands(const std::filesystem::path& file);

  /// Puts the commands that are due into the store.
  void send(Store& store, TimeNs now);
  [[nodiscard]] std::size_t count() const { return commands_.size(); }

 private:
  std::vector<CommandRecord> commands_;  ///< time_ns: when it is sent
  std::optional<std::size_t> received_;  ///< number received by the flight; empty before the first `send`
};

}  // namespace ilp::sil
