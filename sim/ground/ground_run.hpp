// The ground station's work on one flight, from the outbox to the report.
#pragma once

#include <filesystem>
#include <iosfwd>
#include <optional>
#include <string>
#include <vector>

#include "sim/ground/report/report.hpp"

namespace ilp::ground {

struct GroundOptions {
  std::filesystem::path outbox;
  std::filesystem::path out;
  // All further ones may be empty.
  std::filesystem::path truth;      ///< folder with poses.txt and depth/NAME.pfm
  std::filesystem::path reference;  ///< camera text file, instead of truth
  std::filesystem::path flight_db;
  std::filesystem::path flight_info;
  std::filesystem::path acknowledge;  ///< folder for acknowledgements
  std::filesystem::path anchor;       ///< where on a body the strips were (export/georeference.hpp)
  std::filesystem::path map;          ///< that the flight carried, for pictures of it (fixes/map_image.hpp)
  bool more_comes = false;            ///< strips that the anchors name may still come
  std::filesystem::path control;      ///< ground control points (control/control_file.hpp)
  std::string control_body;           ///< of their longitudes and latitudes
  std::string control_crs;            ///< of their x and y, such as EPSG:32633
  std::string geoid;                  ///< under their heights: metres or a raster (control/control_system.hpp)
  bool control_original = false;      ///< they are marked in the photographs as they came
  std::filesystem::path images;       ///< the original images
  std::filesystem::path colour;       ///< the photographs in colour (export/colour_ortho.hpp)
  std::filesystem::path score;        ///< score.json of ilp-score
  std::string catalogue;              ///< address of a catalogue that missions share
  std::string mission;                ///< name in it; empty: the title
  std::string title;
  bool afresh = false;        ///< forget what was taken in and computed before
  bool check = false;         ///< read every file of the results, to find damage
  double target_overlap = 0;  ///< 0: what the database or the flight info says, else unknown
  bool lay_holes = true;      ///< the pages show ground without a height on interpolated ground, hatched
  std::string landing;        ///< FOOTPRINT_M[,SLOPE_DEG,STEP_M] of landing sites (landing_safety.hpp)
  /// Also what other results have already: PFM beside GeoTIFF and PNG, model.ply beside model.glb, and the catalogue,
  /// without which a later run reads the outbox again.
  bool keep_copies = true;
  std::size_t max_vertices = 1100000;  ///< of one model: 45 MB
};

/// host::WrongUsage where the results would lie in the downlink: the next run would find them there.
void require_apart(const GroundOptions& options);

/// Takes in what is new in the outbox, computes what depends on it, and writes everything under `options.out`. What
/// came before is in the catalogue there (catalogue.hpp), and counts even where the outbox has been emptied since. The
/// returned report is what report.json says. Progress and skipped files go
/// to `messages`, one line each. Throws std::runtime_error with a message for the user; also when nothing usable came
/// down.
report::Report run_ground(const GroundOptions& options, std::ostream& messages);

/// The options say it, or it follows from the outbox' name.
[[nodiscard]] std::string title_of(const GroundOptions& options);
/// Under which a shared catalogue keeps the flight: the title, unless the options say another.
[[nodiscard]] std::string mission_of(const GroundOptions& options);

/// Lines for the user on what the run has found, and where its pages are.
[[nodiscard]] std::vector<std::string> summary_of(const GroundOptions& options, const report::Report& report);

/// The summary of the run before, where a run would change nothing: the options, all files that they name and the
/// program are what they were then, and all files of the results are as that run left them. Nothing is decoded, and
/// nothing written but missing acknowledgements.
[[nodiscard]] std::optional<std::vector<std::string>> summary_if_unchanged(const GroundOptions& options,
                                                                           std::ostream& messages);

}  // namespace ilp::ground
