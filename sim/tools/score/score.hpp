// One flight against the truth, from the folder that ilp-sil leaves to all numbers of score.json.
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

inline constexpr double degrees = 180 / std::numbers::pi;  ///< of a radian

struct ScoreOptions {
  std::filesystem::path flight;     ///< flight.db, outbox/, flight-info.json and mostly flight/
  std::filesystem::path truth;      ///< folder with poses.txt and depth/NAME.pfm; empty: flight/truth in the flight
  std::filesystem::path received;   ///< folder of the files that came down; empty: outbox/ in the flight
  std::filesystem::path reference;  ///< camera text file of a recorded strip, instead of truth
};

[[nodiscard]] std::filesystem::path truth_folder(const ScoreOptions& options);

/// The files of a flight that may have been killed at any moment.
struct FlightFiles {
  intake::Flight flight;
  intake::Outbox outbox;
  std::optional<intake::FlightInfo> info;
  std::optional<report::ReferenceFiles> reference;
  double target_overlap = 0;
  bool complete = false;
  std::vector<std::string> remarks;  ///< why it is not complete, what could not be used
};

/// Nothing in the folder is changed. std::runtime_error when it holds no flight, when there is no truth, or when
/// database or truth cannot be read.
[[nodiscard]] FlightFiles open_flight(const ScoreOptions& options);

struct StripScore {
  std::int64_t id = 0;
  std::size_t keyframes = 0;
  std::size_t posed = 0;  ///< with a final pose; the track's samples are those that the truth knows
  StripTrack track;
  double length = 0;  ///< true, of the samples
  std::optional<PoseScore> poses;
  std::size_t first_keyframes = 0, first_posed = 0;  ///< of the first five of a strip of two or more
  std::optional<PoseScore> first_poses;              ///< of these alone, in an alignment of their own
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

/// Poses and what follows from them. std::runtime_error when there are final poses and the truth knows none of their
/// images: it is another flight's.
[[nodiscard]] Score score_poses_of(const FlightFiles& files);

/// Flat numbers for tables over many flights; NaN where a flight gives no value. Strips are weighted by their true
/// length, keyframes' rotations and sigmas count alike. bow_percent and scale_drift_percent are of absolute values.
[[nodiscard]] std::map<std::string, double> summary_of(const Score& score);
/// How far scale and upright axis by the vehicle's navigation are from the truth; empty without navigation.
[[nodiscard]] std::map<std::string, double> navigation_summary(const Score& score, const intake::Flight& flight);

// The scorer's work on one flight: read, measure, write score.json, print the table.

/// Writes `out` (empty: score.json in the flight's folder), beside it height-error.pfm where heights could be compared
/// (truth's unit, on the grid of the truth's height.pfm, NaN elsewhere), and the table to `table`. std::runtime_error
/// with a message for the user.
void run_score(const ScoreOptions& options, const std::filesystem::path& out, std::ostream& table);

}  // namespace ilp::score
