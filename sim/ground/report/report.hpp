// The content of the report, and its writers for JSON and the page.
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
  double track_length = 0;    ///< path length over the posed keyframes, strip units
  double flying_height = 0;   ///< median depth, strip units
  double mask_share = 0;      ///< newly seen pixels with a depth divided by all pixels of the posed keyframes
  map::MapGeometry geometry;  ///< grid of the map; the member `grid` may be an overview
  map::MapStatistics map;
  map::SeamMeasure seams;
  map::HeightErrors errors;
  map::HeightErrorParts usual_errors;            ///< medians over the cells of the grid, strip units
  std::map<std::int64_t, map::Balance> balance;  ///< corrections in the orthoimage; key: keyframe id
  exports::ColmapCounts colmap;
  std::optional<StripAccuracy> accuracy;
  std::optional<landing::StripLanding> landing;  ///< none: not asked for
};

struct Report {
  std::string title;
  double target_overlap = unknown;
  bool has_reference = false;
  intake::Outbox outbox;
  intake::Flight flight;
  model::JoinedFlight joined;                  ///< already applied to `flight`
  fixes::FixSummary fixes;                     ///< from the poses before strips were joined; empty without a map
  std::shared_ptr<fixes::MapImage> map;        ///< the map that the flight carried; null: not available
  std::vector<control::StripControl> control;  ///< already applied to `flight`; empty without control points
  std::vector<StripResult> strips;
  std::optional<intake::FlightInfo> info;
  std::map<std::int64_t, map::KeyframeQuickLook>
      quick_looks;  ///< key: keyframe id; without pictures if `whole_quick_look` is set
  /// Returns the quick-look of a keyframe of `quick_looks` with its pictures; may be empty.
  std::function<map::KeyframeQuickLook(std::int64_t)> whole_quick_look;
  std::vector<intake::Missing> missing;
  std::map<std::int64_t, ImageQuality> image_quality;
  std::optional<ScoreFile> score;
  std::vector<std::string> tables;  ///< names of the CSV files
  bool with_copies = true;          ///< copies are kept (is_copy in result_files.hpp)
  bool has_viewer = false;          ///< viewer.html was written
};

/// Totals over all keyframes, products, files and events.
struct ReportTotals {
  std::size_t keyframes = 0, posed = 0, with_depth = 0;
  std::size_t products = 0, over_grant = 0;
  std::uint64_t product_bytes = 0, received_bytes = 0;
  std::size_t files_used = 0, files_skipped = 0;
  std::size_t events_medium = 0, events_high = 0;
  double product_pixels = 0;  ///< total number of pixels of the keyframes with an image product
};
[[nodiscard]] ReportTotals totals(const Report& report);

/// The unit for lengths of a strip: metres if they are known from the flight or an anchor, else strip units.
struct LengthUnit {
  double factor = 1;  ///< length of a strip unit in this unit
  std::string name;
};
[[nodiscard]] LengthUnit length_unit(const Report& report, const StripResult& strip);

/// Text: how the strip ended, or from which strips of the flight it is joined. Empty if no record has come.
[[nodiscard]] std::string strip_end(const Report& report, const intake::Strip& strip);

/// A phrase about the result of a keyframe: what is missing or has failed, if anything.
[[nodiscard]] std::string keyframe_verdict(const intake::Keyframe& keyframe);
[[nodiscard]] bool over_grant(const intake::ProductAccount& product);

/// The quick-look of a keyframe with pictures; an empty one if it has none.
[[nodiscard]] map::KeyframeQuickLook look_of(const Report& report, std::int64_t keyframe_id);

/// Layout of report.json; `indented` is that of nlohmann's dump(1).
enum class JsonStyle { indented, compact };

// The writers work keyframe by keyframe, so that their memory does not grow with the flight.
/// Writes report.json (docs/maps.md). The page contains it in the compact style.
void write_report_json(const Report& report, std::ostream& out, JsonStyle style = JsonStyle::indented);
void write_report_html(const Report& report, std::ostream& out);

// Comparison of decoded images with the originals.

/// PSNR of 8-bit images in dB over the pixels where `mask` is set (`inside`) or not set. An empty mask is set
/// everywhere. NaN if there are no such pixels, infinity if all are equal.
[[nodiscard]] double psnr_db(ImageView<const std::uint8_t> decoded, ImageView<const std::uint8_t> original,
                             const host::Raster<std::uint8_t>& mask, bool inside);

/// Sets image_quality for all keyframes with an original FOLDER/NAME of the same size. An unreadable original gives a
/// remark.
void measure_image_quality(const std::filesystem::path& folder, Report& report);

}  // namespace ilp::report
