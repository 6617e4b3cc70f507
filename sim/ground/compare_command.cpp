#include "sim/ground/compare_command.hpp"

#include <CLI/CLI.hpp>
#include <iostream>
#include <map>
#include <numbers>
#include <string>

#include "sim/ground/compare/comparison.hpp"
#include "sim/host/command_line.hpp"

namespace ilp::ground {

int compare_main(int argc, char** argv) {
  host::CommandLine app("ilp-ground compare",
                        "Lays the map of a flight onto another terrain model, and measures the height differences",
                        "ilp-ground compare flight/ground dtm.tif --out comparison");
  compare::ComparisonOptions options;
  app.add_option("map", options.map, "folder of ilp-ground --out or of sim/fly --out, or a raster of heights")
      ->required();
  app.add_option("other", options.other, "the other terrain model: a raster of heights that GDAL reads")->required();
  app.add_option("--out", options.out, "folder for the results (default: comparison, beside the map)");
  app.add_option("--strip", options.strip, "strip of a flight with several (default: the first)")
      ->check(CLI::Range(1, 1000000))
      ->default_str("");
  const std::map<std::string, compare::Fit> fits{
      {"none", compare::Fit::none}, {"shift", compare::Fit::shift}, {"similarity", compare::Fit::similarity}};
  app.add_option("--fit", options.alignment.fit,
                 "what the alignment may change: none, shift (x, y, height), similarity (also turn and scale)")
      ->transform(CLI::CheckedTransformer(fits))
      ->option_text("none|shift|similarity [shift]");
  double max_slope_deg = 45;
  app.add_option("--max-slope", max_slope_deg, "ground steeper than this is left out, degrees")
      ->check(CLI::Range(1.0, 89.9));
  auto* const poses = app.add_option(
      "--poses", options.frame.poses,
      "poses of the flight's images in the coordinates of the other model, in the format of --reference: aligns a map "
      "that has only the coordinates of its strip");
  app.add_flag("--same-axes", options.frame.same_axes,
               "both models have the same coordinates, whatever the files state")
      ->excludes(poses);
  if (const auto end = host::read_command_line(app, argc - 1, argv + 1)) return *end;
  options.alignment.max_slope_rad = max_slope_deg * std::numbers::pi / 180;
  try {
    for (const std::string& line : compare::summary_of(compare::compare_heights(options))) std::cout << line << "\n";
    return 0;
  } catch (const std::exception& error) {
    std::cerr << "ilp-ground compare: " << error.what() << "\n";
    return 1;
  }
}

}  // namespace ilp::ground
