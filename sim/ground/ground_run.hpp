// The ground station's work on one flight, from the outbox to the report.
#pragma once

#include <filesystem>
#include <iosfwd>
#include <string>

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
  std::filesystem::path images;       ///< the original images
  std::filesystem::path score;        ///< score.json of ilp-score
  std::string catalogue;              ///< address of a shared catalogue (export/shared_catalogue.hpp)
  std::string mission;                ///< name in it; empty: the title
  std::string title;
  bool afresh = false;                 ///< forget what was taken in and computed before
  double target_overlap = 0;           ///< 0: what the database or the flight info says, else unknown
  std::size_t max_vertices = 1100000;  ///< of one model: 45 MB
};

/// Takes in what is new in the outbox, computes what depends on it, and writes everything under `options.out`. What
/// came before is in the catalogue there (catalogue.hpp), and counts even where the outbox has been emptied since. The
/// returned report is what report.json says. Progress and skipped files go
/// to `messages`, one line each. Throws std::runtime_error with a message for the user; also when nothing usable came
/// down.
report::Report run_ground(const GroundOptions& options, std::ostream& messages);

}  // namespace ilp::ground
