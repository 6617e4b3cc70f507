// The stage over simulated worlds. Starts without a place: two keyframes at a random place and heading, a map of many
// times the ground that they show, under the sun of another hour, and nothing from the vehicle but its height.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <memory>
#include <vector>

#include "fsw/base/math.hpp"
#include "fsw/localisation/map_fix.hpp"
#include "fsw/shared/local_plane.hpp"
#include "fsw/vision/terrain/cell_depths.hpp"
#include "sim/ground/maps/tile_maker.hpp"
#include "sim/world/orbital_map.hpp"
#include "tests/support/memory_map_source.hpp"
#include "tests/support/step_memory.hpp"
#include "tests/unit/places/place_flight.hpp"
#include "tests/unit/shared/component_fixture.hpp"
#include "tests/unit/vision/map/map_world.hpp"

namespace ilp::test {
namespace {

constexpr int starts = ILP_MAP_STARTS;
constexpr std::uint64_t seed = ILP_MAP_STARTS_SEED;

struct Ground {
  const char* world;
  double pixel_m;
  std::int32_t tiles;   // along a side
  double sun_turn_deg;  // of the map's sun from that of the flight
  bool knows_height;
  double least_share;            // of starts
  std::int32_t known_cells = 0;  // along a side, from the north-western corner of the margin; 0: all
};
void PrintTo(const Ground& ground, std::ostream* out) {
  *out << ground.world << ", " << ground.pixel_m << " m, " << ground.tiles << " tiles along a side, suns "
       << ground.sun_turn_deg << " degrees apart" << (ground.knows_height ? "" : ", no height");
}

/// A map as the ground makes it, in memory; its south-western corner is the world's origin.
class WorldMap {
 public:
  WorldMap(const MapWorld& world, const Ground& ground) : pixel_m_(ground.pixel_m) {
    const double rad = pi / 180, side = ground.pixel_m * map_tile_side;
    world::WorldParams under = world.terrain().params();
    const maps::Sun flight_sun{under.sun_azimuth_rad, under.sun_elevation_rad, under.ambient};
    under.sun_azimuth_rad = std::remainder(under.sun_azimuth_rad + ground.sun_turn_deg * rad, 2 * pi);
    const world::Terrain terrain(under);
    world::OrbitalMapParams params;
    params.pixel_m = ground.pixel_m;
    params.height_sigma_m = 0.3 * ground.pixel_m;
    constexpr std::int32_t margin = 64;
    const double north = side * ground.tiles;
    const std::int32_t cells = ground.tiles * map_tile_side + 2 * margin;
    const auto cut = ground.known_cells > 0 ? ground.known_cells : cells;
    world::OrbitalMap map =
        world::render_orbital_map(terrain, -margin * ground.pixel_m, north + margin * ground.pixel_m, cut, cut, params);
    if (cut < cells) widen(map, cells);
    const auto directory = std::make_unique<MapDirectory>();
    directory->id = 51;
    directory->body = Body::mars;
    directory->light = MapLight::flat;
    directory->sun_azimuth_rad = under.sun_azimuth_rad;
    directory->sun_elevation_rad = under.sun_elevation_rad;
    directory->ambient = under.ambient;
    directory->height_sigma_m = params.height_sigma_m;
    directory->layer_count = 1;
    directory->layers[0] = {ground.pixel_m, 0, north, ground.tiles, ground.tiles};
    maps::TileParams how{.sun = {under.sun_azimuth_rad, under.sun_elevation_rad, under.ambient},
                         .flight_sun = flight_sun};
    maps::TileMaker maker(how);
    for (std::int32_t row = 0; row < ground.tiles; ++row) {
      for (std::int32_t column = 0; column < ground.tiles; ++column) {
        const MapTilePlace place{0, static_cast<std::uint16_t>(row), static_cast<std::uint16_t>(column)};
        const maps::PatchArea area = maps::area_of_tile(row, column);
        maps::MapPatch patch;
        patch.light =
            host::part_of(map.light, area.first_column + margin, area.first_row + margin, area.columns, area.rows);
        patch.posts = host::part_of(map.heights, (area.first_column + margin) / map_post_spacing,
                                    (area.first_row + margin) / map_post_spacing, area.columns / map_post_spacing + 1,
                                    area.rows / map_post_spacing + 1);
        files_.push_back(maker.make(directory->layers[0], place, std::move(patch)).file);
        set_map_id(files_.back(), directory->id);
        bytes_ += files_.back().size();
        MapTileEntry entry;
        entry.digest = map_tile_digest(directory->id, files_.back());
        entry.bytes = static_cast<std::uint16_t>(files_.back().size());
        entry.row = place.row;
        entry.column = place.column;
        static_cast<void>(directory->tiles.push_back(entry));
        places_.push_back(place);
      }
    }
    directory_.resize(max_map_directory_bytes);
    std::size_t size = 0;
    if (!write_map_directory(*directory, {}, directory_, size).ok()) throw std::runtime_error("directory");
    directory_.resize(size);
    for (std::size_t i = 0; i < files_.size(); ++i) tiles_.push_back({places_[i], files_[i]});
  }
  [[nodiscard]] MemoryMapSource source() const { return {directory_, tiles_}; }
  [[nodiscard]] std::size_t bytes() const { return bytes_; }
  [[nodiscard]] double pixel_m() const { return pixel_m_; }

