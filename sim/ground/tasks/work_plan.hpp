// Divides the work of a run into packages for tasks.
#pragma once

#include <cstddef>
#include <filesystem>
#include <vector>

#include "sim/ground/intake/catalogue.hpp"
#include "sim/ground/intake/flight_model.hpp"
#include "sim/ground/map/map_plan.hpp"
#include "sim/ground/map/tile_steps.hpp"
#include "sim/ground/tasks/work_package.hpp"

namespace ilp::tasks {

// Each function writes packages with the work whose results the catalogue does not have, and returns their number N: at
// most `tasks`, fewer if there is less work. The packages are KIND-1.work to KIND-N.work in the work folder of `out`,
// and replace earlier ones of the kind. Neighbours on the ground are in one package, so that few keyframes are decoded
// twice. Throws std::runtime_error if a file cannot be written.

/// Packages for the quick-looks of the keyframes with these ids.
std::size_t plan_quick_looks(const intake::Flight& flight, const std::vector<std::int64_t>& ids, std::size_t tasks,
                             const std::filesystem::path& out);

/// The tiles of one strip's map.
struct StripTiles {
  std::int64_t strip_id = 0;
  map::MapPlan plan;
};
std::size_t plan_tiles(const intake::Flight& flight, const std::vector<StripTiles>& strips,
                       intake::Catalogue& catalogue, std::size_t tasks, const std::filesystem::path& out);

/// The painted tiles of one strip's map that are to be finished.
struct StripFinish {
  std::int64_t strip_id = 0;
  double cell = 0;
  std::vector<map::TileFinish> tiles;
};
/// Packages for finishing tiles. The painted tiles must be in the catalogue.
std::size_t plan_finish(const std::vector<StripFinish>& strips, intake::Catalogue& catalogue, std::size_t tasks,
                        const std::filesystem::path& out);

}  // namespace ilp::tasks
