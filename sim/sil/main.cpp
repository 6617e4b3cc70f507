// ilp-sil: the flight software over simulated or recorded images, in virtual time, as fast as the host allows.

#include <unistd.h>

#include <CLI/CLI.hpp>
#include <filesystem>
#include <iostream>
#include <memory>

#include "sim/sil/image_source.hpp"
#include "sim/sil/sil_flight.hpp"

int main(int argc, char** argv) {
  using namespace ilp::sim;
  CLI::App app{"Flies the flight software over simulated or recorded images, in virtual time"};
  SourceOptions source;
  FlightOptions flight;
  std::string out;
  std::string mission;
  bool memory_map = false;
  app.add_option("--images", source.images, "folder of PNG or PGM images (times.txt beside them: time_ns name)");
  app.add_option("--y4m", source.y4m, "YUV4MPEG2 file, - for standard input");
  app.add_option("--camera", source.camera, "intrinsics in COLMAP's cameras.txt format (PINHOLE, OPENCV, ...)");
  app.add_option("--mission", mission, "mission parameters, an .ini file");
  app.add_option("--out", out, "folder for everything that the flight leaves");
  app.add_option("--seed", flight.seed, "seed of the world and of every random choice");
  app.add_option("--frames", source.max_frames, "frames of the simulated flight");
  app.add_option("--power-cut-after", flight.power_cut_after, "stop dead after so many minor frames (for tests)");
  app.add_flag("--resume", flight.resume, "go on with the database in --out");
  app.add_flag("--memory-map", memory_map, "print every static region of the flight and its size, and exit");
  CLI11_PARSE(app, argc, argv);

  if (memory_map) {
    print_memory_map(std::cout);
    return 0;
  }
  try {
    if (out.empty()) throw std::runtime_error("--out DIR is needed: where the flight leaves its products");
    source.seed = flight.seed;
    source.out = out;
    source.resume = flight.resume;
    flight.out = out;
    flight.mission_file = mission;
    flight.progress = isatty(STDERR_FILENO) != 0;
    prepare_folder(flight);
    const std::unique_ptr<ImageSource> images = open_source(source);
    return fly(flight, *images);
  } catch (const std::exception& error) {
    std::cerr << "ilp-sil: " << error.what() << "\n";
    return 1;
  }
}
