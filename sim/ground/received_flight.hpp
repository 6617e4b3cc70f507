// Loads a flight from the ground's catalogue: the first part of every step of the ground's work.
#pragma once

#include <functional>
#include <iosfwd>
#include <memory>

#include "sim/ground/ground_run.hpp"
#include "sim/ground/intake/catalogue.hpp"
#include "sim/ground/map/map_plan.hpp"
#include "sim/ground/run_record.hpp"

namespace ilp::ground {

/// Opens the catalogue of the results: a file in their folder, or the mission's part of the database that the options
/// name. `known_valid`: as in the constructor of Catalogue.
[[nodiscard]] std::unique_ptr<intake::Catalogue> open_catalogue(const GroundOptions& options, bool known_valid);

/// Calls `step`. A DamagedCatalogue becomes a std::runtime_error whose message names the catalogue's file or address.
void naming_catalogue(const GroundOptions& options, const std::function<void()>& step);

/// Opens the catalogue of the results, and takes in new files of the outbox and results of tasks. Sets `before` to the
/// record of the earlier run. Result files that do not match this record are removed, so that they are made again.
/// Throws std::runtime_error if there is neither a catalogue nor a file in the outbox; the page that says so gets its
/// title from `report`.
[[nodiscard]] std::unique_ptr<intake::Catalogue> open_and_take_in(const GroundOptions& options,
                                                                  const report::Report& report, RunRecord& before,
                                                                  std::ostream& messages);

/// Sets outbox, flight, fixes, joined and control of the report from the catalogue. Decodes no product.
void index_held(const GroundOptions& options, intake::Catalogue& catalogue, report::Report& report,
                std::ostream& messages);

/// Does the same as index_held, decodes all products, and sets the quick-looks. Products that cannot be decoded are
/// rejected in the catalogue. Throws std::runtime_error if no file is usable.
void decode_held(const GroundOptions& options, intake::Catalogue& catalogue, report::Report& report,
                 std::ostream& messages);

/// The strips that have keyframes: first the strips with poses, then the others, each in the order of their ids.
[[nodiscard]] std::vector<const intake::Strip*> strips_with_poses_first(const intake::Flight& flight);
/// Digest, ground step and bounds of each keyframe of the strip that has a surface.
[[nodiscard]] map::KeyframeViews views_of(const report::Report& report, const intake::Strip& strip);

}  // namespace ilp::ground
