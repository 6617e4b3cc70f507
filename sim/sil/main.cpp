// ilp-sil: flies the flight software on simulated or recorded images, in virtual time as fast as the host allows, or in
// real time with a packet link to other programs.

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <iostream>
#include <memory>
#include <set>
#include <stdexcept>
#include <string>
#include <vector>

#include "fsw/base/math.hpp"
#include "sim/host/command_line.hpp"
#include "sim/host/files.hpp"
#include "sim/host/reference_cameras.hpp"
#include "sim/host/strip.hpp"
#include "sim/host/version_line.hpp"
#include "sim/sil/flight_folder.hpp"
#include "sim/sil/image_source.hpp"
#include "sim/sil/real_time.hpp"
#include "sim/sil/scenario_options.hpp"
#include "sim/sil/sil_flight.hpp"
#include "sim/world/render_flight.hpp"

namespace ilp::sil {
namespace {

namespace fs = std::filesystem;

struct CommandLine {
  SourceOptions source;
  FlightOptions flight;
  ScenarioOptions scenario;
  std::string reference;
  bool memory_map = false;
  bool render_only = false;
  bool list_scenarios = false;
  bool list_parameters = false;

  [[nodiscard]] bool recorded() const { return !source.images.empty() || !source.y4m.empty(); }
};

void describe_options(CLI::App& app, CommandLine& line) {
  SourceOptions& source = line.source;
  FlightOptions& flight = line.flight;
  ScenarioOptions& scenario = line.scenario;
  app.add_option(
      "--scenario", scenario.scenario,
      "simulated flight: a name of --list-scenarios or a file (" + std::string(world::default_scenario) + ")");
  app.add_option("--set", scenario.set, "section.name=value: changes the scenario; may be repeated")
      ->allow_extra_args(false);
  app.add_option("--seed", scenario.seed, "seed of the world, the wind, the sensor noise and every random choice");
  app.add_option("--frames", scenario.frames, "number of frames of the simulated flight");
  app.add_option(
      "--images", source.images,
      "folder of PNG, PGM, JPEG or TIFF images; its times.txt has a line `time_ns name` per image, without it "
      "the times are those of EXIF, or two seconds apart");
  app.add_option("--y4m", source.y4m, "YUV4MPEG2 file, - for standard input");
  app.add_option("--frame-rate", source.frame_rate_hz, "frames per second of a video whose header states none")
      ->check(CLI::Range(0.001, 100000.0))
      ->default_str("");
  app.add_option("--camera", source.camera,
                 "intrinsics: COLMAP's cameras.txt, or YAML of OpenCV, ROS or Kalibr; without them the flight "
                 "estimates them from the images, which works over relief only");
  app.add_option("--reference", line.reference,
                 "reference poses for ilp-score and ilp-ground; ilp-sil only checks them before the flight");
  app.add_option("--navigation", source.navigation, "the vehicle's measurements, a CSV file (docs/navigation.md)");
  app.add_option("--map", flight.map, "folder with the tiles of an orbiter's map (docs/map-relative.md)");
  app.add_option("--exif-sigma", source.exif_sigma_m,
                 "one sigma in metres of the positions that EXIF states without an error; 0: they are not used")
      ->check(CLI::Range(0.0, 10000.0));
  app.add_flag(
      "--exif-oblique", source.exif_oblique,
      "images with positions in EXIF do not look straight down: the vertical is estimated from their positions alone");
  app.add_option("--mission", flight.mission_file, "mission parameters, an .ini file");
  app.add_option(
      "--telecommands", flight.telecommands,
      "file of telecommands, one per line: SENT_S capture AT_S, SENT_S place LONGITUDE LATITUDE METRES, or SENT_S "
      "refine KEYFRAME; times in seconds");
  app.add_option("--out", source.out, "folder for everything that the flight leaves");
  app.add_option("--threads", source.threads, "number of threads that render; 0: one per core");
  app.add_option("--power-cut-after", flight.power_cut_after,
                 "number of minor frames after which the process dies (for tests)")
      ->default_str("");
  app.add_flag("--real-time", flight.real_time, "mission time runs with the clock of the host and is tied to UTC");
  app.add_option(
      "--link-udp", flight.link_udp,
      "ADDRESS:PORT: telecommands and telemetry are space packets over UDP, and files go by CFDP; needs --real-time, "
      "and flies until SIGTERM (docs/links.md)");
  app.add_option(
      "--link-udp-peer", flight.link_udp_peer,
      "ADDRESS:PORT of the only station that telemetry goes to (default: every station that has sent something)");
  app.add_option("--link-tcp", flight.link_tcp, "ADDRESS:PORT: the same over TCP");
  app.add_option("--cfdp-udp", flight.cfdp_udp,
                 "ADDRESS:PORT: CFDP PDUs are sent bare on this port, not in space packets");
  app.add_option("--key", flight.key_file,
                 "file with the keys of telecommand authentication; [link] authentication turns it on");
  app.add_option("--cfdp-udp-peer", flight.cfdp_udp_peer, "ADDRESS:PORT to which PDUs are sent");
  app.add_flag("--resume", flight.resume, "continue the flight whose database is in --out");
  app.add_flag("--render-only", line.render_only, "write the simulated images and their truth to OUT/flight, and stop");
  app.add_flag("--list-scenarios", line.list_scenarios, "print the names of scenarios, and exit");
  app.add_flag("--list-parameters", line.list_parameters, "print what --set can change in the scenario, and exit");
  app.add_flag("--memory-map", line.memory_map, "print every static region of the flight and its size, and exit");
}

world::Scenario scenario_of(const CommandLine& line) {
  if (line.recorded()) return faults_for_recorded_images(line.scenario);
  const fs::path flown = fs::path(line.source.out) / "flight" / "scenario.ini";
  return chosen_scenario(line.scenario, line.flight.resume && fs::exists(flown) ? flown.string() : "");
}

/// A wrong file of reference poses is noticed before the flight, not after it.
void check_reference(const CommandLine& line) {
  if (line.reference.empty()) return;
  std::set<std::string> known;
  for (const host::ReferenceCamera& camera : host::read_reference_cameras(line.reference))
    known.insert(host::image_key(camera.name));
  if (line.source.images.empty()) return;
  const std::vector<host::StripFrame> strip = host::list_strip((fs::path(line.source.images) / "").parent_path());
  const bool any = std::any_of(strip.begin(), strip.end(), [&](const host::StripFrame& frame) {
    return known.contains(host::image_key(frame.file.filename().string()));
  });
  if (!any) {
    throw std::runtime_error("reference poses " + line.reference + " name no image of " + line.source.images +
                             ": the first word of a line is the name of an image, such as " +
                             strip.front().file.filename().string());
  }
}

/// A simulated world has its own sun, and the flight over a map is told where it stands, unless its mission says it.
MissionParameters mission_over(const CommandLine& line, const world::Scenario& scenario) {
  MissionParameters mission;
  if (line.recorded() || line.flight.map.empty()) return mission;
  mission.map_sun_given = true;
  mission.map_sun_azimuth_rad = std::remainder(scenario.world.sun_azimuth_rad, 2 * pi);
  mission.map_sun_elevation_rad = scenario.world.sun_elevation_rad;
  if (scenario.flight.passes > 1 && scenario.flight.pass_sun_azimuth_rad != 0)
    std::cerr
        << "The direction of the sun differs between passes: the flight uses that of the first pass for its map\n";
  return mission;
}

int run(CommandLine& line) {
  if (line.list_scenarios) {
    list_scenarios(std::cout);
    return 0;
  }
  if (line.list_parameters) {
    list_parameters(std::cout, scenario_of(line));
    return 0;
  }
  if (line.recorded() && line.scenario.frames) {
    throw host::WrongUsage(
        "--frames is the number of frames of a simulated flight, and all recorded images are flown: leave it out, or "
        "put "
        "fewer images into the folder");
  }
  check_reference(line);
  if (line.source.out.empty()) throw host::WrongUsage("--out DIR is needed: where the flight leaves its products");
  SourceOptions& source = line.source;
  FlightOptions& flight = line.flight;
  if (flight.linked() && !flight.real_time)
    throw host::WrongUsage(
        "the other end of a link runs on the real clock: --link-udp, --link-tcp and --cfdp-udp need --real-time");
  source.scenario = scenario_of(line);
  flight.faults = fault_plan(source.scenario);
  if (!line.recorded() && !flight.resume) world::check_scenario(source.scenario);
  if (line.render_only) {
    if (line.recorded()) throw host::WrongUsage("--render-only: expected no --images or --y4m beside it");
    prepare_render_folder(source.out);
    render_scenario(source);
    images_are_complete(source.out);
    return 0;
  }
  source.resume = flight.resume;
  flight.out = source.out;
  flight.seed = line.scenario.seed.value_or(source.scenario.flight.seed);
  if (flight.mission_file.empty()) flight.mission_file = source.scenario.mission_file;
  MissionParameters mission = load_mission(flight, mission_over(line, source.scenario));
  source.camera_known = mission.camera_known;
  source.seed = flight.seed;
  source.field_of_view_rad = mission.field_of_view_rad;
  source.triggered = mission.capture_mode != CaptureMode::regular;
  source.real_time = flight.real_time;
  source.sets_exposure = mission.exposure_control;
  prepare_folder(flight.out, flight.resume);
  const std::unique_ptr<ImageSource> images = open_source(source);
  if (!images->camera_known) {
    mission.camera_known = false;
    if (images->field_of_view_sigma_rad &&
        mission.field_of_view_sigma_rad == MissionParameters{}.field_of_view_sigma_rad)
      mission.field_of_view_sigma_rad = *images->field_of_view_sigma_rad;
    std::cerr << "The camera is not known: the flight has to find its intrinsics from the images\n";
  }
  if (!images->navigation.empty()) {
    mission.use_navigation = true;
    if (mission.body == Body::none) mission.body = images->body;
  }
  if (!flight.map.empty()) mission.use_map = true;
  if (flight.real_time) catch_stop_signals();
  return fly(flight, mission, *images);
}

}  // namespace
}  // namespace ilp::sil

int main(int argc, char** argv) {
  try {
    ilp::host::CommandLine app("ilp-sil",
                               "Flies the flight software over simulated or recorded images, in virtual time",
                               "ilp-sil --images photographs --camera cameras.txt --out flight",
                               "Exit status: 0 flown, 1 the work could not be done, 2 wrong call, 3 no keyframe has a "
                               "pose, 4 the images ended before their end");
    ilp::sil::CommandLine line;
    ilp::sil::describe_options(app, line);
    app.set_version_flag("--version", ilp::host::version_line("ilp-sil"));
    if (const auto end = ilp::host::read_command_line(app, argc, argv)) return *end;
    if (line.memory_map) {
      ilp::sil::print_memory_map(std::cout);
      return 0;
    }
    ilp::sil::configure_store_memory();
    return ilp::sil::run(line);
  } catch (const ilp::host::WrongUsage& error) {
    std::cerr << "ilp-sil: " << error.what() << "\n";
    return ilp::host::wrong_usage;
  } catch (const std::exception& error) {
    std::cerr << "ilp-sil: " << error.what() << "\n";
    return 1;
  }
}
