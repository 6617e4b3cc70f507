// Runs the ground station's work on one flight, from the files of the outbox to the report.
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
  // The members below are optional: an empty path or string means that the option is not given.
  std::filesystem::path truth;      ///< folder with poses.txt and depth/NAME.pfm
  std::filesystem::path reference;  ///< camera text file, instead of `truth`
  std::filesystem::path flight_db;
  std::filesystem::path flight_info;
  std::filesystem::path acknowledge;  ///< folder for acknowledgements
  std::filesystem::path anchor;       ///< file of the strips' positions on a body (export/georeference.hpp)
  std::filesystem::path map;          ///< map that the flight carried, for pictures (fixes/map_image.hpp)
  bool more_comes = false;            ///< accept anchors of strips that have not come down yet
  std::filesystem::path control;      ///< ground control points (control/control_file.hpp)
  std::string control_body;           ///< body of the control points' longitudes and latitudes
  std::string control_crs;            ///< CRS of the control points' x and y, such as EPSG:32633
  std::string geoid;                  ///< geoid height: metres, or a raster file (control/control_system.hpp)
  bool control_original = false;      ///< the marks are in pixels of the original photographs, before binning
  std::filesystem::path images;       ///< folder of the original images
  std::filesystem::path colour;       ///< folder of the colour photographs (export/colour_ortho.hpp)
  std::filesystem::path score;        ///< score.json of ilp-score
  std::string catalogue;              ///< address of a catalogue that several missions share
  std::string mission;                ///< name of the flight in the shared catalogue; empty: the title
  std::string title;
  bool afresh = false;        ///< discard all that earlier runs took in and computed
  bool check = false;         ///< read every result file of the earlier run, to find damage
  double target_overlap = 0;  ///< share of the image, 0 to 1; 0: from the database or the flight info, if they have it
  bool lay_holes = true;      ///< the pages show ground without a measured height on interpolated heights, hatched
  std::string landing;        ///< limits of landing sites: FOOTPRINT_M[,SLOPE_DEG,STEP_M] (landing_safety.hpp)
  /// Keep results that others contain too: PFM beside GeoTIFF and PNG, model.ply beside model.glb, and the catalogue.
  /// Without the catalogue a later run reads the outbox again.
  bool keep_copies = true;
  std::size_t max_vertices = 1100000;  ///< largest number for one strip's surface model: 45 MB
};

/// Throws host::WrongUsage if the results would lie in the downlink's folder, where the next run would read them.
void require_apart(const GroundOptions& options);

/// Takes in new files of the outbox, computes what depends on them, and writes all results under `options.out`. Files
/// of earlier runs are in the catalogue (catalogue.hpp) and are used even if the outbox has been emptied. Returns the
/// content of report.json. Writes progress and skipped files to `messages`, one line each. Throws std::runtime_error
/// with a message for the user, also if nothing usable came down.
report::Report run_ground(const GroundOptions& options, std::ostream& messages);

/// `options.title`, or if it is empty a title from the path of the outbox.
[[nodiscard]] std::string title_of(const GroundOptions& options);
/// The name of the flight in a shared catalogue: `options.mission`, or if it is empty the title.
[[nodiscard]] std::string mission_of(const GroundOptions& options);

/// Lines for the user: what the run has found, and where its pages are.
[[nodiscard]] std::vector<std::string> summary_of(const GroundOptions& options, const report::Report& report);

/// The summary of the earlier run if a new run would change nothing, else none. Nothing would change if the options,
/// the files that they name, the program and all result files are those of the earlier run. Decodes nothing, and writes
/// only missing acknowledgements.
[[nodiscard]] std::optional<std::vector<std::string>> summary_if_unchanged(const GroundOptions& options,
                                                                           std::ostream& messages);

}  // namespace ilp::ground
