// Scores one flight against the truth: reads the folder that ilp-sil leaves, and writes score.json.
#pragma once

#include <filesystem>
#include <iosfwd>
#include <map>
#include <numbers>
#include <optional>
#include <string>
#include <vector>

#include "sim/ground/intake/flight_info.hpp"
#include "sim/ground/report/accuracy.hpp"
#include "sim/tools/score/drift.hpp"
#include "sim/tools/score/pose_score.hpp"

namespace ilp::score {

inline constexpr double degrees = 180 / std::numbers::pi;  ///< degrees per radian

struct ScoreOptions {
  std::filesystem::path flight;     ///< folder with flight.db, outbox/, flight-info.json and mostly flight/
  std::filesystem::path truth;      ///< folder with poses.txt and depth/NAME.pfm; empty: flight/truth in `flight`
  std::filesystem::path received;   ///< folder of downlinked files; empty: outbox/ in `flight`
  std::filesystem::path reference;  ///< reference poses of a recorded strip, used instead of `truth`
};

[[nodiscard]] std::filesystem::path truth_folder(const ScoreOptions& options);

/// Contents of a flight's folder. The flight may have been killed at any moment.
struct FlightFiles {
  intake::Flight flight;
  intake::Outbox outbox;
  std::optional<intake::FlightInfo> info;
  std::optional<report::ReferenceFiles> reference;
  double target_overlap = 0;         ///< 0: not known
  bool complete = false;             ///< nothing is missing or damaged: no remarks
  std::vector<std::string> remarks;  ///< why the flight is not complete, and what could not be used
};

/// Reads the folder and changes nothing in it. Throws std::runtime_error if the folder holds no flight, if there is no
/// truth, or if database or truth cannot be read.
[[nodiscard]] FlightFiles open_flight(const ScoreOptions& options);

struct StripScore {
  std::int64_t id = 0;
  std::size_t keyframes = 0;
  std::size_t posed = 0;  ///< keyframes with a final pose
  StripTrack track;       ///< samples: posed keyframes with a true pose
  double length = 0;      ///< true length along the samples, truth's unit
  std::optional<PoseScore> poses;
  /// The first five keyframes, and those of them with a final pose; 0 for a strip of one keyframe.
  std::size_t first_keyframes = 0, first_posed = 0;
  std::optional<PoseScore> first_poses;  ///< of the first five only, with an alignment of their own
  std::optional<Drift> drift;
  std::optional<ScaleDrift> scale_drift;
  std::optional<Bow> bow;
  SigmaScore sigmas;
};

struct Score {
  bool complete = false;
  std::size_t frames = 0, keyframes = 0, posed = 0;
  double target_overlap = 0;
  std::vector<StripScore> strips;
  std::vector<std::string> remarks;
};

/// Scores the poses of all strips. Throws std::runtime_error if there are final poses but the truth has none of their
/// images, i.e. it belongs to another flight.
[[nodiscard]] Score score_poses_of(const FlightFiles& files);

/// Numbers by metric (sim/host/metrics.inc) for tables over many flights; NaN where a flight gives no value. Strips are
/// weighted by their true length. Rotations and sigmas of all keyframes have the same weight. bow_percent and
/// scale_drift_percent are means of absolute values.
[[nodiscard]] std::map<std::string, double> summary_of(const Score& score);
/// Errors of the scale and the vertical that the flight took from the vehicle's navigation; empty without navigation.
[[nodiscard]] std::map<std::string, double> navigation_summary(const Score& score, const intake::Flight& flight);

// Reads, scores, writes score.json and prints the table.

/// Scores a flight. Writes the JSON file `out` (empty: score.json in the flight's folder) and the table to `table`. If
/// heights could be compared, writes height-error.pfm beside `out`: errors in the truth's unit on the grid of the
/// truth's height.pfm, NaN where not compared. Throws std::runtime_error with a message for the user.
void run_score(const ScoreOptions& options, const std::filesystem::path& out, std::ostream& table);

}  // namespace ilp::score