 private:
  /// Nothing is known of the rest.
  static void widen(world::OrbitalMap& map, std::int32_t cells) {
    host::Raster<float> light(cells, cells, maps::not_known);
    host::Raster<float> posts(cells / map_post_spacing + 1, cells / map_post_spacing + 1, maps::not_known);
    const auto put = [](const host::Raster<float>& from, host::Raster<float>& to) {
      for (std::int32_t y = 0; y < from.height; ++y) std::copy_n(&from.at(0, y), from.width, &to.at(0, y));
    };
    put(map.light, light);
    put(map.heights, posts);
    map.light = std::move(light);
    map.heights = std::move(posts);
  }

  double pixel_m_ = 0;
  std::vector<std::uint8_t> directory_;
  std::vector<std::vector<std::uint8_t>> files_;
  std::vector<MapTilePlace> places_;
  std::vector<MemoryMapSource::Tile> tiles_;
  std::size_t bytes_ = 0;
};

class MapWorldTest : public ComponentTest {
 protected:
  void fly_under(const MapWorld& world) {
    mission.use_map = mission.use_navigation = true;
    mission.body = Body::mars;
    mission.map_sun_given = true;
    mission.map_sun_azimuth_rad = world.sun().azimuth_rad;
    mission.map_sun_elevation_rad = world.sun().elevation_rad;
  }
  /// A keyframe of a strip whose world is turned, moved, and of another unit.
  void fly(const MapWorld& world, std::int64_t id, const MapTrial& trial) {
    PlaceFlight flight(store, world.camera());
    if (id == 1) flight.write_camera();
    View view;
    view.camera = world.camera();
    view.image.width = trial.frame.grey.width;
    view.image.height = trial.frame.grey.height;
    view.image.pixels = trial.frame.grey.samples;
    for (const float depth : trial.frame.depth_m.samples) view.depth.push_back(static_cast<double>(depth));
    flight.show(id, 1, static_cast<std::int32_t>(id - 1), view, trial.truth, flight.second_);
    auto pose = read<PoseRecord>(id);
    pose.ground_distance = height_of(world, id, trial).height_m * PlaceFlight::second_unit;
    pose.ground_distance_sigma = 0.01 * pose.ground_distance;
    write(pose);
  }
  static NavigationRecord height_of(const MapWorld& world, std::int64_t id, const MapTrial& trial) {
    NavigationRecord measured{.id = id};
    measured.height_m =
        inverse(trial.truth).translation.z() - world.terrain().height(trial.ground.x(), trial.ground.y());
    measured.height_sigma_m = 0.02 * measured.height_m;
    return measured;
  }
  std::unique_ptr<MapFix> make(MapSource& source) {
    auto stage = std::make_unique<MapFix>(store, mission, step_memory<MapFix>(), &source);
    EXPECT_TRUE(restored(stage->restore()));
    return stage;
  }
  static double error_px(const FixRecord& fix, const MapTrial& trial) {
    return std::hypot(fix.ground_m[0] - trial.ground.x(), fix.ground_m[1] - trial.ground.y()) / fix.pixel_m;
  }
};

class ILP_MAP_STARTS_SUITE : public MapWorldTest, public testing::WithParamInterface<Ground> {};

TEST_P(ILP_MAP_STARTS_SUITE, TwoKeyframesFindTheirPlaceAndNoOther) {
  const Ground& ground = GetParam();
  const MapWorld world(ground.world, seed);
  const WorldMap map(world, ground);
  fly_under(world);
  Rng rng(seed, 51);
  const double span = ground.pixel_m * map_tile_side * ground.tiles, edge = 0.7 * world.altitude_m();
  int led = 0, started = 0, wrong = 0;
  for (int k = 0; k < starts; ++k) {
    std::destroy_at(&store);
    std::construct_at(&store, region);
    const double heading = 2 * pi * rng.uniform(), height = world.altitude_m() * (0.9 + 0.2 * rng.uniform());
    const Vec3 first(edge + rng.uniform() * (span - 2 * edge), edge + rng.uniform() * (span - 2 * edge), height);
    const Vec3 next = first + 0.2 * world.altitude_m() * Vec3(std::cos(heading), std::sin(heading), 0);
    MapTrial trials[2];
    world.look(first, heading, {}, rng, trials[0]);
    world.look(next, heading, {}, rng, trials[1]);
    for (std::int64_t id = 1; id <= 2; ++id) {
      fly(world, id, trials[id - 1]);
      if (ground.knows_height) write(height_of(world, id, trials[id - 1]));
    }
    MemoryMapSource source = map.source();
    run(*make(source), 100000);
    for (std::int64_t id = 1; id <= 2; ++id) {
      const auto fix = read<FixRecord>(id);
      if (fix.verdict != MapVerdict::fixed) continue;
      wrong += error_px(fix, trials[id - 1]) > 2.5 ? 1 : 0;
      led += fix.prior == FixPrior::search ? 1 : 0;
      started += id == 2 && fix.state == FixState::accepted ? 1 : 0;
    }
  }
  const double km2 = span * span / 1e6;
  std::printf(
      "%s map of %.2f m, %.2f km2, %d tiles, %zu bytes a tile, suns %.0f degrees apart%s: %d of %d started, %d "
      "keyframes found by features, %d wrong\n",
      ground.world, ground.pixel_m, km2, ground.tiles * ground.tiles,
      map.bytes() / static_cast<std::size_t>(ground.tiles * ground.tiles), ground.sun_turn_deg,
      ground.knows_height ? "" : ", no height", started, starts, led, wrong);
  EXPECT_EQ(wrong, 0);
  EXPECT_GE(started, std::floor(ground.least_share * starts));
}

/// A strip over a map of 30 image pixels, of which one image shows 21 by 16.
class ILP_MAP_STRIPS_SUITE : public MapWorldTest {
 protected:
  static constexpr std::int64_t last = ILP_MAP_STRIP_KEYFRAMES;

