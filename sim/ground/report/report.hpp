// The whole content of the report, gathered before it is written as JSON and as a page.
#pragma once

#include <filesystem>
#include <functional>
#include <iosfwd>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "sim/ground/control/place_by_control.hpp"
#include "sim/ground/export/colmap_model.hpp"
#include "sim/ground/export/strip_exports.hpp"
#include "sim/ground/fixes/fix_summary.hpp"
#include "sim/ground/fixes/map_image.hpp"
#include "sim/ground/intake/flight_info.hpp"
#include "sim/ground/intake/missing.hpp"
#include "sim/ground/landing/landing_files.hpp"
#include "sim/ground/map/keyframe_quick_look.hpp"
#include "sim/ground/map/seam_measure.hpp"
#include "sim/ground/map/strip_map.hpp"
#include "sim/ground/model/joined_model.hpp"
#include "sim/ground/report/accuracy.hpp"
#include "sim/ground/report/score_file.hpp"

namespace ilp::report {

/// Peak signal-to-noise ratio of a decoded image against the original, in dB.
struct ImageQuality {
  double inside_db = unknown;  ///< inside the mask
  double outside_db = unknown;
};

struct StripResult : exports::ExportedStrip {
  std::size_t posed = 0;
  double track_length = 0;    ///< strip units, path over the posed keyframes
  double flying_height = 0;   ///< strip units, median depth
  double mask_share = 0;      ///< newly seen pixels with depth / pixels of the posed keyframes' images
  map::MapGeometry geometry;  ///< of the map itself
  map::MapStatistics map;
  map::SeamMeasure seams;
  map::HeightErrors errors;                      ///< of the heights, beside those of matching
  map::HeightErrorParts usual_errors;            ///< medians over the cells of the grid; strip units
  std::map<std::int64_t, map::Balance> balance;  ///< of the orthoimage, by keyframe
  exports::ColmapCounts colmap;
  std::optional<StripAccuracy> accuracy;
  std::optional<landing::StripLanding> landing;  ///< where it was asked for
};

struct Report {
  std::string title;
  double target_overlap = unknown;
  bool has_reference = false;
  intake::Outbox outbox;
  intake::Flight flight;
  model::JoinedFlight joined;                  ///< already applied to `flight`
  fixes::FixSummary fixes;                     ///< by the poses of the flight; empty without a map
  std::shared_ptr<fixes::MapImage> map;        ///< that the flight carried; none: not at hand
  std::vector<control::StripControl> control;  ///< already applied to `flight`; empty without control points
  std::vector<StripResult> strips;
  std::optional<intake::FlightInfo> info;
  std::map<std::int64_t, map::KeyframeQuickLook>
      quick_looks;  ///< without their pictures, where `whole_quick_look` gives them
  std::function<map::KeyframeQuickLook(std::int64_t)> whole_quick_look;  ///< of a keyframe of `looks`; may be empty
  std::vector<intake::Missing> missing;
  std::map<std::int64_t, ImageQuality> image_quality;
  std::optional<ScoreFile> score;
  std::vector<std::string> tables;  ///< CSV files of the flight
  bool with_copies = true;          ///< model.ply and the PFM files stay
  bool has_viewer = false;          ///< viewer.html lies beside the report
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

/// In what lengths of a strip are told: metres where they are known, by the flight or by an anchor.
struct LengthUnit {
  double factor = 1;  ///< for a unit of the strip
  std::string name;
};
[[nodiscard]] LengthUnit length_unit(const Report& report, const StripResult& strip);

/// How the strip ended, or of which strips of the flight it is joined; empty where no record has come.
[[nodiscard]] std::string strip_end(const Report& report, const intake::Strip& strip);

/// One phrase per keyframe on what became of it.
[[nodiscard]] std::string keyframe_verdict(const intake::Keyframe& keyframe);
[[nodiscard]] bool over_grant(const intake::ProductAccount& product);

/// With pictures; an empty one for a keyframe without a look.
[[nodiscard]] map::KeyframeQuickLook look_of(const Report& report, std::int64_t keyframe_id);

/// `indented` is as nlohmann's dump(1) writes it.
enum class JsonStyle { indented, compact };

// Written keyframe by keyframe, so that their memory does not grow with the flight.
/// docs/maps.md describes it. Of the two styles, the page has the compact one.
void write_report_json(const Report& report, std::ostream& out, JsonStyle style = JsonStyle::indented);
void write_report_html(const Report& report, std::ostream& out);

// Compares decoded images with the originals.

/// PSNR of 8-bit images over the pixels where `mask` (may be empty: everywhere) is set, or not set. NaN when there are
/// no such pixels, infinity when they are all exact.
[[nodiscard]] double psnr_db(ImageView<const std::uint8_t> decoded, ImageView<const std::uint8_t> original,
                             const host::Raster<std::uint8_t>& mask, bool inside);

/// Compares all keyframes that have an original FOLDER/NAME of the same size; an unreadable original becomes a remark.
void measure_image_quality(const std::filesystem::path& folder, Report& report);

}  // namespace ilp::report
