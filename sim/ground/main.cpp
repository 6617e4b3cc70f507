// ilp-ground: what came down becomes elevation maps, a surface model, poses and a report.

#include <CLI/CLI.hpp>
#include <chrono>
#include <iostream>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "sim/ground/compare_command.hpp"
#include "sim/ground/console/console_main.hpp"
#include "sim/ground/ground_run.hpp"
#include "sim/ground/intake/outbox_reader.hpp"
#include "sim/ground/map/damaged_catalogue.hpp"
#include "sim/ground/map_check_command.hpp"
#include "sim/ground/map_tiles_command.hpp"
#include "sim/ground/merge_command.hpp"
#include "sim/ground/received_flight.hpp"
#include "sim/ground/serve/serve_main.hpp"
#include "sim/ground/tasks/worker.hpp"
#include "sim/ground/work_steps.hpp"
#include "sim/host/command_line.hpp"
#include "sim/host/text_format.hpp"
#include "sim/host/version_line.hpp"

namespace {
using namespace ilp;
using ground::GroundOptions;

int run_once(const GroundOptions& options) {
  try {
    std::optional<std::vector<std::string>> lines = ground::summary_if_unchanged(options, std::cerr);
    if (!lines) {
      ground::naming_catalogue(options,
                               [&] { lines = ground::summary_of(options, ground::run_ground(options, std::cerr)); });
    }
    for (const std::string& line : *lines) std::cout << line << "\n";
    return 0;
  } catch (const std::exception& error) {
    std::cerr << "ilp-ground: " << error.what() << "\n";
    return 1;
  }
}

int plan(const GroundOptions& options, const std::string& kind, std::size_t count) {
  try {
    ground::naming_catalogue(
        options, [&] { std::cout << ground::plan_work(options, *tasks::kind_of(kind), count, std::cerr) << "\n"; });
    return 0;
  } catch (const std::exception& error) {
    std::cerr << "ilp-ground: " << error.what() << "\n";
    return 1;
  }
}

/// ilp-ground work PACKAGE --out DIR
int work_main(int argc, char** argv) {
  CLI::App app{"Does the work of a package that ilp-ground --plan has written (ilp-ground merge does both)"};
  std::string package, out;
  tasks::WorkParams params;
  app.add_option("package", package, "file below DIR/work")->required();
  app.add_option("--out", out, "folder for the results of the run, DIR")->required();
  app.add_option("--threads", params.threads, "threads; 0: one per core")->check(CLI::Range(0, 1024));
  if (const auto end = ilp::host::read_command_line(app, argc, argv)) return *end;
  try {
    const tasks::WorkDone done = tasks::do_work(package, out, params);
    std::cout << host::counted(done.pieces, "piece") << " of work done, " << done.before << " of them before\n";
    return 0;
  } catch (const map::DamagedCatalogue& part) {
    std::cerr << "ilp-ground: " << package << " is damaged: " << part.what() << "; plan the work again\n";
    return 1;
  } catch (const std::exception& error) {
    std::cerr << "ilp-ground: " << error.what() << "\n";
    return 1;
  }
}

/// Names, sizes and times of the files: what changes when something comes.
std::string state_of(const std::filesystem::path& folder) {
  std::string state;
  for (const std::filesystem::path& path : intake::files_of(folder)) {
    std::error_code error;
    state += path.filename().string() + " " + std::to_string(std::filesystem::file_size(path, error)) + " " +
             std::to_string(std::filesystem::last_write_time(path, error).time_since_epoch().count()) + "\n";
  }
  return state;
}

int follow(GroundOptions options, int seconds) {
  std::string known;
  while (true) {
    try {
      const std::string state = state_of(options.outbox);
      if (state != known) {
        (void)run_once(options);
        options.afresh = false;
      }
      known = state;
    } catch (const std::exception& error) {
      std::cerr << "ilp-ground: " << error.what() << "\n";
    }
    std::this_thread::sleep_for(std::chrono::seconds(seconds));
  }
}

}  // namespace