  /// A fifth of the height on with each keyframe. The vehicle's place is off by 7 m, its attitude by half a degree.
  void fly_along(double heading) {
    fly_under(world);
    Rng rng(seed, 52);
    const Vec3 first(150, 1000, world.altitude_m());
    const double step = 0.2 * world.altitude_m();
    for (std::int64_t id = 1; id <= last; ++id) {
      MapTrial& trial = trials.emplace_back();
      const Vec3 way(step * static_cast<double>(id) * std::cos(heading),
                     step * static_cast<double>(id) * std::sin(heading), 0);
      world.look(first + way, heading, {}, rng, trial);
      fly(world, id, trial);
      NavigationRecord measured = height_of(world, id, trial);
      const Vec3 place = inverse(trial.truth).translation + Vec3(5, -5, 0);
      const BodyPlace at = place_from_plane(Body::mars, {}, {place.x(), place.y(), 0});
      measured.longitude_deg = at.longitude_deg;
      measured.latitude_deg = at.latitude_deg;
      measured.horizontal_sigma_m = 5;
      quaternion_from_rotation(trial.prior.camera_from_map.rotation, measured.q_cam_from_level);
      measured.tilt_sigma_rad = measured.heading_sigma_rad = 0.0087;
      write(measured);
      vehicle.push_back(measured);
    }
  }

