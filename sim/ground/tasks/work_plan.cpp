#include "sim/ground/tasks/work_plan.hpp"

#include <algorithm>
#include <set>
#include <stdexcept>

#include "sim/ground/map/damaged_catalogue.hpp"
#include "sim/ground/tasks/work_result.hpp"
#include "sim/host/files.hpp"

namespace ilp::tasks {
namespace {
namespace fs = std::filesystem;

// A task holds one block in memory: some MiB of coded keyframes, or of painted tiles.
constexpr std::size_t quick_looks_of_a_block = 64, tiles_of_a_block = 256, finishes_of_a_block = 64;

/// A tile of one of the strips.
struct Item {
  std::size_t strip = 0, tile = 0;
};

void remove_packages(const fs::path& folder, WorkKind kind) {
  std::vector<fs::path> old;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder)) {
    if (entry.path().filename().string().starts_with(std::string(name_of(kind)) + "-")) old.push_back(entry.path());
  }
  for (const fs::path& path : old) fs::remove(path);
}

/// Calls `fill(package, begin, end)` for each package with its range of `count` pieces.
template <typename Fill>
std::size_t write_packages(WorkKind kind, std::size_t count, std::size_t tasks, const fs::path& out, Fill fill) {
  const fs::path folder = work_folder(out);
  host::make_output_folder(folder);
  remove_packages(folder, kind);
  const std::size_t packages = std::min(tasks, count);
  for (std::size_t k = 0; k < packages; ++k) {
    PackageWriter package(folder / (std::string(name_of(kind)) + "-" + std::to_string(k + 1) + ".work"));
    fill(package, k * count / packages, (k + 1) * count / packages);
    package.close();
  }
  return packages;
}

/// Where the block of pieces that begins at `begin` ends: blocks are of one strip.
std::size_t end_of_block(const std::vector<Item>& items, std::size_t begin, std::size_t end, std::size_t most) {
  std::size_t at = begin;
  while (at < end && at - begin < most && items[at].strip == items[begin].strip) ++at;
  return at;
}

std::vector<intake::Keyframe> keyframes_of(const std::vector<map::TilePlan>& tiles, const intake::Flight& flight) {
  std::set<std::int64_t> ids;
  for (const map::TilePlan& tile : tiles) ids.insert(tile.keyframes.begin(), tile.keyframes.end());
  std::vector<intake::Keyframe> keyframes;
  for (const std::int64_t id : ids) keyframes.push_back(flight.keyframes.at(id));
  return keyframes;
}

std::vector<Item> tiles_to_paint(const std::vector<StripTiles>& strips, intake::Catalogue& catalogue) {
  std::vector<Item> items;
  for (std::size_t s = 0; s < strips.size(); ++s) {
    const std::vector<map::TilePlan>& tiles = strips[s].plan.tiles;
    for (std::size_t i = 0; i < tiles.size(); ++i) {
      if (!map::known_summary(strips[s].strip_id, tiles[i], catalogue)) items.push_back({s, i});
    }
  }
  return items;
}

std::vector<Item> tiles_to_finish(const std::vector<StripFinish>& strips, intake::Catalogue& catalogue) {
  std::vector<Item> items;
  for (std::size_t s = 0; s < strips.size(); ++s) {
    for (std::size_t i = 0; i < strips[s].tiles.size(); ++i) {
      const map::TileFinish& tile = strips[s].tiles[i];
      if (!catalogue.summary({strips[s].strip_id, tile.place, intake::TileStage::finished}, tile.digest)) {
        items.push_back({s, i});
      }
    }
  }
  return items;
}

FinishBlock finish_block(const StripFinish& strip, const std::vector<Item>& items, std::size_t begin, std::size_t end,
                         intake::Catalogue& catalogue) {
  FinishBlock block{strip.strip_id, strip.cell, {}, {}};
  for (std::size_t i = begin; i < end; ++i) {
    const map::TileFinish& tile = strip.tiles[items[i].tile];
    auto cells = catalogue.cells({strip.strip_id, tile.place}, tile.painted);
    if (!cells) throw map::DamagedCatalogue("a tile of the map cannot be read back");
    block.tiles.push_back(tile);
    block.painted.push_back(std::move(*cells));
  }
  return block;
}

}  // namespace

std::size_t plan_quick_looks(const intake::Flight& flight, const std::vector<std::int64_t>& ids, std::size_t tasks,
                             const fs::path& out) {
  const std::int32_t width_px = map::quick_look_width_px(flight.keyframes.size());
  const auto fill = [&](PackageWriter& package, std::size_t begin, std::size_t end) {
    for (std::size_t at = begin; at < end; at += quick_looks_of_a_block) {
      QuickLookBlock block{width_px, {}};
      for (std::size_t i = at; i < std::min(at + quick_looks_of_a_block, end); ++i) {
        block.keyframes.push_back(flight.keyframes.at(ids[i]));
      }
      package.add(block);
    }
  };
  return write_packages(WorkKind::quick_looks, ids.size(), tasks, out, fill);
}

std::size_t plan_tiles(const intake::Flight& flight, const std::vector<StripTiles>& strips,
                       intake::Catalogue& catalogue, std::size_t tasks, const fs::path& out) {
  const std::vector<Item> items = tiles_to_paint(strips, catalogue);
  const auto fill = [&](PackageWriter& package, std::size_t begin, std::size_t end) {
    for (std::size_t at = begin, next = begin; at < end; at = next) {
      next = end_of_block(items, at, end, tiles_of_a_block);
      const StripTiles& strip = strips[items[at].strip];
      TileBlock block{strip.strip_id, strip.plan.cell, {}, {}};
      for (std::size_t i = at; i < next; ++i) block.tiles.push_back(strip.plan.tiles[items[i].tile]);
      block.keyframes = keyframes_of(block.tiles, flight);
      package.add(block);
    }
  };
  return write_packages(WorkKind::tiles, items.size(), tasks, out, fill);
}

std::size_t plan_finish(const std::vector<StripFinish>& strips, intake::Catalogue& catalogue, std::size_t tasks,
                        const fs::path& out) {
  const std::vector<Item> items = tiles_to_finish(strips, catalogue);
  const auto fill = [&](PackageWriter& package, std::size_t begin, std::size_t end) {
    for (std::size_t at = begin, next = begin; at < end; at = next) {
      next = end_of_block(items, at, end, finishes_of_a_block);
      package.add(finish_block(strips[items[at].strip], items, at, next, catalogue));
    }
  };
  return write_packages(WorkKind::finish, items.size(), tasks, out, fill);
}

}  // namespace ilp::tasks
