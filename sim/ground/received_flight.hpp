// The flight as the catalogue holds it: what every step of the ground's work begins with.
#pragma once

#include <functional>
#include <iosfwd>
#include <memory>

#include "sim/ground/ground_run.hpp"
#include "sim/ground/intake/catalogue.hpp"
#include "sim/ground/map/map_plan.hpp"
#include "sim/ground/run_record.hpp"

namespace ilp::ground {

/// The catalogue of the results: a file in their folder, or the mission's part of the database that the options name.
[[nodiscard]] std::unique_ptr<intake::Catalogue> open_catalogue(const GroundOptions& options, bool known_valid);

/// Does `step`. A part of the catalogue that cannot be read back is told with the catalogue's file or address.
void naming_catalogue(const GroundOptions& options, const std::function<void()>& step);

/// Opens the catalogue of the results and takes in what is new in the outbox, and what tasks have left. Throws
/// std::runtime_error when there is nothing at all; `report` has the title for the page that says so.
/// Files of `before` that are not as it says are removed, so that they are made again.
[[nodiscard]] std::unique_ptr<intake::Catalogue> open_and_take_in(const GroundOptions& options,
                                                                  const report::Report& report, RunRecord& before,
                                                                  std::ostream& messages);

/// Sets outbox, flight and joined of the report from what is held; nothing is decoded.
void index_held(const GroundOptions& options, intake::Catalogue& catalogue, report::Report& report,
                std::ostream& messages);

/// The same, with the looks, without the products that do not decode. Throws std::runtime_error when nothing is usable.
void decode_held(const GroundOptions& options, intake::Catalogue& catalogue, report::Report& report,
                 std::ostream& messages);

/// The strips with keyframes, those with poses first.
[[nodiscard]] std::vector<const intake::Strip*> strips_with_poses_first(const intake::Flight& flight);
/// The keyframes of the strip that have a surface.
[[nodiscard]] map::KeyframeViews views_of(const report::Report& report, const intake::Strip& strip);

}  // namespace ilp::ground
