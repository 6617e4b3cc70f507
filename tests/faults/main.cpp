// ilp-faults: campaigns of faults against the flight software. One command prints one table.

#include <unistd.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <filesystem>
#include <string>

#include "tests/faults/campaigns.hpp"

int main(int argc, char** argv) {
  namespace fs = std::filesystem;
  using namespace ilp::faults;
  CampaignOptions options;
  std::string campaign;
  std::string world;
  bool packets = false;
  CLI::App app("Flies small flights with faults, and prints the results. Exit status 1: a promise is broken");
  app.add_option("campaign", campaign)->required()->check(CLI::IsMember({"storage", "memory", "calls", "files"}));
  app.add_option("--trials", options.trials, "number of trials")->check(CLI::PositiveNumber);
  app.add_option("--seed", options.seed, "seed of all random numbers; each trial has its own seed");
  app.add_option("--trial", options.only, "number of a single trial, which is described in full");
  app.add_option("--jobs", options.jobs, "number of processes")->check(CLI::Range(1, 64));
  app.add_flag("--list", options.list, "print every trial that breaks the promise");
  app.add_option("--part", options.part,
                 "memory: only parts whose names begin so; files: only one, burst, seconds, full or flips");
  app.add_flag("--packets", packets, "send telemetry in packets and files by CFDP, not to an outbox");
  app.add_option("--world", world, "folder that keeps the rendered images");
  CLI11_PARSE(app, argc, argv);

  // In memory: thousands of commits are synchronised.
  std::string folder = (access("/dev/shm", W_OK) == 0 ? "/dev/shm" : "/tmp") + std::string("/ilp-faults-XXXXXX");
  if (mkdtemp(folder.data()) == nullptr) return 2;
  options.folder = folder;
  bool good = false;
  try {
    const fs::path images = world.empty() ? options.folder / "world" : fs::path(world);
    prepare_world(images);
    prepare_process(packets ? Downlinks::packets : Downlinks::outbox);
    if (campaign == "calls") {
      good = failing_calls(images, options, packets);
    } else {
      const Reference reference = fly_reference(images, options.folder / "reference");
      if (options.list) {
        std::printf("The undisturbed flight: %lld minor frames, %zu records, %zu files\n",
                    static_cast<long long>(reference.frames), reference.results.records.size(),
                    reference.results.files.size());
        std::fflush(stdout);
      }
      good = campaign == "storage" ? bits_in_storage(reference, options)
             : campaign == "files" ? failing_files(reference, options)
                                   : bits_in_memory(reference, options);
    }
  } catch (const std::exception& error) {
    std::fprintf(stderr, "ilp-faults: %s\n", error.what());
  }
  std::error_code ignored;
  fs::remove_all(folder, ignored);
  return good ? 0 : 1;
}
