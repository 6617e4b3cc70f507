#include "sim/ground/flight_options.hpp"

namespace ilp::ground {

void add_flight_options(CLI::App& app, GroundOptions& options) {
  app.add_option("--acknowledge", options.acknowledge, "folder for acknowledgements to the flight");
  app.add_option("--score", options.score,
                 "score.json of ilp-score; the report then compares the flight with the truth");
  app.add_option("--anchor", options.anchor, "JSON file that says on which body and where the strips were flown");
  app.add_option("--map", options.map,
                 "folder of the orbiter's map that the flight carried: the report draws the fixes on this map");
  app.add_option(
      "--landing-sites", options.landing,
      "FOOTPRINT_M[,SLOPE_DEG,STEP_M] of a lander: maps of slope, roughness, largest step and probability of "
      "safety, and the best sites (default: 10 degrees, a tenth of the footprint)");
  app.add_option("--title", options.title, "title of the report, such as the place or the mission");
}

}  // namespace ilp::ground