  const MapWorld world{"mars-plains", seed};
  const WorldMap map{world, {"mars-plains", 30 * world.image_pixel_m(), 1, 34, true, 0, 192}};
  std::vector<MapTrial> trials;
  std::vector<NavigationRecord> vehicle;
};

TEST_F(ILP_MAP_STRIPS_SUITE, KeyframesThatAreTooSmallForTheMapAreFixedTogether) {
  fly_along(0.6);
  MemoryMapSource source = map.source();
  EXPECT_TRUE(run(*make(source), 100000).empty());
  int fixed = 0, wrong = 0;
  for (std::int64_t id = 1; id <= last; ++id) {
    const auto fix = read<FixRecord>(id);
    if (fix.verdict != MapVerdict::fixed) continue;
    EXPECT_GT(id, 3) << "three images hold too little";
    wrong += error_px(fix, trials[static_cast<std::size_t>(id - 1)]) > 1.5 ? 1 : 0;
    fixed += id >= 9 ? 1 : 0;
  }
  std::printf("map of %.2f m: %d of %d keyframes with eight before them fixed, %d wrong\n", map.pixel_m(), fixed,
              static_cast<int>(last - 8), wrong);
  EXPECT_EQ(wrong, 0);
  EXPECT_GE(fixed, 0.8 * static_cast<double>(last - 8));
}

/// Posts of the map are 40 image pixels apart.
TEST_F(ILP_MAP_STRIPS_SUITE, ReliefServesBetweenPostsThatAreFarApart) {
  fly_along(0.6);
  mission.map_senses = 4;
  const WorldMap finer(world, {"mars-plains", 10 * world.image_pixel_m(), 3, 34, true, 0, 640});
  MemoryMapSource source = finer.source();
  EXPECT_TRUE(run(*make(source), 100000).empty());
  int fixed = 0, wrong = 0;
  for (std::int64_t id = 1; id <= last; ++id) {
    const auto fix = read<FixRecord>(id);
    if (fix.verdict != MapVerdict::fixed) continue;
    EXPECT_EQ(fix.sense, MapSense::relief) << id;
    wrong += error_px(fix, trials[static_cast<std::size_t>(id - 1)]) > 2.5 ? 1 : 0;
    ++fixed;
  }
  std::printf("relief on a map of %.2f m: %d of %d keyframes fixed, %d wrong\n", finer.pixel_m(), fixed,
              static_cast<int>(last), wrong);
  EXPECT_EQ(wrong, 0);
  EXPECT_GE(fixed, 0.6 * static_cast<double>(last));
}

/// A first fix on few patches knows the length of the strip's unit to 5 %, the vehicle's heights do to 1 %.
TEST_F(ILP_MAP_STRIPS_SUITE, AFirstFixDoesNotPartTheStrip) {
  fly_along(0.1);
  MemoryMapSource source = map.source();
  EXPECT_TRUE(run(*make(source), 100000).empty());
  std::int64_t first = 0;
  for (std::int64_t id = 1; id <= 9; ++id) {
    const auto fix = read<FixRecord>(id);
    if (first == 0 && fix.verdict == MapVerdict::fixed) first = id;
    if (first == 0) continue;
    EXPECT_EQ(fix.verdict, MapVerdict::fixed) << id << ": " << fix.patches << " patches";
  }
  EXPECT_GT(first, 0);
  EXPECT_LT(first, 8);
}

/// The images before may have been released by then.
TEST_F(ILP_MAP_STRIPS_SUITE, AStopAfterEachKeyframeChangesNothing) {
  fly_along(0.6);
  MemoryMapSource source = map.source();
  run(*make(source), 100000);
  std::vector<FixRecord> whole;
  for (std::int64_t id = 1; id <= last; ++id) whole.push_back(read<FixRecord>(id));

  std::destroy_at(&store);
  std::construct_at(&store, region);
  for (std::int64_t id = 1; id <= last; ++id) {
    fly(world, id, trials[static_cast<std::size_t>(id - 1)]);
    write(vehicle[static_cast<std::size_t>(id - 1)]);
    run(*make(source), 100000);
    FrameRecord released{.id = id};
    write(released);
  }
  int fixed = 0;
  for (const FixRecord& fix : whole) {
    const auto again = read<FixRecord>(fix.id);
    EXPECT_EQ(again.verdict, fix.verdict) << fix.id;
    for (int i = 0; i < 3; ++i) EXPECT_EQ(again.ground_m[i], fix.ground_m[i]) << fix.id;
    fixed += fix.verdict == MapVerdict::fixed ? 1 : 0;
  }
  EXPECT_GT(fixed, 0);
}

#ifdef ILP_MAP_LONG
// The first one is as large for its camera as 12 x 12 km are for one at 1000 m.
const Ground grounds[] = {{"mars-plains", 0.25, 18, 34, true, 16.0 / 18}, {"mars-plains", 0.4, 11, 34, true, 16.0 / 18},
                          {"mars-plains", 0.6, 8, 34, true, 0.8},         {"mars-plains", 0.82, 6, 34, true, 0.5},
                          {"mars-plains", 0.4, 11, 34, false, 0.3},       {"mars-canyon", 1.2, 6, 34, true, 0.8},
                          {"mars-plains", 0.25, 8, 120, true, 0.5}};
#else
const Ground grounds[] = {{"mars-plains", 0.4, 3, 34, true, 2.0 / 3}};
#endif
INSTANTIATE_TEST_SUITE_P(Start, ILP_MAP_STARTS_SUITE, testing::ValuesIn(grounds));

}  // namespace
}  // namespace ilp::test
