// Everything the report tells, gathered before it is written as JSON and as a page.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "sim/ground/accuracy.hpp"
#include "sim/ground/colmap_model.hpp"
#include "sim/ground/keyframe_look.hpp"
#include "sim/ground/missing.hpp"
#include "sim/ground/score_file.hpp"
#include "sim/ground/strip_map.hpp"

namespace ilp::ground {

/// What the run on the host cost; all optional.
struct FlightInfo {
  std::optional<double> wall_s, cpu_s, flight_cpu_s, peak_rss_mib, static_bytes;
  std::optional<double> frames, keyframes, seed, target_overlap;
  std::string profile, software, source;
};

/// Peak signal-to-noise ratio of a decoded image against the original, in dB.
struct ImageQuality {
  double inside_db = unknown;  ///< inside the mask
  double outside_db = unknown;
};

struct StripResult {
  Strip strip;
  std::string suffix;  ///< of its files: empty for the first, "-strip-N" for the others
  std::size_t posed = 0;
  double track_length = 0;         ///< strip units, path over the posed keyframes
  double flying_height = 0;        ///< strip units, median depth
  double mask_share = 0;           ///< newly seen pixels with depth / pixels of the posed keyframes' images
  std::optional<GroundGrid> grid;  ///< of the map, whole or, where that is too large, an overview of it
  MapGeometry geometry;            ///< of the map itself
  MapStatistics map;
  Plane plane;
  ColmapCounts colmap;
  std::string place;               ///< a sentence on where the strip's world is
  std::vector<std::string> files;  ///< that other tools open
  std::size_t vertices = 0, faces = 0;
  std::int32_t stride = 1;
  std::optional<StripAccuracy> accuracy;
};

struct Report {
  std::string title;
  double target_overlap = 0;
  bool has_reference = false;
  Outbox outbox;
  Flight flight;
  std::vector<StripResult> strips;
  std::optional<FlightInfo> info;
  std::map<std::int64_t, KeyframeLook> looks;
  std::vector<Missing> missing;
  std::map<std::int64_t, ImageQuality> image_quality;
  std::optional<ScoreFile> score;
  std::vector<std::string> tables;  ///< CSV files of the flight
};

/// Sums that both writers need.
struct ReportTotals {
  std::size_t keyframes = 0, posed = 0, with_depth = 0;
  std::size_t products = 0, over_grant = 0;
  std::uint64_t product_bytes = 0, received_bytes = 0;
  std::size_t files_used = 0, files_skipped = 0;
  std::size_t events_medium = 0, events_high = 0;
  double product_pixels = 0;  ///< of the images of keyframes with an image product
};
[[nodiscard]] ReportTotals totals(const Report& report);

/// The ground that the keyframe's image shows, on the strip's map (export/footprint.hpp); empty without a map.
[[nodiscard]] std::vector<Vec3> footprint_of(const Keyframe& keyframe, const StripResult& strip);

/// One phrase per keyframe on what became of it.
[[nodiscard]] std::string keyframe_verdict(const Keyframe& keyframe);
[[nodiscard]] bool over_grant(const ProductAccount& product);

[[nodiscard]] std::string report_json(const Report& report);
[[nodiscard]] std::string report_html(const Report& report);

}  // namespace ilp::ground
