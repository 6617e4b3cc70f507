// The ground's side of a simulated flight: telecommands from a file, sent at their times.
#pragma once

#include <filesystem>
#include <optional>
#include <vector>

#include "fsw/base/time.hpp"
#include "fsw/records/records.hpp"
#include "hal/store/store.hpp"

namespace ilp::sil {

/// Sent in the order of the file. What an earlier boot of the flight has received is not sent again.
class Telecommands {
 public:
  /// A line `SENT_S capture AT_S` each: sent at the one time, wants an image at the other, both in seconds of mission
  /// time; `SENT_S place LONGITUDE LATITUDE METRES`: wants an image where the flight passes a place within a distance;
  /// or `SENT_S refine KEYFRAME`: wants all of a keyframe's products before all others. `#` begins a comment. An empty
  /// path holds none. std::runtime_error names file and line, and what was expected.
  explicit Telecommands(const std::filesystem::path& file);

  /// Puts what is due into the store.
  void send(Store& store, TimeNs now);
  [[nodiscard]] std::size_t count() const { return commands_.size(); }

 private:
  std::vector<CommandRecord> commands_;  ///< time_ns: when it is sent
  std::optional<std::size_t> received_;  ///< of them by the flight; unknown before the first look
};

}  // namespace ilp::sil