int main(int argc, char** argv) {
  if (argc > 1 && std::string(argv[1]) == "console") return ilp::console::console_main(argc - 1, argv + 1);
  if (argc > 1 && std::string(argv[1]) == "serve") return ilp::serve::serve_main(argc - 1, argv + 1);
  if (argc > 1 && std::string(argv[1]) == "merge") return ilp::ground::merge_main(argc, argv);
  if (argc > 1 && std::string(argv[1]) == "compare") return ilp::ground::compare_main(argc, argv);
  if (argc > 1 && std::string(argv[1]) == "map-tiles") return ilp::ground::map_tiles_main(argc, argv);
  if (argc > 1 && std::string(argv[1]) == "map-check") return ilp::ground::map_check_main(argc, argv);
  if (argc > 1 && std::string(argv[1]) == "work") return work_main(argc - 1, argv + 1);
  CLI::App app{"Decodes the files of a downlink, merges them into one model per strip, and writes a report"};
  app.footer(
      "ilp-ground merge does the same in tasks on several processors or machines; see ilp-ground merge --help\n"
      "ilp-ground compare MAP OTHER measures the height differences to another terrain model; see ilp-ground compare "
      "--help\n"
      "ilp-ground map-tiles makes the map that a flight carries; see ilp-ground map-tiles --help\n"
      "ilp-ground map-check FLIGHT MAP tries a map on a flight that came down; see ilp-ground map-check --help\n"
      "ilp-ground serve FOLDER shows a live flight in a browser; see ilp-ground serve --help\n"
      "ilp-ground console ADDRESS:PORT operates a "
      "flight over its link; see ilp-ground console --help");
  GroundOptions options;
  app.add_option("outbox", options.outbox, "folder with the files that came down (.ilp, .jp2)")->required();
  app.add_option("--out", options.out, "folder for the results")->required();
  const auto truth =
      app.add_option("--truth", options.truth, "folder of the simulator's truth: poses.txt and depth/NAME.pfm");
  app.add_option("--reference", options.reference, "reference poses of a recorded strip, in the camera text format")
      ->excludes(truth);
  app.add_option("--flight-db", options.flight_db,
                 "onboard database, which shows what was not sent down; it is only read");
  app.add_option("--flight-info", options.flight_info, "JSON file of ilp-sil with the cost of the run");
  app.add_option("--acknowledge", options.acknowledge, "folder for acknowledgements to the flight");
  app.add_option("--images", options.images, "folder of the original images, which show what compression has lost");
  app.add_option("--colour", options.colour,
                 "folder of the photographs in colour that flew in grey: a colour orthoimage of each strip");
  app.add_option("--score", options.score,
                 "score.json of ilp-score; the report then compares the flight with the truth");
  app.add_flag("--afresh", options.afresh,
               "forget everything that earlier runs read and computed in the folder for the results");
  app.add_flag("--check", options.check,
               "read all files of the results, to find damage that has left their sizes and times as they were");
  app.add_option("--anchor", options.anchor, "JSON file that says on which body and where the strips were flown");
  app.add_option("--control-points", options.control,
                 "CSV file of ground control points and their marks in images: they place, scale and level the map")
      ->excludes(app.get_option("--anchor"));
  app.add_option("--control-body", options.control_body, "body of control points in longitude and latitude")
      ->check(CLI::IsMember({"mars", "titan", "venus", "moon", "earth"}));
  app.add_option("--control-crs", options.control_crs,
                 "coordinate system of the control points' x and y, such as EPSG:32633");
  app.add_option("--geoid", options.geoid,
                 "heights of control points are above the geoid: its height above the ellipsoid in metres, or a raster "
                 "of it such as egm96_15.gtx");
  app.add_flag("--control-original", options.control_original,
               "control points are marked in the photographs as they came, also where smaller ones flew");
  app.add_option(
      "--landing-sites", options.landing,
      "FOOTPRINT_M[,SLOPE_DEG,STEP_M] of a lander: maps of slope, roughness, largest step and probability of "
      "safety, and the best sites (default: 10 degrees, a tenth of the footprint)");
  app.add_option("--title", options.title, "title of the report, such as the place or the mission");
  app.add_option("--catalogue", options.catalogue,
                 "postgresql://USER@HOST/DATABASE: keep the catalogue there, where missions share it, with footprints");
  app.add_option("--mission", options.mission, "name of the mission in that catalogue (default: the title)");
  app.add_option("--target-overlap", options.target_overlap, "target overlap that the plot shows, 0 to 1")
      ->check(CLI::Range(0.0, 1.0));
  const auto vertices = app.add_option("--max-vertices", options.max_vertices, "most vertices of one surface model")
                            ->check(CLI::Range(100, 100000000));
  std::string keep = "all";
  app.add_option("--keep", keep,
                 "all (default); or maps: not what other files have already (PFM, model.ply, the catalogue), and a "
                 "surface of 80 000 vertices")
      ->check(CLI::IsMember({"all", "maps"}));
  std::string holes = "laid";
  app.add_option("--holes", holes,
                 "ground that images show without a height: laid (default: the pages show it hatched, on interpolated "
                 "heights) or open; heights and their errors never have it, and laid.tif has its grey")
      ->check(CLI::IsMember({"laid", "open"}));
  int follow_s = 0;
  app.add_option("--follow", follow_s,
                 "seconds between two looks for new files; the program then runs until it is ended")
      ->check(CLI::Range(1, 86400));
  std::string planned;
  app.add_option("--plan", planned,
                 "only take in what is new, and write packages of this kind of work for tasks (ilp-ground merge)")
      ->check(CLI::IsMember({"looks", "tiles", "finish"}));
  std::size_t task_count = 1;
  app.add_option("--tasks", task_count, "most packages that --plan writes")->check(CLI::Range(1, 1000));
  app.set_version_flag("--version", ilp::host::version_line("ilp-ground"));
  if (const auto end = ilp::host::read_command_line(app, argc, argv)) return *end;
  options.keep_copies = keep == "all";
  options.lay_holes = holes == "laid";
  if (!options.keep_copies && vertices->count() == 0) options.max_vertices = 80000;
  if (!planned.empty()) return plan(options, planned, task_count);
  return follow_s > 0 ? follow(options, follow_s) : run_once(options);
}
