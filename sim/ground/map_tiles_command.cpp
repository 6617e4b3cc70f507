#include "sim/ground/map_tiles_command.hpp"

#include <CLI/CLI.hpp>
#include <iostream>
#include <string>
#include <vector>

#include "fsw/localisation/sun.hpp"
#include "sim/ground/console/utc_text.hpp"
#include "sim/ground/maps/earlier_flight.hpp"
#include "sim/ground/maps/map_tiles.hpp"
#include "sim/host/command_line.hpp"

namespace ilp::ground {
namespace {

struct Words {
  std::string from, body;
  std::int64_t strip = 0;
  std::string sun, flight_sun;
  std::vector<double> area;
  bool as_imaged = false;
  std::optional<double> place_sigma_m;
};

void add_sources(CLI::App& app, Words& words, maps::MapTilesOptions& options) {
  auto* const from = app.add_option(
      "--from", words.from,
      "an earlier flight, or its results of ilp-ground, whose orthoimage, heights and error of the place are used");
  app.add_option("--strip", words.strip, "strip of that flight (default: the first)")
      ->needs(from)
      ->check(CLI::Range(1, 1000000))
      ->default_str("");
  auto* const image =
      app.add_option("--image", options.image, "orthoimage: a raster of one band that GDAL reads")->excludes(from);
  app.add_option("--heights", options.heights, "terrain model of the same ground, in metres")
      ->excludes(from)
      ->needs(image);
  app.add_option("--sun", words.sun,
                 "AZIMUTH,ELEVATION of the sun of the image, degrees clockwise from north, or when it was taken, UTC: "
                 "2016-05-26T15:04:52")
      ->required();
  app.add_option("--flight-sun", words.flight_sun,
                 "the same at the hour of the flight: features are for this light (default: --sun)");
  app.add_option("--body", words.body, "the body; what the rasters state must agree")
      ->check(CLI::IsMember({"mars", "titan", "venus", "moon", "earth"}));
  app.add_option("--area", words.area, "WEST,SOUTH,EAST,NORTH, degrees (default: all that both rasters cover)")
      ->delimiter(',')
      ->expected(4);
}

void add_numbers(CLI::App& app, Words& words, maps::MapTilesOptions& options) {
  app.add_option("--pixel", options.pixel_m,
                 "ground size of a pixel of the map, m: about 4.5 times that of the flight's images")
      ->required()
      ->check(CLI::Range(0.001, 100000.0));
  app.add_option("--coarse", options.coarse,
                 "ratio of the pixel size of the second layer to that of the first; 1: no second layer")
      ->check(CLI::Range(1, 64));
  app.add_option("--place-sigma", words.place_sigma_m,
                 "how far the whole map may be off on the body, one sigma per axis, m (default: 0; with --from the "
                 "error of the flight's model)")
      ->check(CLI::Range(0.0, 1e6));
  app.add_option("--height-sigma", options.height_sigma_m, "error of the heights, one sigma, m (default: 0.3 pixels)")
      ->check(CLI::Range(0.0, 1e5));
  app.add_option("--image-sigma", options.image_sigma, "noise of the image, grey levels of which 128 is its mean")
      ->check(CLI::Range(0.0, 255.0));
  app.add_option("--ambient", options.ambient, "share of the light on level ground that comes from the sky")
      ->check(CLI::Range(0.0, 0.95));
  app.add_option("--features", options.features, "features of a tile; 0: no start without a place")
      ->check(CLI::Range(std::size_t{0}, limits::max_map_features));
  app.add_option("--image-bits", options.image_bits, "bits per pixel of the image")->check(CLI::Range(0.05, 4.0));
  app.add_flag("--as-imaged", words.as_imaged, "leave the light of the image as it is");
  app.add_option("--key", options.key, "file of keys of the flight; the directory is signed with its first key");
  app.add_option("--out", options.out, "folder for the map")->required();
}

Body body_named(const std::string& name) {
  return static_cast<Body>(find_value(values_of(Body{}), name.c_str())->number);
}

/// Degrees, or a time as days since 2000-01-01 12:00.
struct SunWords {
  double azimuth_deg = 0, elevation_deg = 0;
  std::optional<double> days;
};
SunWords read_sun(const std::string& option, const std::string& text) {
  const std::size_t comma = text.find(',');
  SunWords sun;
  if (comma == std::string::npos) {
    const std::optional<UtcNs> instant = text[0] == '+' ? std::nullopt : console::parse_instant(text, 0);
    if (instant) {
      sun.days = days_since_2000(0, *instant);
      return sun;
    }
  } else if (CLI::detail::lexical_cast(text.substr(0, comma), sun.azimuth_deg) &&
             CLI::detail::lexical_cast(text.substr(comma + 1), sun.elevation_deg)) {
    return sun;
  }
  throw std::runtime_error(option + " is '" + text +
                           "': AZIMUTH,ELEVATION in degrees expected, or a time of UTC such as 2016-05-26T15:04:52");
}

void read_words(const Words& words, maps::MapTilesOptions& options) {
  const SunWords sun = read_sun("--sun", words.sun);
  options.sun_azimuth_deg = sun.azimuth_deg;
  options.sun_elevation_deg = sun.elevation_deg;
  options.sun_days = sun.days;
  options.flat = !words.as_imaged;
  if (!words.flight_sun.empty()) {
    const SunWords flight = read_sun("--flight-sun", words.flight_sun);
    options.flight_sun_days = flight.days;
    if (!flight.days)
      options.flight_sun = maps::sun_of("--flight-sun", flight.azimuth_deg, flight.elevation_deg, options.ambient);
  }
  if (!words.area.empty()) options.area = maps::Extent{words.area[0], words.area[1], words.area[2], words.area[3]};
  if (!words.body.empty()) options.body = body_named(words.body);
  options.place_sigma_m = words.place_sigma_m.value_or(0);
  if (words.from.empty()) return;
  const maps::EarlierModel model = maps::earlier_model(words.from, words.strip);
  options.image = model.image;
  options.heights = model.heights;
  if (!words.place_sigma_m && !model.place_sigma_m) {
    throw std::runtime_error("--from " + words.from + ": how far the model may be off as a whole is not known (" +
                             model.place + "): --place-sigma METRES says it");
  }
  options.place_sigma_m = words.place_sigma_m ? *words.place_sigma_m : *model.place_sigma_m;
}

}  // namespace

int map_tiles_main(int argc, char** argv) {
  host::CommandLine app(
      "ilp-ground map-tiles",
      "Makes the map that a flight carries, tiles and a directory, from an orthoimage and a terrain model",
      "ilp-ground map-tiles --image ortho.tif --heights dtm.tif --sun 2016-05-26T15:04:52 --pixel 5 --out map");
  maps::MapTilesOptions options;
  Words words;
  add_sources(app, words, options);
  add_numbers(app, words, options);
  if (const auto end = host::read_command_line(app, argc - 1, argv + 1)) return *end;
  if (words.from.empty() && (options.image.empty() || options.heights.empty())) {
    std::cerr << "ilp-ground map-tiles: --image and --heights, or --from, expected\n";
    return host::wrong_usage;
  }
  try {
    read_words(words, options);
    for (const std::string& line : maps::make_map_tiles(options, std::cerr)) std::cout << line << "\n";
    return 0;
  } catch (const std::exception& error) {
    std::cerr << "ilp-ground map-tiles: " << error.what() << "\n";
    return 1;
  }
}

}  // namespace ilp::ground
