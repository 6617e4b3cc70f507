// A small flight that is commanded at its limits, in a process of its own, and how the ground reaches it afterwards.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "sim/host/image_io.hpp"
#include "tests/integration/flight_board.hpp"

namespace ilp::faults {

/// How a flight ended: a crash, a hang and lost contact break the promise.
enum class Fate : std::uint8_t {
  answered,      ///< a ping, as it was commanded
  refused,       ///< the parameters contradict each other
  trial,         ///< after the unconfirmed values were abandoned
  telecommand,   ///< after the built-in values were sent again without a reply
  pass,          ///< in the next pass of the schedule that was commanded
  starts,        ///< after repeated starts
  other_answer,  ///< refused what is valid, or took what is not
  no_start,      ///< the software could not be started
  lost,          ///< no contact any more
  hang,
  crash,
  kinds
};
[[nodiscard]] const char* fate_name(Fate fate);
[[nodiscard]] constexpr bool breaks_promise(Fate fate) {
  return fate >= Fate::other_answer;
}

/// 60 images of a simulated flight, rendered once.
[[nodiscard]] std::vector<host::Raster<std::uint8_t>> trial_images();
[[nodiscard]] CameraModel trial_camera();

/// Gives the images at equal intervals of mission time, over and over.
class TrialCamera final : public Camera {
 public:
  static constexpr TimeNs interval_ns = 500 * ns_per_ms;
  explicit TrialCamera(const std::vector<host::Raster<std::uint8_t>>& images) : images_(images) {}
  Status capture(TimeNs now, FrameImage& image, CameraFrame& frame) override;
  [[nodiscard]] bool restarts_counter() const override { return true; }

 private:
  const std::vector<host::Raster<std::uint8_t>>& images_;
  std::int64_t latest_ = -1;
  std::int64_t sequence_ = 0;
};

class TrialFlight {
 public:
  explicit TrialFlight(const std::vector<host::Raster<std::uint8_t>>& images);

  test::FlightBoard& board() { return board_; }
  /// Authentic where the flight asks for it.
  void send(int service, int subtype, const test::Octets& data);
  /// Parameters in as few telecommands as they fit; how the last one was answered.
  std::string set(const std::map<std::size_t, double>& values);
  /// Whether a ping is answered, under the address that the flight has.
  bool ping();
  /// How the flight can be reached; first of all as it is.
  Fate reach();

 private:
  [[nodiscard]] bool ping_in_next_pass();
  void set_built_in();

  TrialCamera camera_;
  test::FlightBoard board_;
  std::uint32_t sequence_ = 1000;
};

/// The result of one trial; lies in shared memory.
struct TrialResult {
  Fate fate = Fate::crash;
  char what[200] = {};
};

struct TrialTable {
  std::vector<std::string> rows;
  /// Runs in a process of its own; `describe` gives its row and its subject.
  std::function<Fate(std::int64_t)> trial;
  std::function<std::pair<std::size_t, std::string>(std::int64_t)> describe;
};

struct CampaignOptions {
  std::int64_t random = 100;  ///< combinations
  std::int64_t every = 1;     ///< one in `every` of the other trials is flown
  std::uint64_t seed = 1;
  std::int64_t only = -1;
  int jobs = 2;
  std::int64_t seconds = 60;
};

/// Prints the table in Markdown and every trial that broke the promise. True when none did.
bool run_table(const TrialTable& table, std::int64_t trials, const CampaignOptions& options);

bool parameter_trials(const CampaignOptions& options);
bool telecommand_trials(const CampaignOptions& options);
/// `options.random` sequences of settings, kills and starts.
bool restart_trials(const CampaignOptions& options);
/// As many telecommands as the flight takes, with replays, for `options.seconds` of mission time.
bool line_rate_trials(const CampaignOptions& options);

}  // namespace ilp::faults
